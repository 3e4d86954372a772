//! LPIPS as the user sees it: printed where weights are given, refused where they are bad.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use powergs_sim::cli::{self, Cli, Context, Exit};
use powergs_testkit::lpips::{Kind, Made};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn command(folder: &Path, more: &[&str]) -> Result<Exit, cli::Failure> {
    let path = |name: &str| folder.join(name).display().to_string();
    let mut words = vec!["powergs-sim".to_owned(), "quality".into(), path("a.png"), path("b.png")];
    words.extend(more.iter().map(|w| w.replace('@', &folder.display().to_string())));
    let cli = Cli::try_parse_from(words).unwrap();
    let cancelled = Arc::new(AtomicBool::new(false));
    cli::run(&cli, &Context { global: cli.global.clone(), drawing: Default::default(), cancelled })
}

#[test]
fn the_command_prints_it_with_weights_only() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for (name, seed) in [("a.png", 1), ("b.png", 2)] {
        let mut dice = Pcg64Mcg::seed_from_u64(seed);
        let bytes = (0..3 * 40 * 36).map(|_| dice.random()).collect();
        let image = powergs_pixels::RgbImage::from_bytes(40, 36, bytes).unwrap();
        std::fs::write(at(name), image.png().unwrap()).unwrap();
    }
    let made = Made::alex(7);
    std::fs::write(at("w.safetensors"), made.bytes(Kind::F32)).unwrap();
    let said = |more: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("powergs-sim").unwrap();
        let output = command.arg("quality").arg(at("a.png")).arg(at("b.png")).args(more).assert();
        String::from_utf8(output.success().get_output().stdout.clone()).unwrap()
    };
    let weights = at("w.safetensors").display().to_string();
    let json: serde_json::Value =
        serde_json::from_str(&said(&["--json", "--lpips-weights", &weights])).unwrap();
    assert!(json["lpips"].as_f64().unwrap() > 1e-3, "{json}");
    assert!(said(&["--lpips-weights", &weights]).contains("LPIPS  0."));
    assert!(!said(&[]).contains("LPIPS") && !said(&["--json"]).contains("lpips"));
    let failed = command(folder.path(), &["--lpips-weights", "@/none"]).unwrap_err();
    assert_eq!(failed.exit, Exit::BadInput);
    std::fs::write(at("cut"), &made.bytes(Kind::F32)[..1000]).unwrap();
    let failed = command(folder.path(), &["--lpips-weights", "@/cut"]).unwrap_err();
    assert_eq!(failed.exit, Exit::BadInput);
    assert!(failed.to_string().contains("cut: "), "{failed}");
}

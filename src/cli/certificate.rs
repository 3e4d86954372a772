//! `certificate`: what numbers of a machine rest on, for whoever judges them.

use std::collections::BTreeSet;
use std::path::PathBuf;

use super::output_file::{self, Overwrite};
use super::{Context, Exit, Failure, arch, inputs, invocation, out};
use powergs_base::config::embedded::{MACHINES, find};
use powergs_base::config::references::{cited, is_assumption};
use powergs_chart::Format;
use powergs_core::run::store::atomic::write_atomically;
use powergs_core::run::{FileKind, Input, System};
use powergs_core::sim::MODEL_VERSION;
use powergs_report::certificate::{
    Certificate, CertifiedBase, CertifiedBuild, CertifiedFile, CertifiedPrices,
};
use powergs_report::document::Document;
use powergs_study::validate::{HeldRows, rows_of, stored_model};

/// Shown under `certificate --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim certificate gscore
  powergs-sim certificate mine.toml -o certificate.md
  powergs-sim certificate gsarch --json

Nothing is simulated: numbers of ours are those that come with the program, and
the page says of which model version. What enforced, calibrated, plausibility
and known gap mean: evidence/validation.md.";

/// Arguments of `certificate`.
#[derive(Debug, clap::Args)]
pub struct CertificateArgs {
    /// Machine: a name of `arch list`, or a TOML file
    #[arg(value_name = "ARCH")]
    pub arch: String,
    /// Write the page to this file (Markdown) instead
    #[arg(long, short, value_name = "FILE.md")]
    pub output: Option<PathBuf>,
    /// Whether it is replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
}

/// Runs `certificate`.
pub fn run(args: &CertificateArgs, context: &Context) -> Result<Exit, Failure> {
    args.output.iter().try_for_each(|path| args.overwrite.check(path))?;
    let system = inputs::system(&args.arch, &[], None)?;
    let certificate = certificate(&args.arch, &system)?;
    let base = certificate.base.as_ref().map(|base| base.name.as_str());
    let held = certificate.shipped.as_deref().or(base).map_or_else(HeldRows::default, rows_of);
    let page: Document = certificate.document(&held);
    if let Some(path) = &args.output {
        let text = page.markdown(Format::Svg);
        write_atomically(path, |w| w.write_all(text.as_bytes()))?;
        output_file::say(path, format!("certificate of {}", certificate.machine), context)?;
    }
    if context.global.json {
        out::json(&certificate.json(&held))?;
    } else if args.output.is_none() && !context.global.quiet {
        out::document(&page)?;
    }
    Ok(Exit::Done)
}

fn certificate(arch: &str, system: &System) -> Result<Certificate, Failure> {
    let file = |kind: FileKind| system.read(kind);
    let mut files = Vec::new();
    for kind in [FileKind::Machine, FileKind::Energy, FileKind::Dram] {
        let Some(read) = file(kind) else { continue };
        let (role, own) = (kind.role(), (read.origin.as_str(), read.own()));
        let bases = read.bases.iter().map(|(origin, text)| (origin.as_str(), text.as_str()));
        files.extend([own].into_iter().chain(bases).enumerate().map(|(i, (name, text))| {
            let role = if i == 0 { role } else { "its base" };
            CertifiedFile { role, name: name.to_owned(), xxh3: Input::of_text("", name, text).xxh3 }
        }));
    }
    let machine = file(FileKind::Machine);
    // A file with the bytes of a shipped one is that machine, wherever it is.
    let shipped = machine.and_then(|read| {
        let is_same = |text: &str| text == read.own();
        let own = MACHINES.iter().find(|known| known.name == read.origin || is_same(known.text));
        own.map(|known| known.name.to_owned())
    });
    let base = machine.filter(|_| shipped.is_none()).and_then(|read| {
        read.bases.iter().map(|(origin, _)| origin).find(|name| find(MACHINES, name).is_some())
    });
    let base = match base {
        Some(name) => {
            let changed = arch::differences(name, arch)?;
            Some(CertifiedBase { name: name.clone(), changed })
        }
        None => None,
    };
    let energy = file(FileKind::Energy);
    let by_kind = |sources: BTreeSet<String>| -> [Vec<String>; 2] {
        let (mut assumed, published): (Vec<String>, Vec<String>) =
            sources.into_iter().partition(|source| is_assumption(source));
        assumed.sort_by_key(|number| number[1..].parse::<u32>().unwrap_or(u32::MAX));
        [assumed, published]
    };
    let [assumptions, sources] = by_kind(system.sources());
    let of_energy = energy.map(|read| cited(&read.text)).unwrap_or_default();
    let dram = &system.machine().dram;
    let device = system.device().map(|device| format!("{}: {}", device.name, device.description));
    let memory = match device {
        Some(device) => format!("{} model of {device}", dram.model.name()),
        None => format!("{} model, no device", dram.model.name()),
    };
    Ok(Certificate {
        machine: system.label(),
        files,
        shipped,
        base,
        program: CertifiedBuild {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: invocation::BUILD.commit.to_owned(),
            models: MODEL_VERSION,
            stored: stored_model(),
        },
        energy: CertifiedPrices {
            name: system.energy_table().name.clone(),
            node: system.energy_table().node.map(|node| node.to_string()),
            sources: by_kind(of_energy)[1].clone(),
        },
        memory,
        assumptions,
        sources,
    })
}

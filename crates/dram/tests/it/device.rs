//! Device files: all that come with the program, and those that cannot work.

use powergs_base::config::embedded::{DRAM, find};
use powergs_dram::Device;

fn refused(name: &str, sets: &[&str], parts: &[&str]) {
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    let text = find(DRAM, name).expect("a device");
    let error = Device::parse_with(text, &sets).expect_err("a device that cannot work");
    let error = error.to_string();
    assert!(parts.iter().all(|p| error.contains(p)), "{sets:?}: {error}");
}

#[test]
fn every_device_is_what_its_name_says() {
    for file in DRAM {
        let device = Device::parse(file.text).unwrap_or_else(|e| panic!("{}: {e}", file.name));
        assert_eq!(device.name, file.name);
        let again = Device::parse(&device.to_toml()).expect("what was printed");
        assert_eq!(again, device);
        let described = device.description.split(", ").last().unwrap_or("");
        if let Some(peak) = described.strip_suffix(" GB/s") {
            let peak: f64 = peak.parse().expect("a number");
            assert!((device.peak_gb_s() - peak).abs() < 0.05, "{}", file.name);
        }
    }
}

#[test]
fn presets_have_the_organisation_that_they_are_named_after() {
    let wanted = [
        ("lpddr4-3200-x32x4", 4, 64, 51.2),
        ("lpddr4-3200-x16x8", 8, 32, 51.2),
        ("lpddr4-3200-x16x32", 32, 32, 204.8),
        ("lpddr5-6400-x16x4", 4, 32, 51.2),
        ("lpddr5x-8533-x16x4", 4, 32, 4.0 * 32.0 / 1.875),
        ("lpddr6-10667-x12x8", 8, 32, 8.0 * 32.0 / 2.25),
        ("hbm2-8ch", 8, 32, 256.0),
    ];
    for (name, channels, burst, peak) in wanted {
        let device = super::device(name, &[]);
        assert_eq!(device.organisation.channels, channels);
        assert_eq!(device.organisation.burst.0, burst);
        assert!((device.peak_gb_s() - peak).abs() < 1e-9);
    }
}

/// Of LPDDR6 an eighth more bits cross the pins than are data.
#[test]
fn pins_and_data_have_rates_of_their_own() {
    for (name, pin, share) in [
        ("lpddr4-3200-x16x8", 3.2, 1.0),
        ("lpddr5x-8533-x16x4", 8.0 / 0.9375, 1.0),
        ("lpddr6-10667-x12x4", 4.0 / 0.375, 8.0 / 9.0),
        ("hbm2-8ch", 2.0, 1.0),
    ] {
        let device = super::device(name, &[]);
        let o = &device.organisation;
        assert!((device.pin_gbit_s() - pin).abs() < 1e-9, "{name}: {}", device.pin_gbit_s());
        let pins = f64::from(o.width * o.channels * o.pseudo_channels);
        let carried = device.peak_gb_s() * 8.0 / (pins * pin);
        assert!((carried - share).abs() < 1e-9, "{name}: {carried}");
    }
    let lp6 = "lpddr6-10667-x12x4";
    let parts = ["`organisation.burst` (32 B)", "12 x 20 = 240 bits"];
    refused(lp6, &["organisation.beats=20"], &parts);
}

#[test]
fn what_cannot_work_is_refused_with_both_keys() {
    let lp4 = "lpddr4-3200-x16x8";
    refused(lp4, &["organisation.row=16 B"], &["`organisation.row`", "`organisation.burst`"]);
    refused(lp4, &["organisation.banks=0"], &["organisation.banks"]);
    refused(lp4, &["organisation.channels=3"], &["`organisation.channels` = 3", "power of two"]);
    refused(lp4, &["organisation.rows=1000"], &["power of two"]);
    refused(lp4, &["organisation.banks=64", "organisation.bank-groups=4"], &["64 banks a channel"]);
    refused(lp4, &["mapping.interleave=16 B"], &["`mapping.interleave`", "`organisation.burst`"]);
    refused(lp4, &["mapping.interleave=4 KiB"], &["`mapping.interleave`", "`organisation.row`"]);
    refused(lp4, &["mapping.order=fields"], &["`mapping.fields`", "`mapping.order`"]);
    let fields = |f: &str| ["mapping.order=fields".to_owned(), format!("mapping.fields={f}")];
    for (list, part) in [
        ("[\"row:15\"]", "bits to channel"),
        ("[\"rwo:15\"]", "not a field"),
        ("[\"row\"]", "not a field"),
        ("[\"row:-1\"]", "not a field"),
        ("[]", "bits to channel"),
    ] {
        let sets = fields(list);
        refused(lp4, &[&sets[0], &sets[1]], &[part]);
    }
    refused(
        lp4,
        &["controller.write-low=0.9"],
        &["`controller.write-low` (0.9)", "`controller.write-high` (0.8)"],
    );
    refused(lp4, &["timing.column-short=4"], &["`timing.column-short`", "`timing.burst`"]);
    refused(
        lp4,
        &["timing.refresh-interval=300"],
        &["`timing.refresh-interval`", "`timing.refresh-all-to-activate`"],
    );
    refused(
        lp4,
        &["timing.refresh-interval=900", "controller.refresh=per-bank"],
        &["`timing.refresh-interval`", "`timing.activate-to-activate`"],
    );
    refused(lp4, &["front-end.window=16 B"], &["`front-end.window`", "`organisation.burst`"]);
    refused(
        "lpddr5-6400-x16x4",
        &["split-activate.second-within=16"],
        &["`split-activate.second-within`", "`timing.activate-to-read`"],
    );
    refused(
        "lpddr5-6400-x16x4",
        &["commands.column-bus=true"],
        &["`split-activate`", "`commands.column-bus = true`"],
    );
    refused(
        lp4,
        &["energy.actions.background.self-refresh-after=10 ns"],
        &["self-refresh-after", "power-down-after"],
    );
    refused(lp4, &["energy.scale-source=nobody"], &["energy.scale-source", "references.toml"]);
    refused(
        lp4,
        &["energy.flat.energy=1 pJ/B", "energy.flat.source=A40"],
        &["exactly one of [energy.flat] and [energy.actions]"],
    );
    refused(lp4, &["clock-period=0 ns"], &["`clock-period`"]);
    refused(lp4, &["controller.read-queue=0"], &["read-queue"]);
    refused(lp4, &["controller.write-high=nan"], &["write-high"]);
}

#[test]
fn hostile_texts_are_errors() {
    let good = find(DRAM, "hbm2-8ch").expect("a device");
    let last = good.rfind('"').expect("the last value");
    for end in (0..last).step_by(37).filter(|end| good.is_char_boundary(*end)) {
        assert!(Device::parse(&good[..end]).is_err(), "{end} bytes");
    }
    for bad in ["", "[", "organisation = 3", "[organisation]\nchannels = 99999999999999999999"] {
        assert!(Device::parse(bad).is_err(), "{bad}");
    }
    let huge =
        ["organisation.rows=4294967296", "organisation.burst=8 GiB", "organisation.row=1e30 B"];
    for set in huge {
        assert!(Device::parse_with(good, &[set.to_owned()]).is_err(), "{set}");
    }
}

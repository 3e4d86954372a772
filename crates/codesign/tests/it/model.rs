//! Models: what they start from, and the bytes of their records.

use std::num::NonZeroU32;

use powergs_base::number::NumberFormat;
use powergs_base::quantity::Bytes;
use powergs_codesign::model::{ModelPoint, RecordBytes, models, unreadable};
use powergs_codesign::space::{FormatSpec, ModelSpec};
use powergs_core::run::System;
use powergs_scene::Gaussians;

fn format(text: &str) -> Option<NumberFormat> {
    Some(text.parse().unwrap())
}

fn point(sh_degree: u8, spec: FormatSpec) -> ModelPoint {
    let (format, formats) = (spec.name.clone(), spec.formats());
    ModelPoint { rho: 0.0, sh_degree, format, formats, is_dense: false }
}

/// The record of a model on a machine.
fn of(model: &ModelPoint, system: &System) -> RecordBytes {
    let machine = system.machine();
    RecordBytes::of(model, machine, machine.flow().record().expect("its files have it"))
}

fn fp16() -> FormatSpec {
    let e5m10 = format("e5m10");
    FormatSpec {
        name: "fp16".into(),
        position: e5m10,
        scale: e5m10,
        rotation: e5m10,
        opacity: e5m10,
        colour_dc: e5m10,
        colour_rest: e5m10,
    }
}

#[test]
fn records_in_fp16_are_those_of_the_machine_at_every_degree() {
    let machine = System::named("gscore").unwrap();
    let record = &machine.machine().tiles().record;
    for (degree, coefficients) in [(0, 1), (1, 4), (2, 9), (3, 16)] {
        let bytes = of(&point(degree, fp16()), &machine);
        assert_eq!(bytes.position, Some(record.position));
        assert_eq!(bytes.geometry, Some(record.geometry));
        let colour = 6 * coefficients;
        let pitch = u64::next_multiple_of(colour, 32);
        assert_eq!(bytes.colour, Some((Bytes(colour), Bytes(pitch))), "degree {degree}");
    }
    assert!(of(&point(3, FormatSpec::exact()), &machine).settings().is_empty());
}

#[test]
fn other_dataflows_have_other_keys() {
    let machine = System::named("vorion").unwrap();
    let bytes = of(&point(1, fp16()), &machine);
    let keys: Vec<String> = bytes.settings().into_iter().map(|(k, v)| format!("{k}={v}")).collect();
    let changes: Vec<_> = keys.iter().map(|k| k.replace('"', "").parse().unwrap()).collect();
    let changed = machine.with(&changes).expect("a machine that fits together");
    let gaussian = &changed.machine().resident().gaussian;
    assert_eq!((gaussian.position, gaussian.shape), (Bytes(6), Bytes(16)));
    // 3 x 4 coefficients.
    assert_eq!((gaussian.colour, gaussian.colour_pitch), (Bytes(24), Bytes(32)));
}

#[test]
fn bits_become_whole_bytes_and_fields_without_a_format_stay_as_wide_as_the_machine_has_them() {
    let machine = System::named("gscore").unwrap();
    let spec = FormatSpec {
        scale: format("e5m6"),
        rotation: format("e4m5"),
        colour_dc: format("e4m5"),
        colour_rest: format("e4m3"),
        ..FormatSpec::exact()
    };
    let bytes = of(&point(2, spec), &machine);
    assert_eq!(bytes.position, None);
    // 3 x 12 + 4 x 10 + 16 bits; 3 x 10 + 24 x 8 bits.
    assert_eq!(bytes.geometry, Some(Bytes(12)));
    assert_eq!(bytes.colour, Some((Bytes(28), Bytes(32))));
    let keys: Vec<String> = bytes.settings().into_iter().map(|(k, v)| format!("{k}={v}")).collect();
    let changes: Vec<_> = keys.iter().map(|k| k.parse().unwrap()).collect();
    let changed = machine.with(&changes).expect("a machine that fits together");
    assert_eq!(changed.machine().tiles().record.geometry, Bytes(12));
}

#[test]
fn colours_that_the_units_cannot_hold_are_refused() {
    let numbers = format("e5m10");
    let with = |text: &str| {
        let spec = FormatSpec { colour_rest: format(text), ..FormatSpec::exact() };
        unreadable(&point(3, spec), numbers)
    };
    assert_eq!(with("e5m10"), None);
    assert_eq!(with("e4m3"), None);
    for wrong in ["e6m9", "e4m11", "e8m7"] {
        let message = with(wrong).expect("a contradiction");
        assert!(message.contains("colour-rest") && message.contains(wrong), "{message}");
    }
    // Shapes are converted in numbers that are wider than any of a record.
    let spec = FormatSpec { scale: format("e8m7"), ..FormatSpec::exact() };
    assert_eq!(unreadable(&point(3, spec), numbers), None);
}

#[test]
fn a_lower_degree_keeps_the_first_coefficients_of_every_channel() {
    let dense = Gaussians {
        means: vec![[0.0; 3]; 2],
        log_scales: vec![[0.0; 3]; 2],
        rotations: vec![[1.0, 0.0, 0.0, 0.0]; 2],
        logit_opacities: vec![0.0; 2],
        sh_degree: 2,
        sh: (0..54).map(|i| i as f32).collect(),
        antialiased: true,
    };
    let start = point(1, FormatSpec::exact()).start(&dense);
    assert_eq!((start.sh_degree, start.antialiased), (1, true));
    let firsts = |channel: usize| (0..4).map(move |k| (9 * channel + k) as f32);
    assert_eq!(start.sh, (0..6).flat_map(firsts).collect::<Vec<_>>());
    assert_eq!(point(2, FormatSpec::exact()).start(&dense), dense);
}

#[test]
fn every_combination_is_a_model_behind_the_dense_one() {
    let (rho, sh_degree, formats) = (vec![0.0, 0.5], vec![2, 0], vec![fp16()]);
    let spec = ModelSpec { rho, sh_degree, formats, codebook: Vec::new() };
    let dense = Gaussians { sh_degree: 2, ..Gaussians::default() };
    let names: Vec<String> = models(&spec, &dense).iter().map(ModelPoint::name).collect();
    let wanted = ["dense", "rho0-sh2-fp16", "rho0-sh0-fp16", "rho0.5-sh2-fp16", "rho0.5-sh0-fp16"];
    assert_eq!(names, wanted);
    // Constant colours have no codebook.
    let spec = ModelSpec { codebook: vec![0, 256], ..spec };
    let names: Vec<String> = models(&spec, &dense).iter().map(ModelPoint::name).collect();
    let wanted = ["dense", "rho0-sh2-fp16", "rho0-sh2-fp16-cb256", "rho0-sh0-fp16"];
    assert_eq!(names[..4], wanted);
    assert_eq!(names.len(), 7);
}

#[test]
fn a_codebook_is_a_number_in_the_record_and_entries_on_the_chip() {
    let machine = System::named("gscore").unwrap();
    let with_book = |entries: u32, spec: FormatSpec, degree: u8| {
        let mut point = point(degree, spec);
        point.formats.codebook = NonZeroU32::new(entries);
        of(&point, &machine)
    };
    // 3 x 16 bits and 12; 45 x 16 bits.
    let whole = with_book(4096, FormatSpec::exact(), 3);
    assert_eq!(whole.colour, Some((Bytes(8), Bytes(8))));
    assert_eq!(whole.codebook, Some((4096, Bytes(90))));
    // 3 x 10 bits and 9 for 257 entries; 24 x 8 bits.
    let (dc, rest) = (format("e4m5"), format("e4m3"));
    let spec = FormatSpec { colour_dc: dc, colour_rest: rest, ..FormatSpec::exact() };
    let short = with_book(257, spec, 2);
    assert_eq!(short.colour, Some((Bytes(5), Bytes(8))));
    assert_eq!(short.codebook, Some((257, Bytes(24))));
    let keys: Vec<String> = short.settings().iter().map(|(k, v)| format!("{k}={v}")).collect();
    let changes: Vec<_> = keys.iter().map(|k| k.replace('"', "").parse().unwrap()).collect();
    let changed = machine.with(&changes).expect("a machine that fits together");
    let codebook = changed.machine().tiles().codebook;
    assert_eq!((codebook.entries, codebook.entry), (257, Bytes(24)));
    assert_eq!(changed.machine().tiles().record.colour, Bytes(5));
}

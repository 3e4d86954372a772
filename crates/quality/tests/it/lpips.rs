//! LPIPS with made-up weights: against a naive twin in double precision, and bad files.

mod twin;

use powergs_base::picture::Picture;
use powergs_quality::{Lpips, LpipsError};
use powergs_testkit::lpips::{ALEX, Kind, Made, VGG};

use super::pictures::{noisy, on_threads, shown};

fn alex() -> Made {
    Made::alex(7)
}

#[test]
fn alexnet_agrees_with_a_naive_twin() {
    let made = alex();
    let lpips = Lpips::from_safetensors(&made.bytes(Kind::F32)).unwrap();
    assert_eq!(lpips.network(), "alex");
    // Sizes that fill the last pool, and that do not; the smallest one.
    for (width, height) in [(31, 31), (47, 38), (40, 66)] {
        let (a, b) = (shown(width, height, 1), shown(width, height, 2));
        let value = lpips.distance(&a, &b).unwrap();
        let expected = twin::distance(&ALEX, &made, &a, &b);
        // Single against double precision; sums have 3456 terms.
        assert!((value / expected - 1.0).abs() < 1e-4, "{width}x{height}: {value} {expected}");
        assert!(expected > 1e-3, "{expected}");
    }
}

/// VGG16 has more layers than places here; half the precision keeps the file small.
#[test]
fn vgg16_agrees_with_a_naive_twin() {
    let made = Made::vgg(3).rounded_to_bf16();
    let lpips = Lpips::from_safetensors(&made.bytes(Kind::Bf16)).unwrap();
    assert_eq!(lpips.network(), "vgg");
    let (a, b) = (shown(19, 16, 1), shown(19, 16, 2));
    let value = lpips.distance(&a, &b).unwrap();
    let expected = twin::distance(&VGG, &made, &a, &b);
    assert!((value / expected - 1.0).abs() < 1e-4, "{value} {expected}");
    assert!(matches!(lpips.check_size(15, 40), Err(LpipsError::Small { least: 16, .. })));
    let error = lpips.check_size(8000, 8000).unwrap_err().to_string();
    assert!(error.contains("GiB"), "{error}");
}

#[test]
fn equal_pictures_do_not_differ_and_order_and_threads_do_not_matter() {
    let lpips = Lpips::from_safetensors(&alex().bytes(Kind::F32)).unwrap();
    let (a, b) = (shown(53, 37, 1), shown(53, 37, 2));
    assert_eq!(lpips.distance(&a, &a).unwrap(), 0.0);
    let there = on_threads(1, || lpips.distance(&a, &b).unwrap());
    assert!(there > 0.0);
    assert_eq!(there, lpips.distance(&b, &a).unwrap());
    assert_eq!(there, on_threads(5, || lpips.distance(&a, &b).unwrap()));
    // A display clamps.
    assert_eq!(lpips.distance(&noisy(53, 37, 1), &a).unwrap(), 0.0);
    for bad in [f32::NAN, f32::INFINITY] {
        let mut broken = a.clone();
        broken.pixels[700][1] = bad;
        assert!(lpips.distance(&a, &broken).unwrap().is_nan());
    }
    // Black has features too, by the biases; with none at all nothing divides by zero.
    let black = Picture { width: 31, height: 31, pixels: vec![[0.0; 3]; 961] };
    let mut dead = alex();
    dead.each("net.slice1.0.bias", |_| -1e9);
    let dead = Lpips::from_safetensors(&dead.bytes(Kind::F32)).unwrap();
    assert_eq!(dead.distance(&black, &shown(31, 31, 5)).unwrap(), 0.0);
}

#[test]
fn other_types_and_shorter_names_are_read() {
    let (a, b) = (shown(33, 33, 1), shown(33, 33, 2));
    let value = |made: &Made, kind| {
        Lpips::from_safetensors(&made.bytes(kind)).unwrap().distance(&a, &b).unwrap()
    };
    let made = alex();
    let whole = value(&made, Kind::F32);
    // Ten bits of mantissa; errors of millions of weights cancel.
    let half = value(&made, Kind::F16);
    assert!(half != whole && (half / whole - 1.0).abs() < 5e-3, "{half} {whole}");
    for (i, name) in
        ["lin0.weight", "lin1.model.0.weight", "lins.2.model.1.weight"].iter().enumerate()
    {
        let mut other = made.clone();
        other.rename(&format!("lin{i}.model.1.weight"), name);
        assert_eq!(value(&other, Kind::F32), whole, "{name}");
    }
    let mut scaled = made.clone();
    scaled.add("scaling_layer.shift", &[1, 3, 1, 1], vec![-0.030, -0.088, -0.188]);
    scaled.add("scaling_layer.scale", &[1, 3, 1, 1], vec![0.458, 0.448, 0.450]);
    assert_eq!(value(&scaled, Kind::F32), whole);
    scaled.each("scaling_layer.scale", |_| 1.0);
    assert!(value(&scaled, Kind::F32) != whole);
    scaled.each("scaling_layer.scale", |_| 0.0);
    let error = Lpips::from_safetensors(&scaled.bytes(Kind::F32)).unwrap_err();
    assert!(error.to_string().contains("scaling_layer.scale"), "{error}");
}

#[track_caller]
fn refused(bytes: &[u8], words: &[&str]) {
    let error = Lpips::from_safetensors(bytes).unwrap_err().to_string();
    for word in words {
        assert!(error.contains(word), "{word}: {error}");
    }
}

#[test]
fn bad_files_are_refused_with_the_tensor_and_what_to_do() {
    let made = alex();
    let bytes = made.bytes(Kind::F32);
    for len in [0, 1, 7, 8, 9, 100, bytes.len() / 2, bytes.len() - 1] {
        refused(&bytes[..len], &["not a complete safetensors file", "docs/metrics.md"]);
    }
    // A header of exabytes, and one that points beyond the file.
    refused(&[&u64::MAX.to_le_bytes()[..], b"{}"].concat(), &["complete safetensors"]);
    let far = br#"{"a":{"dtype":"F32","shape":[1000000000],"data_offsets":[0,4000000000]}}"#;
    refused(&[&(far.len() as u64).to_le_bytes()[..], far].concat(), &["complete safetensors"]);
    refused(b"PK\x03\x04 and more", &["PyTorch", "docs/metrics.md"]);
    refused(b"\x80\x02\x8a\x0al\xfc", &["PyTorch"]);
    for name in ["net.slice3.6.weight", "net.slice5.10.bias", "lin4.model.1.weight"] {
        let mut less = made.clone();
        less.remove(name);
        refused(&less.bytes(Kind::F32), &[name, "AlexNet", "missing"]);
        let mut wrong = made.clone();
        wrong.reshape(name);
        refused(&wrong.bytes(Kind::F32), &[name, "shape"]);
        let mut broken = made.clone();
        let (value, shown) =
            if name.ends_with("bias") { (f32::NEG_INFINITY, "-inf") } else { (f32::NAN, "NaN") };
        broken.set(name, 5, value);
        refused(&broken.bytes(Kind::F32), &[name, "value 5", shown]);
    }
    refused(&made.bytes(Kind::I32), &["net.slice1.0.weight", "I32", "BF16"]);
    let mut squeeze = Made::default();
    squeeze.add("net.slice1.0.weight", &[1], vec![0.0]);
    refused(&squeeze.bytes(Kind::F32), &["unknown network", "net.slice1.0.weight", "AlexNet"]);
    refused(&Made::default().bytes(Kind::F32), &["no tensor at all"]);
}

#[test]
fn pictures_that_are_too_small_are_refused() {
    let lpips = Lpips::from_safetensors(&alex().bytes(Kind::F32)).unwrap();
    let error = lpips.distance(&shown(30, 90, 1), &shown(30, 90, 2)).unwrap_err();
    assert!(matches!(error, LpipsError::Small { least: 31, .. }), "{error}");
    assert!(lpips.check_size(31, 31).is_ok());
    assert!(matches!(lpips.check_size(0, 0), Err(LpipsError::Small { .. })));
    assert!(matches!(lpips.check_size(u32::MAX, u32::MAX), Err(LpipsError::Large { .. })));
}

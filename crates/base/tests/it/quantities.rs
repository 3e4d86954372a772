//! Quantities: what is read, what is refused and how, and that nothing is rounded on the way.

use std::fmt::Debug;

use powergs_base::quantity::{
    Bytes, BytesPerSecond, Hertz, Nanometres, Nanoseconds, Picojoules, PicojoulesPerByte, Quantity,
    SquareMillimetres, Watts,
};
use proptest::prelude::*;

#[track_caller]
fn reads<Q: Quantity + PartialEq + Debug>(text: &str, value: Q) {
    assert_eq!(text.parse::<Q>(), Ok(value), "{text}");
}

#[track_caller]
fn refuses<Q: Quantity + Debug>(text: &str, because: &str) {
    let error = text.parse::<Q>().expect_err(text).to_string();
    assert!(error.contains(because), "{text}: {error}");
}

#[test]
fn units_are_understood_exactly() {
    reads("51.2 GB/s", BytesPerSecond(51_200_000_000.0));
    reads("51.2 GiB/s", BytesPerSecond(51.2 * 1_073_741_824.0));
    reads("8 Gbit/s", BytesPerSecond(1e9));
    reads("64 KiB", Bytes(65_536));
    reads("64 kB", Bytes(64_000));
    reads("64 KB", Bytes(64_000));
    reads("1.5 KiB", Bytes(1_536));
    reads("19 B", Bytes(19));
    reads("1 GHz", Hertz(1e9));
    reads("800MHz", Hertz(8e8));
    reads(" 0.8e3 MHz ", Hertz(8e8));
    reads("0.53 pJ", Picojoules(0.53));
    reads("1.2 nJ", Picojoules(1200.0));
    reads("10.88 pJ/B", PicojoulesPerByte(10.88));
    reads("8 pJ/bit", PicojoulesPerByte(64.0));
    reads("100 ns", Nanoseconds(100.0));
    reads("0.1 us", Nanoseconds(100.0));
    reads("0 ns", Nanoseconds(0.0));
    reads("0.25 W", Watts(0.25));
    reads("228.5245898 mW", Watts(0.2285245898));
    reads("3.95 mm2", SquareMillimetres(3.95));
    reads("226 um2", SquareMillimetres(226e-6));
    reads("28 nm", Nanometres(28.0));
}

#[test]
fn what_is_no_quantity_is_refused_with_the_right_form() {
    refuses::<Hertz>("800", "needs its unit: write e.g. \"1 GHz\"");
    refuses::<Hertz>("1 Ghz", "unknown unit `Ghz` for a frequency: use one of Hz, kHz, MHz, GHz");
    refuses::<Hertz>("0 GHz", "greater than zero");
    refuses::<Hertz>("-1 GHz", "greater than zero");
    refuses::<Hertz>("GHz", "does not start with a plain decimal number");
    refuses::<Hertz>("", "does not start with a plain decimal number");
    refuses::<Hertz>("inf GHz", "plain decimal number");
    refuses::<Hertz>("NaN GHz", "plain decimal number");
    refuses::<Hertz>("1. GHz", "plain decimal number");
    refuses::<Hertz>("1e400 GHz", "greater than zero and believable");
    refuses::<Hertz>("1e-400 GHz", "greater than zero and believable");
    refuses::<Picojoules>("1e294 J", "zero, or believable");
    refuses::<Nanoseconds>("1e-70 ns", "zero, or believable");
    refuses::<Hertz>("1,5 GHz", "unknown unit `,5 GHz`");
    refuses::<Bytes>("1.5 B", "a whole number of bytes");
    refuses::<Bytes>("0.3 KiB", "a whole number of bytes");
    refuses::<Bytes>("1e30 GiB", "a whole number of bytes");
    refuses::<Bytes>("64 kb", "unknown unit `kb`");
    refuses::<Bytes>("64 Kbit", "unknown unit `Kbit`");
    refuses::<BytesPerSecond>("51.2 GB", "unknown unit `GB` for a bandwidth");
    refuses::<BytesPerSecond>("51.2 Gb/s", "unknown unit `Gb/s`");
    refuses::<Picojoules>("0.53 pJ/B", "unknown unit `pJ/B` for an energy:");
    refuses::<PicojoulesPerByte>("0.24 pJ", "unknown unit `pJ` for an energy per byte");
    refuses::<Watts>(&"9".repeat(500), "plain decimal number");
}

#[test]
fn what_is_printed_is_what_people_write() {
    assert_eq!(BytesPerSecond(51.2e9).to_string(), "51.2 GB/s");
    assert_eq!(Bytes(65_536).to_string(), "64 KiB");
    assert_eq!(Bytes(64_000).to_string(), "64000 B");
    assert_eq!(Bytes(0).to_string(), "0 B");
    assert_eq!(Hertz(8e8).to_string(), "800 MHz");
    assert_eq!(Picojoules(0.53).to_string(), "530 fJ");
    assert_eq!(Nanoseconds(100.0).to_string(), "100 ns");
    assert_eq!(Watts(0.0).to_string(), "0 W");
    assert_eq!(Watts(1e-12).to_string(), "0.001 nW");
}

proptest! {
    #[test]
    fn printed_quantities_read_back_to_the_same_bits(mantissa in 1e-3f64..1e6, ten in -6i32..9) {
        let x = mantissa * 10f64.powi(ten);
        prop_assert_eq!(BytesPerSecond(x).to_string().parse(), Ok(BytesPerSecond(x)));
        prop_assert_eq!(Hertz(x).to_string().parse(), Ok(Hertz(x)));
        prop_assert_eq!(Picojoules(x).to_string().parse(), Ok(Picojoules(x)));
        prop_assert_eq!(PicojoulesPerByte(x).to_string().parse(), Ok(PicojoulesPerByte(x)));
        prop_assert_eq!(Watts(x).to_string().parse(), Ok(Watts(x)));
        prop_assert_eq!(Nanoseconds(x).to_string().parse(), Ok(Nanoseconds(x)));
    }

    #[test]
    fn printed_sizes_read_back(n in any::<u64>(), shift in 0u32..64) {
        prop_assert_eq!(Bytes(n >> shift).to_string().parse(), Ok(Bytes(n >> shift)));
    }

    #[test]
    fn no_text_makes_a_quantity_panic(text in "\\PC{0,20}") {
        let _ = text.parse::<Bytes>();
        let _ = text.parse::<Watts>();
    }
}

//! Banks after CACTI: exact at its rows, monotone between them, refused outside.

use powergs_base::config::embedded::CACTI;
use powergs_energy::cacti::{Bank, Cell, Macros};

fn lop() -> Macros {
    Macros::new(28.0, Cell::Lop, 350).expect("rows")
}

fn one(size: u64, word: u64) -> Bank {
    lop().bank(size, word, false, false).unwrap_or_else(|e| panic!("{size} {word}: {e:?}"))
}

#[test]
fn every_row_comes_back_exactly() {
    let cells = [("hp", "hp", Cell::Hp), ("lop", "lop", Cell::Lop), ("lstp", "lstp", Cell::Lstp)];
    let mixed = [("lstp", "lop", Cell::LstpLop)];
    let mut seen = 0;
    for line in CACTI.lines().skip(3) {
        let f: Vec<&str> = line.split(',').collect();
        let x = |i: usize| f[i].parse::<f64>().expect(line);
        let (size, word, two) = (x(5) as u64, x(6) as u64, f[3] == "1r1w");
        if f[4] != "350" {
            continue;
        }
        let cell = cells.iter().chain(&mixed).find(|(a, b, _)| (*a, *b) == (f[1], f[2]));
        let rows = Macros::new(x(0), cell.expect(line).2, 350).expect(line);
        let bank = rows.bank(size, word, two, false).expect(line);
        let ours = [bank.read_pj, bank.write_pj, bank.leakage_w * 1e3, bank.area_mm2];
        for (ours, i) in ours.into_iter().zip(7..) {
            // A ratio and back, or watts and back: two roundings.
            assert!((ours - x(i)).abs() <= 4e-16 * x(i), "{line}: {ours}");
        }
        seen += 1;
    }
    assert!(seen > 170, "{seen} rows");
}

#[test]
fn larger_banks_cost_more() {
    for word in [4, 8, 12, 16, 24, 32, 48] {
        let start = if word > 32 { 2048 } else { 1024 };
        let banks: Vec<Bank> = (0..40)
            .map(|i| (start as f64 * 1.18f64.powi(i)) as u64)
            .filter(|size| *size <= 1 << 20)
            .map(|size| one(size, word))
            .collect();
        assert!(banks.len() > 30);
        assert!(banks.is_sorted_by(|a, b| a.read_pj < b.read_pj), "{word}");
        assert!(banks.is_sorted_by(|a, b| a.write_pj < b.write_pj), "{word}");
        assert!(banks.is_sorted_by(|a, b| a.leakage_w < b.leakage_w), "{word}");
    }
}

#[test]
fn words_are_linear_between_the_widths() {
    let (a, b, c) = (one(16 << 10, 32), one(16 << 10, 48), one(16 << 10, 64));
    assert!((b.read_pj - (a.read_pj + c.read_pj) / 2.0).abs() < 1e-12);
    // A whole word costs more than a narrow one, and less than its bytes one by one.
    let (narrow, wide) = (one(128 << 10, 4), one(128 << 10, 64));
    assert!(wide.read_pj > narrow.read_pj && wide.read_pj < 16.0 * narrow.read_pj);
    // 2 KiB has no row of 4-byte words: it lies between those of 1 and 8 KiB.
    let between = one(2048, 4).read_pj;
    assert!(between > one(1024, 4).read_pj && between < one(8192, 4).read_pj);
}

#[test]
fn two_ports_cost_more_energy_and_area() {
    for (size, word) in [(2048, 16), (16 << 10, 32), (64 << 10, 8)] {
        let (single, pair) = (one(size, word), lop().bank(size, word, true, false).expect("rows"));
        let ratio = |f: fn(&Bank) -> f64| f(&pair) / f(&single);
        assert!((1.2..1.5).contains(&ratio(|b| b.read_pj)), "{}", ratio(|b| b.read_pj));
        assert!((1.7..2.6).contains(&ratio(|b| b.area_mm2)), "{}", ratio(|b| b.area_mm2));
        assert!(ratio(|b| b.leakage_w) > 1.0);
    }
}

#[test]
fn cells_and_temperature_move_leakage() {
    let leak = |cell, kelvin| {
        let rows = Macros::new(28.0, cell, kelvin).expect("rows");
        rows.bank(16 << 10, 32, false, false).expect("a row").leakage_w
    };
    assert!(leak(Cell::Hp, 350) > leak(Cell::Lop, 350));
    assert!(leak(Cell::Lop, 350) > 100.0 * leak(Cell::Lstp, 350));
    // 16 KiB at 300 K: 0.457 mW; 256 KiB says 0.171 of 350 K, this row 0.171: one ratio for all.
    assert!((leak(Cell::Lop, 300) / 0.45715e-3 - 1.0).abs() < 0.02);
}

#[test]
fn banks_outside_are_refused_unless_allowed_and_near() {
    let outside = |size, word| lop().bank(size, word, false, false).expect_err("outside");
    assert_eq!(outside(512, 16).sizes, (1024, 1 << 20));
    assert_eq!(outside(1024, 64).words, Some((4, 32)), "a word of 64 B needs 2 KiB");
    assert_eq!(outside(4 << 20, 32).words, None);
    let allowed = |size, word| lop().bank(size, word, false, true);
    let (half, whole) = (allowed(512, 16).expect("near"), one(1024, 16));
    assert!(half.read_pj < whole.read_pj && half.read_pj > 0.5 * whole.read_pj);
    assert!(half.area_mm2 < whole.area_mm2);
    assert_eq!(allowed(1024, 2).expect("near").read_pj, one(1024, 4).read_pj);
    let wide = allowed(1024, 64).expect("near");
    assert!(
        wide.area_mm2 > one(1024, 32).area_mm2,
        "two banks of 512 B take more than one of 1 KiB"
    );
    let beside = allowed(512, 32).expect("near");
    assert_eq!((wide.read_pj, wide.area_mm2), (2.0 * beside.read_pj, 2.0 * beside.area_mm2));
    for (size, word) in [(0, 32), (255, 16), ((4 << 20) + 1, 32), (1024, 0), (u64::MAX, 4)] {
        assert!(allowed(size, word).is_err(), "{size} {word}");
    }
}

#[test]
fn cells_without_rows_are_refused_with_those_that_exist() {
    let error = Macros::new(22.0, Cell::Lop, 350).expect_err("no such rows");
    assert!(error.contains("lop cells at 22 nm") && error.contains("hp at 22 nm"), "{error}");
}

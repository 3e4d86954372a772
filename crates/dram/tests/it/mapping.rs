//! Where bytes lie.

use powergs_dram::device::Order;
use powergs_dram::{Decoder, Device};
use proptest::prelude::*;
use std::collections::BTreeSet;

use super::device;

/// Channel, bank and row of an address.
fn place(device: &Device, address: u64) -> (u32, u32, u32) {
    let decoder = Decoder::new(device);
    let place = decoder.place(decoder.burst(address));
    (place.channel, place.bank, place.row)
}

#[test]
fn rows_banks_columns_channels_from_the_bottom() {
    // 8 channels at bit 6, 64 columns of 32 B: bit 5 and bits 9 to 13, banks at bit 14, rows at 17.
    let device = device("lpddr4-3200-x16x8", &[]);
    assert_eq!(place(&device, 0), (0, 0, 0));
    assert_eq!(place(&device, 32), (0, 0, 0));
    assert_eq!(place(&device, 64), (1, 0, 0));
    assert_eq!(place(&device, 512 + 448), (7, 0, 0));
    assert_eq!(place(&device, 1 << 14), (0, 1, 0));
    assert_eq!(place(&device, 1 << 17), (0, 0, 1));
    let wider = super::device("lpddr4-3200-x16x8", &["mapping.interleave=256 B"]);
    assert_eq!(place(&wider, 255), (0, 0, 0));
    assert_eq!(place(&wider, 256), (1, 0, 0));
}

#[test]
fn blocks_of_64_bytes_go_round_the_bank_groups() {
    // 4 channels at bit 6, groups at bit 8; a group has 4 banks.
    let device = device("lpddr5-6400-x16x4", &[]);
    assert_eq!(place(&device, 63), (0, 0, 0));
    assert_eq!(place(&device, 256), (0, 4, 0));
    assert_eq!(place(&device, 3 * 256), (0, 12, 0));
    assert_eq!(place(&device, 1024), (0, 0, 0));
    // 2 pseudo channels of 16 banks below the groups.
    let hbm = super::device("hbm2-8ch", &[]);
    assert_eq!(place(&hbm, 512), (0, 16, 0));
    assert_eq!(place(&hbm, 1024), (0, 4, 0));
}

#[test]
fn mop_is_exclusive_ored_with_the_column() {
    // 2 column bits (5, 8), group at 9, bank at 11, 4 more column bits at 13, row at 17.
    let device = device("lpddr5-6400-x16x4", &["mapping.order=mop"]);
    assert_eq!(place(&device, 512), (0, 4, 0));
    // Column 1: its lowest bits flip the group.
    assert_eq!(place(&device, 32), (0, 4, 0));
    assert_eq!(place(&device, 1 << 13), (0, 1, 0));
    assert_eq!(place(&device, 1 << 15), (0, 0, 1));
}

#[test]
fn fields_say_what_the_names_say() {
    let named = device("lpddr4-3200-x16x8", &[]);
    let listed = device(
        "lpddr4-3200-x16x8",
        &[
            "mapping.order=fields",
            "mapping.fields=[\"column:1\", \"channel:3\", \"column:5\", \"bank:3\", \"row:15\"]",
        ],
    );
    for i in 0..10_000u64 {
        let address = i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 20;
        assert_eq!(place(&named, address), place(&listed, address), "{address:x}");
    }
}

#[test]
fn addresses_beyond_the_capacity_wrap() {
    let device = device("lpddr4-3200-x16x8", &[]);
    let capacity = 4 << 30;
    assert_eq!(place(&device, capacity + 64), place(&device, 64));
    assert_eq!(place(&device, u64::MAX), place(&device, capacity - 1));
}

proptest! {
    /// Every order is a bijection: the bursts of an aligned block lie in different columns.
    #[test]
    fn no_two_bursts_share_a_place(
        name in proptest::sample::select(
            &["lpddr4-3200-x16x8", "lpddr4-3200-x32x4", "lpddr5-6400-x16x8", "hbm2-8ch"][..]),
        order in proptest::sample::select(&[Order::RoBaCoCh, Order::Mop, Order::Bg64][..]),
        first in 0u64..1 << 20,
    ) {
        let device = device(name, &[]).with_order(order).expect("it fits");
        let decoder = Decoder::new(&device);
        let o = &device.organisation;
        let columns = o.row.0 / o.burst.0;
        let mut rows: Vec<_> = (0..4096)
            .map(|i| decoder.place(first * 4096 + i))
            .map(|p| (p.channel, p.bank, p.row))
            .collect();
        for (channel, bank, row) in &rows {
            prop_assert!(*channel < o.channels && *row < o.rows);
            prop_assert!(*bank < o.pseudo_channels * o.bank_groups * o.banks);
        }
        rows.sort_unstable();
        let different: BTreeSet<_> = rows.iter().collect();
        let most = rows.chunk_by(|a, b| a == b).map(<[_]>::len).max().unwrap_or(0);
        prop_assert!(most as u64 <= columns, "{} bursts in a row of {}", most, columns);
        prop_assert!(different.len() as u64 >= 4096 / columns);
    }
}

//! What a sweep file spans: points, columns, designs.

use powergs_core::stage::{DRAM_READ, work_id};
use std::collections::BTreeSet;
use std::sync::Arc;

use powergs_base::config::embedded::{ENERGY, find};
use powergs_base::quantity::Bytes;
use powergs_core::machine::Machine;
use powergs_core::run::files::EmbeddedFiles;
use powergs_core::sim::cost;
use powergs_core::stage::EnergyTable;
use powergs_study::sweep::{Design, Rejected, Space, SweepFile};

/// The space of a file with these lines behind question and base.
#[track_caller]
pub fn space(lines: &str) -> Space {
    let text = format!("question = \"?\"\nbase = \"gscore\"\n{lines}");
    let file = SweepFile::parse(&text).unwrap_or_else(|e| panic!("{e}"));
    Space::new(&file, Arc::new(EmbeddedFiles)).unwrap_or_else(|e| panic!("{e}"))
}

#[track_caller]
fn design(space: &Space, index: u64) -> Design {
    space.design(index).unwrap_or_else(|e| panic!("point {index}: {e}"))
}

fn column(space: &Space, name: &str) -> Vec<String> {
    let value = |i| {
        let settings = space.point(i).expect("a point").settings;
        let found = settings.into_iter().find(|s| s.name == name).expect("a column").value;
        found.as_str().map_or_else(|| found.to_string(), str::to_owned)
    };
    (0..space.lattice().points()).map(value).collect()
}

#[test]
fn points_are_nested_loops_with_the_last_axis_fastest() {
    let space = space(
        "[[axes]]\nkey = \"vru.cores\"\nvalues = [2, 4]\n\
         [[axes]]\nkey = \"ccu.units\"\nvalues = [1, 2, 4]",
    );
    assert_eq!(space.proposed(), 6);
    assert_eq!(space.columns(), ["vru.cores", "ccu.units"]);
    assert_eq!(column(&space, "vru.cores"), ["2", "2", "2", "4", "4", "4"]);
    assert_eq!(column(&space, "ccu.units"), ["1", "2", "4", "1", "2", "4"]);
    assert_eq!(space.selected().collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
    for i in 0..6 {
        assert_eq!(space.lattice().index(&space.lattice().digits(i)), i);
    }
}

#[test]
fn a_design_is_what_a_file_with_these_keys_is() {
    let space = space(
        "set = { dram.model = \"calibrated\" }\n\
         [[axes]]\nkey = \"clock\"\nvalues = [\"800 MHz\", \"1.2 GHz\"]\n\
         [[axes]]\nkey = \"dram.device\"\nvalues = [\"lpddr4-3200-x16x8\", \"lpddr5-6400-x16x8\"]\n\
         [derived]\nbuffers.feature.capacity = \"2 * 128 KiB\"",
    );
    let sets = [
        "dram.model=calibrated",
        "clock=1.2 GHz",
        "dram.device=lpddr5-6400-x16x8",
        "buffers.feature.capacity=256 KiB",
    ];
    let text = find(powergs_base::config::embedded::MACHINES, "gscore").expect("the default");
    let expected = Machine::parse_with(text, &sets.map(str::to_owned)).expect("a machine");
    let made = design(&space, 3);
    assert_eq!(made.machine, expected);
    assert_eq!(Machine::parse(&made.resolved_machine_toml()), Ok(expected.clone()));
    let table = find(ENERGY, "gscore-28nm").expect("a table");
    let table = EnergyTable::parse(table).expect("a table");
    let prices = cost::prices(&table, &expected).expect("prices");
    assert_eq!(made.prices[0].prices, Ok(prices));
    assert_eq!(made.prices[0].label, "gscore-28nm");
}

/// The memory that has a latency and an efficiency.
const FLAT: &str = "set = { dram.model = \"bandwidth\" }\n";

#[test]
fn ranges_have_equal_steps_or_equal_ratios() {
    let values = |range: &str| {
        let axis = format!("[[axes]]\nkey = \"dram.latency\"\nrange = {range}");
        column(&space(&format!("{FLAT}{axis}")), "dram.latency").join(" ")
    };
    let from = "from = \"10 ns\", to = \"40 ns\"";
    assert_eq!(values(&format!("{{ {from}, step = \"15 ns\" }}")), "10 ns 25 ns 40 ns");
    assert_eq!(values(&format!("{{ {from}, factor = 2 }}")), "10 ns 20 ns 40 ns");
    assert_eq!(values(&format!("{{ {from}, scale = \"log2\" }}")), "10 ns 20 ns 40 ns");
    assert_eq!(values(&format!("{{ {from}, count = 4 }}")), "10 ns 20 ns 30 ns 40 ns");
    let geometric = format!("{{ {from}, count = 3, scale = \"geometric\" }}");
    assert_eq!(values(&geometric), "10 ns 20 ns 40 ns");
    // 0.1 is no binary fraction: the last value is there all the same.
    let axis = "[[axes]]\nkey = \"dram.efficiency\"\nrange = { from = 0.1, to = 0.9, step = 0.1 }";
    let efficiency = space(&format!("{FLAT}{axis}"));
    assert_eq!(efficiency.proposed(), 9);
    assert_eq!(column(&efficiency, "dram.efficiency")[2], "0.3");
    // Whole numbers that a ratio makes twice are there once.
    let cores = space(
        "[[axes]]\nkey = \"ccu.units\"\n\
         range = { from = 1, to = 8, count = 8, scale = \"geometric\" }",
    );
    assert_eq!(column(&cores, "ccu.units").join(" "), "1 2 3 4 6 8");
}

#[test]
fn zips_and_variants_set_several_keys() {
    let space = space(
        "[[axes]]\nzip = { geometry.tile = [8, 16], geometry.sort-group = [16, 32] }\n\
         [[axes]]\nname = \"memory\"\nvariants = [\n\
           { name = \"base\" },\n\
           { name = \"fast\", set = { dram.channels = 16, dram.latency = \"80 ns\" } },\n\
         ]",
    );
    assert_eq!(space.columns(), ["geometry.tile", "geometry.sort-group", "memory"]);
    assert_eq!(column(&space, "memory"), ["base", "fast", "base", "fast"]);
    let made = design(&space, 3);
    assert_eq!(
        (made.machine.tiles().geometry.tile, made.machine.tiles().geometry.sort_group),
        (16, 32)
    );
    assert_eq!(made.machine.dram_peak().0, 102.4e9);
    assert_eq!(made.machine.dram.latency.0, 80.0);
    assert_eq!(made.setting("memory").and_then(|v| v.as_str()), Some("fast"));
}

#[test]
fn an_axis_that_does_not_count_has_one_point() {
    let space = space(
        "[[axes]]\nkey = \"cache.capacity\"\nvalues = [\"0 B\", \"64 KiB\"]\n\
         [[axes]]\nkey = \"cache.ways\"\nvalues = [1, 2, 8]\nwhen = \"cache.capacity > 0\"",
    );
    let duplicate = |i| matches!(space.design(i), Err(Rejected::Duplicate { canonical: 0, .. }));
    assert!(space.design(0).is_ok() && duplicate(1) && duplicate(2));
    assert!((3..6).all(|i| space.design(i).is_ok()));
    // Where it does not count, the column has what the base machine has.
    assert_eq!(column(&space, "cache.ways"), ["4", "4", "4", "1", "2", "8"]);
    assert_eq!((space.canonical(2), space.canonical(5)), (Ok(0), Ok(5)));
    assert_eq!((space.allowed(2), space.allowed(5)), (Some(0), Some(5)));
}

#[test]
fn derived_keys_follow_axes_and_each_other() {
    let space = space(
        "[[axes]]\nkey = \"vru.cores\"\nvalues = [2, 4]\n\
         [[axes]]\nname = \"tables\"\nvariants = [{ name = \"small\" }, { name = \"large\" }]\n\
         [derived]\n\
         \"buffers.feature.capacity\" = \"2 * buffers.sorting.capacity\"\n\
         \"buffers.sorting.capacity\" = \"vru.cores * if(tables == 'small', 16 KiB, 64 KiB)\"\n\
         \"geometry.test\" = \"if(vru.cores > 2, 'aabb', 'ellipse')\"\n\
         \"gsu.pivots\" = \"ceil_pow2(vru.cores + 1) - 1\"\n\
         \"dram.latency\" = \"160 / clock\"",
    );
    let made = design(&space, 3);
    assert_eq!(made.machine.tiles().buffers.sorting.capacity, Bytes(256 << 10));
    assert_eq!(made.machine.tiles().buffers.feature.capacity, Bytes(512 << 10));
    assert_eq!((made.machine.tiles().gsu.pivots, made.machine.dram.latency.0), (7, 160.0));
    let test = |i| design(&space, i).setting("geometry.test").expect("a column").to_string();
    assert_eq!((test(0), test(3)), ("\"ellipse\"".to_owned(), "\"aabb\"".to_owned()));
}

#[test]
fn constraints_leave_points_out_and_say_which() {
    let space = space(
        "constraints = [\"vru.cores * ccu.units <= 8\", \"area_mm2.core < 5\", \
         \"sram_capacity_bytes <= 1 MiB\", \"peak_w + leakage_w < 100\"]\n\
         [[axes]]\nkey = \"vru.cores\"\nvalues = [1, 4, 16]\n\
         [[axes]]\nkey = \"ccu.units\"\nvalues = [1, 4]",
    );
    let outcome = |i| space.design(i).map(|_| ()).map_err(|e| e.cause());
    assert_eq!(outcome(0), Ok(()));
    assert_eq!(outcome(3), Err("constraint `vru.cores * ccu.units <= 8`".to_owned()));
    let failed = space.design(5).expect_err("four cores too many").to_string();
    assert!(failed.contains("vru.cores * ccu.units <= 8"), "{failed}");
    let small = space.design(2).expect("four cores, one CCU");
    assert!(
        small.prices[0].prices.as_ref().expect("prices").area.as_ref().expect("an area").core().0
            < 5.0
    );
}

#[test]
fn a_machine_that_does_not_fit_together_is_left_out_with_its_reason() {
    let space =
        space("[[axes]]\nkey = \"buffers.feature.capacity\"\nvalues = [\"1 KiB\", \"64 KiB\"]");
    let error = space.design(0).expect_err("too small");
    assert!(
        error.to_string().contains("`buffers.feature.capacity` = 1 KiB is too small"),
        "{error}"
    );
    assert_eq!(error.cause(), "`buffers.feature.capacity`");
    assert!(space.design(1).is_ok());
}

#[test]
fn every_table_prices_every_point() {
    let space = space(
        "[[energy]]\nlabel = \"cheap\"\ntable = \"gscore-28nm-flat\"\n\
         [[energy]]\nlabel = \"dear\"\ntable = \"gscore-28nm-flat\"\n\
         set = { dram.flat.read.energy = \"64 pJ/B\" }\n\
         [[axes]]\nkey = \"energy:actions.alpha.energy\"\nvalues = [\"1 pJ\", \"2 pJ\"]",
    );
    assert_eq!(space.energy_labels(), ["cheap", "dear"]);
    let [one, two] = [design(&space, 0), design(&space, 1)];
    let alpha = work_id("alpha");
    let read = DRAM_READ;
    let of = |d: &Design, i: usize| {
        [alpha, read].map(|a| d.prices[i].prices.as_ref().expect("prices").of(a).0)
    };
    assert_eq!((of(&one, 0), of(&one, 1)), ([1.0, 10.88], [1.0, 64.0]));
    assert_eq!((of(&two, 0), of(&two, 1)), ([2.0, 10.88], [2.0, 64.0]));
    assert_eq!(one.timing_id, two.timing_id);
    assert_ne!(one.id, two.id);
}

#[test]
fn other_machines_tables_devices_and_displays_can_be_varied() {
    let space = space(
        "display = \"oled-powergs\"\n\
         [[axes]]\nkey = \"machine\"\nvalues = [\"gscore\", \"neo\"]\n\
         [[axes]]\nkey = \"energy\"\nvalues = [\"gscore-28nm\", \"gscore-7nm\"]\n\
         [[axes]]\nkey = \"display:scale\"\nvalues = [1, 2.5]",
    );
    let made = design(&space, 7);
    assert_eq!(made.machine.name, "neo");
    assert_eq!(made.prices[0].table.value.name, "gscore-7nm");
    assert_eq!(made.display.expect("a display").value.scale, 2.5);
    assert_eq!(column(&space, "machine")[3..5], ["gscore", "neo"]);
    let ids: BTreeSet<u128> = (0..8).map(|i| design(&space, i).id).collect();
    let timings: BTreeSet<u128> = (0..8).map(|i| design(&space, i).timing_id).collect();
    assert_eq!((ids.len(), timings.len()), (8, 2));
}

#[test]
fn the_device_of_a_timed_model_decides_timing() {
    let space = space(
        "set = { dram.model = \"banked\" }\n\
         [[axes]]\nkey = \"dram:timing.activate-to-read\"\nvalues = [20, 29]",
    );
    let [a, b] = [design(&space, 0), design(&space, 1)];
    assert_ne!(a.timing_id, b.timing_id);
    assert_eq!(a.machine.device.expect("a device").timing.activate_to_read, 20);
    let text = &b.files()[1];
    assert!(text.0 == "dram" && text.1.contains("activate-to-read = 29"));
}

#[test]
fn ids_are_those_of_what_a_key_means_not_of_how_it_is_written() {
    let one = |value: &str| {
        let space =
            space(&format!("[[axes]]\nkey = \"buffers.sorting.capacity\"\nvalues = [{value}]"));
        let made = design(&space, 0);
        (made.id, made.timing_id)
    };
    assert_eq!(one("\"64 KiB\""), one("\"65536 B\""));
    assert_ne!(one("\"64 KiB\""), one("\"32 KiB\""));
}

#[test]
fn a_huge_space_costs_nothing() {
    let axis = |key: &str, to: u32| {
        format!("[[axes]]\nkey = \"{key}\"\nrange = {{ from = 1, to = {to}, step = 1 }}\n")
    };
    let keys = ["vru.latency", "gsu.qsu-latency", "gsu.bsu-latency", "ccu.latency"];
    let lines: String = keys.map(|key| axis(key, 1000)).concat();
    let space = space(&lines);
    assert_eq!(space.proposed(), 1_000_000_000_000);
    let made = design(&space, 999_999_999_999);
    assert_eq!((made.machine.tiles().vru.latency, made.machine.tiles().ccu.latency), (1000, 1000));
    let mut grid = space.selected();
    assert_eq!((grid.next(), grid.nth(999_998)), (Some(0), Some(999_999)));
    assert_eq!(space.point(1_000_001).expect("a point").digits, [0, 1, 0, 1]);
}

#[test]
fn bytes_survive_whatever_the_unit() {
    let space = space(
        "[[axes]]\nkey = \"vru.cores\"\nvalues = [1, 3]\n\
         [derived]\nbuffers.feature.capacity = \"vru.cores * 33333 B\"",
    );
    assert_eq!(design(&space, 1).machine.tiles().buffers.feature.capacity, Bytes(99_999));
}

const GROUP: &str = "geometry.sort-group";

/// Without a word about them, sort groups and sub-tiles follow the tile, so that every point is a
/// machine; what the file says of them comes first.
#[test]
fn dependent_keys_follow_the_tile() {
    let tiles = "[[axes]]\nkey = \"geometry.tile\"\nvalues = [8, 16, 32, 64]\n";
    let space = space(tiles);
    let carried = [
        ("geometry.sort-group", "geometry.tile"),
        ("geometry.subtile", "max(min(8, geometry.tile), geometry.tile / 4)"),
    ];
    assert_eq!(space.carried(), carried);
    let geometry = |i| space.design(i).map(|d| d.machine.tiles().geometry).expect("a machine");
    let sizes: Vec<(u32, u32)> =
        (0..4).map(|i| (geometry(i).sort_group, geometry(i).subtile)).collect();
    assert_eq!(sizes, [(8, 8), (16, 8), (32, 8), (64, 16)]);
    // All units on one sub-tile: sub-tiles keep their size, up to a tile.
    let serial = format!("question = \"?\"\nbase = \"gscore-powergs\"\n{tiles}");
    let file = SweepFile::parse(&serial).unwrap_or_else(|e| panic!("{e}"));
    let space = Space::new(&file, Arc::new(EmbeddedFiles)).unwrap_or_else(|e| panic!("{e}"));
    let subtiles =
        [0, 3].map(|i| space.design(i).expect("a machine").machine.tiles().geometry.subtile);
    assert_eq!(subtiles, [8, 8]);
    assert!(space.columns().contains(&"geometry.sort-group".to_owned()));

    let said = format!("{tiles}[derived]\n\"geometry.sort-group\" = \"max(geometry.tile, 32)\"");
    let space = super::space::space(&said);
    let groups = |space: &Space| space.carried().iter().any(|(key, _)| *key == GROUP);
    assert!(!groups(&space));
    assert_eq!(space.design(0).expect("a machine").machine.tiles().geometry.sort_group, 32);
    let axis = format!("{tiles}[[axes]]\nkey = \"geometry.sort-group\"\nvalues = [64, 128]");
    assert!(!groups(&super::space::space(&axis)));
    assert!(super::space::space("").carried().is_empty());
}

/// What changes no price is free: a policy, or a resource that the table has no price for.
#[test]
fn axes_without_a_price_are_told_apart() {
    let space = space(
        "[[axes]]\nkey = \"schedule.order\"\nvalues = [\"raster\", \"morton\"]\n\
         [[axes]]\nkey = \"ccu.latency\"\nvalues = [64, 128]\n\
         [[axes]]\nkey = \"vru.cores\"\nvalues = [2, 4]",
    );
    let free: Vec<(String, bool)> =
        space.free_axes().into_iter().map(|f| (f.axis, f.is_policy)).collect();
    assert_eq!(free, [("schedule.order".to_owned(), true), ("ccu.latency".to_owned(), false)]);
}

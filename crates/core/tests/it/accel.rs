//! Is each rule of a unit tight? `check(work, cycles)`: one cycle less would be wrong.

use powergs_base::quantity::{Bytes, BytesPerSecond, Hertz, Nanoseconds};
use powergs_core::flow::tile_wise::STREAMS;
use powergs_core::flow::tile_wise::batch::{Batch, Batches};
use powergs_core::flow::tile_wise::bsu::Sort;
use powergs_core::flow::tile_wise::qsu::Keys;
use powergs_core::flow::tile_wise::vru::Render;
use powergs_core::flow::tile_wise::{CodebookSpec, Fetch};
use powergs_core::flow::tile_wise::{ResolvedUnits, replay};
use powergs_core::kernel::Unit;
use powergs_core::kernel::bank::Banks;
use powergs_core::kernel::buffer::{BufferAllocator, usage};
use powergs_core::kernel::divide::Divisor;
use powergs_core::kernel::dram::{Channel, Dram, TICKS};
use powergs_core::machine::Machine;
use powergs_core::machine::{BufferSpec, DramModel, DramSpec, MasterSpec, MemoryOwner, Ports};
use powergs_core::stage::{DRAM_READ, DRAM_WRITE, buffer_id, sram_read, sram_write, work_id};
use powergs_core::workload::{ChunkWork, Geometry, PairWork, StoragePrefix, TileWork};
use powergs_dram::device::Order;
use powergs_energy::action::{ActionCounts, Phase};

use crate::pipeline::support::{Dice, TilePlan, gscore, workload};

fn design(change: impl FnOnce(&mut Machine)) -> ResolvedUnits {
    let mut machine = gscore();
    change(&mut machine);
    ResolvedUnits::new(&machine)
}

fn chunk(entries: u32, pairs: u32) -> ChunkWork {
    ChunkWork {
        entries,
        skipping: PairWork { subtile_pairs: pairs, live_evaluations: pairs, ..PairWork::default() },
        unskipped: PairWork { subtile_pairs: 4 * entries, ..PairWork::default() },
        first_loads: entries / 2,
        ..ChunkWork::default()
    }
}

/// Keys that all are sorted, on a machine with seven pivots and chunks of 256.
fn keys(held: u64) -> Keys {
    let passes = [256, 2048, 16384].iter().filter(|&&most| held > most).count() as u32;
    Keys { held, sorted: held, passes, ..Keys::default() }
}

fn charged<U: Unit>(unit: &U, work: &U::Work) -> ActionCounts {
    let mut actions = ActionCounts::default();
    unit.charge(work, &mut actions);
    actions
}

#[test]
fn ccu_holds_the_entry_for_records_and_for_tests() {
    let batch = |records, prepared, tests| Batch {
        records,
        survivors: records,
        prepared,
        tests,
        ..Batch::default()
    };
    let check = |rate: u32, per_cycle: u32, work, cycles| {
        let design = design(|m| {
            (m.tiles_mut().ccu.operations_per_cycle, m.tiles_mut().ccu.intersection_units) =
                (rate, per_cycle);
        });
        assert_eq!(design.ccu.cycles(&work), cycles, "{rate} {per_cycle} {work:?}");
    };
    // A survivor takes 47 + 208 operations, one with a box 38 more; colours come later.
    check(426, 1, batch(32, 0, 0), 32);
    check(255, 1, batch(32, 0, 0), 32);
    check(85, 1, batch(32, 0, 0), 96);
    check(254, 1, batch(32, 0, 0), 33);
    check(293, 1, batch(32, 8, 8), 32);
    check(293, 1, batch(32, 8, 9), 33);
    check(426, 1, batch(32, 8, 40), 32 + 32);
    check(426, 4, batch(32, 8, 41), 32 + 3);
    // 32 x 255 + 8 x 38 operations are 42.3 cycles of 200, behind which the tests hide.
    check(200, 4, batch(32, 8, 41), 43);
    check(1, 4, batch(32, 8, 41), 32 * 255 + 8 * 38);
    check(426, 1, batch(0, 0, 0), 1);
}

#[test]
fn ccu_takes_as_long_as_its_operations() {
    let batch = Batch { records: 100, survivors: 60, splats: 25, ..Batch::default() };
    let cycles = |fetch, rate| {
        let design = design(|m| {
            (m.tiles_mut().ccu.fetch, m.tiles_mut().ccu.operations_per_cycle) = (fetch, rate)
        });
        design.ccu.cycles(&batch)
    };
    let geometry = 100 * 47 + 60 * 208;
    assert_eq!(cycles(Fetch::LazyColour, 1), geometry);
    assert_eq!(cycles(Fetch::VisibleColour, 1), geometry + 25 * 133);
    assert_eq!(cycles(Fetch::GeometryFirst, 1), geometry + 60 * 133);
    assert_eq!(cycles(Fetch::GeometryFirst, 16), (geometry + 60 * 133_u64).div_ceil(16));
    assert_eq!(cycles(Fetch::GeometryFirst, 100_000), 100);
}

#[test]
fn ccu_takes_as_long_as_its_codebook() {
    let batch = Batch { records: 100, survivors: 60, splats: 25, ..Batch::default() };
    let cycles = |fetch, banks| {
        let design = design(|m| {
            (m.tiles_mut().ccu.fetch, m.tiles_mut().ccu.operations_per_cycle) = (fetch, 100_000);
            m.tiles_mut().codebook =
                CodebookSpec { entries: 16, entry: Bytes(90), word: Bytes(4), banks };
        });
        design.ccu.cycles(&batch)
    };
    // 23 words of 4 B.
    assert_eq!(cycles(Fetch::VisibleColour, 1), 25 * 23);
    assert_eq!(cycles(Fetch::VisibleColour, 5), 25 * 5);
    assert_eq!(cycles(Fetch::GeometryFirst, 5), 60 * 5);
    assert_eq!(cycles(Fetch::VisibleColour, 23), 100, "behind the records");
    assert_eq!(cycles(Fetch::LazyColour, 1), 100, "cores look up");
}

#[test]
fn divisors_divide() {
    for by in [1, 2, 3, 7, 8, 1000, 1 << 40, u64::MAX] {
        let divisor = Divisor::new(by);
        assert_eq!(divisor.get(), by);
        for n in [0, 1, 2, 3, 6, 7, 8, 9, 999, 1000, 1001, (1 << 40) + 1, u64::MAX - 1, u64::MAX] {
            assert_eq!(divisor.div_ceil(n), n.div_ceil(by), "{n} / {by}");
        }
    }
}

#[test]
fn ccu_reads_what_the_policy_says() {
    let batch = Batch { records: 10, survivors: 4, splats: 3, pairs: 7, ..Batch::default() };
    let check = |fetch, reads: [u64; 3], most, colours| {
        let ccu =
            design(|m| (m.tiles_mut().ccu.fetch, m.tiles_mut().ccu.batch) = (fetch, 1000)).ccu;
        assert_eq!([0, 1, 2].map(|read| ccu.read(&batch, read)), reads);
        assert_eq!(ccu.batch, most);
        assert_eq!(charged(&ccu, &batch).total(work_id("sh-colour")), colours);
        assert_eq!(ccu.written(&batch), 3 * 10 + 7 * 4);
    };
    // 2 KiB of input buffer a unit hold 16 records of 121 bytes, or 113 of 18.
    check(Fetch::Everything, [10 * 121, 0, 0], 16, 4);
    check(Fetch::GeometryFirst, [60, 4 * 115, 0], 16, 4);
    check(Fetch::VisibleColour, [60, 48, 3 * 103], 16, 3);
    check(Fetch::LazyColour, [60, 48, 0], 113, 0);
}

#[test]
fn a_batch_needs_less_the_more_of_it_is_known() {
    let batch = Batch { records: 10, survivors: 4, splats: 3, ..Batch::default() };
    let ccu = design(|m| m.tiles_mut().ccu.fetch = Fetch::VisibleColour).ccu;
    assert_eq!(ccu.may_read(&batch, 0, 1), 10 * 12 + 10 * 103);
    assert_eq!(ccu.may_read(&batch, 1, 1), 4 * 12 + 4 * 103);
    assert_eq!(ccu.may_read(&batch, 1, 2), 4 * 103);
    assert_eq!(ccu.may_read(&batch, 2, 2), 3 * 103);
    assert_eq!(ccu.may_read(&batch, 3, 3), 0);
}

#[test]
fn batches_spread_every_counter_without_loss() {
    for seed in 0..50 {
        let mut dice = Dice::new(seed);
        let mut frame = dice.workload(Geometry::REFERENCE);
        frame.counters.points = u64::from(dice.roll(1, 200));
        frame.counters.survivors = frame.counters.points / 3;
        frame.storage.clear();
        let size = dice.roll(1, 70);
        let batches: Vec<Batch> = Batches::new(&frame, size, frame.counters.tile_pairs).collect();
        let sum = |field: fn(&Batch) -> u64| batches.iter().map(field).sum::<u64>();
        let whole = Batch::whole(&frame, frame.counters.tile_pairs);
        assert_eq!(sum(|b| b.records), whole.records);
        assert_eq!(sum(|b| b.survivors), whole.survivors);
        assert_eq!(sum(|b| b.prepared), whole.prepared);
        assert_eq!(sum(|b| b.tests), whole.tests);
        assert_eq!(sum(|b| b.splats), whole.splats);
        assert_eq!(sum(|b| b.pairs), whole.pairs);
        assert!(batches.iter().all(|b| b.records <= u64::from(size) && b.survivors <= b.records));
    }
}

/// Bounds are tested in order, and records are read of clusters with survivors alone.
#[test]
fn clusters_without_survivors_are_not_read() {
    let (mut skipped, mut tested) = (0, 0);
    for seed in 0..200 {
        let mut dice = Dice::new(seed);
        let mut frame = dice.workload(Geometry::REFERENCE);
        let points = u64::from(dice.roll(1, 3000));
        let blocks = points.div_ceil(32) as usize;
        let mut at = StoragePrefix::default();
        frame.storage = (0..blocks)
            .map(|_| {
                // Most blocks are behind the camera.
                let own = if dice.roll(0, 3) == 0 { dice.roll(1, 9) } else { 0 };
                at.survivors += own;
                at.splats += own / 2;
                at.pairs += own / 2 * 3;
                at
            })
            .collect();
        let c = &mut frame.counters;
        (c.points, c.survivors) = (points, at.survivors.into());
        (c.intersecting_points, c.tile_pairs) = (at.splats.into(), at.pairs.into());
        (c.obb_prepared, c.obb_tests) = (0, 0);
        let (size, batch, tests) = (32 * dice.roll(1, 4), dice.roll(1, 70), dice.roll(1, 9).into());
        let pairs = frame.counters.tile_pairs;
        let all = Batches::new(&frame, batch, pairs).with_clusters(&frame, size, tests);
        let batches: Vec<Batch> = all.collect();
        let size = u64::from(size);
        let mut expected: Vec<u64> = Vec::new();
        for cluster in 0..points.div_ceil(size) {
            let of = |block: u64| match block.min(blocks as u64) {
                0 => 0,
                block => frame.storage[block as usize - 1].survivors,
            };
            let own = cluster * size..((cluster + 1) * size).min(points);
            if of((cluster + 1) * size / 32) > of(cluster * size / 32) {
                expected.extend(own);
            } else {
                skipped += 1;
            }
        }
        let read: Vec<u64> = batches.iter().flat_map(|b| b.first..b.first + b.records).collect();
        assert_eq!(read, expected, "seed {seed}");
        let of_bounds = batches.iter().filter(|b| b.clusters > 0);
        let bounds: Vec<u64> = of_bounds.flat_map(|b| b.first..b.first + b.clusters).collect();
        assert_eq!(bounds, (0..points.div_ceil(size)).collect::<Vec<u64>>());
        let mut known = 0;
        for b in &batches {
            assert!(b.records == 0 || b.clusters == 0, "one or the other");
            assert!(b.records <= u64::from(batch) && b.clusters <= tests);
            assert!(b.first + b.records <= known || b.clusters > 0, "untested records are read");
            known += b.clusters * size;
            tested += u64::from(b.clusters > 0);
        }
        let whole = &Batch::passes(&frame, pairs, None, size as u32)[0];
        let sum = |field: fn(&Batch) -> u64| batches.iter().map(field).sum::<u64>();
        for field in [
            (|b| b.records) as fn(&Batch) -> u64,
            |b| b.clusters,
            |b| b.survivors,
            |b| b.splats,
            |b| b.pairs,
        ] {
            assert_eq!(sum(field), field(whole), "seed {seed}");
        }
    }
    assert!(skipped > 1000 && tested > 1000, "{skipped} {tested}");
}

#[test]
fn qsu_passes_until_parts_fit_a_chunk() {
    let passes = |entries| design(|_| ()).qsu.passes(entries);
    for (entries, expected) in
        [(0, 0), (1, 0), (256, 0), (257, 1), (2048, 1), (2049, 2), (16384, 2), (16385, 3)]
    {
        assert_eq!(passes(entries), expected, "{entries} entries");
    }
    let one_pivot = design(|m| m.tiles_mut().gsu.pivots = 1).qsu;
    assert_eq!(one_pivot.passes(257), 1);
    assert_eq!(one_pivot.passes(513), 2);
}

#[test]
fn qsu_pass_is_latency_and_keys() {
    let qsu =
        design(|m| (m.tiles_mut().gsu.qsu_per_core, m.tiles_mut().gsu.keys_per_cycle) = (2, 3)).qsu;
    assert_eq!(qsu.pass_cycles(&keys(600), 0), 64 + 7 + 100);
    assert_eq!(qsu.pass_cycles(&keys(601), 0), 64 + 7 + 101);
    // Eight parts in the second pass, four for each unit.
    assert_eq!(qsu.cycles(&keys(2400)), (64 + 7 + 400) + (64 + 4 * 7 + 400));
    let actions = charged(&qsu, &keys(2400));
    assert_eq!(actions.count(Phase::Sorting, work_id("pivot-key")), 4800);
    // 4-byte keys: written on arrival and in both passes, read in both.
    assert_eq!(actions.total(sram_write(buffer_id("sorting"))), 3 * 9600);
    assert_eq!(actions.total(sram_read(buffer_id("sorting"))), 2 * 9600);
}

#[test]
fn lists_that_do_not_fit_the_sorting_buffer_spill_in_every_pass() {
    // 16 KiB a core hold 4096 keys.
    let qsu = design(|_| ()).qsu;
    assert_eq!(qsu.overflow(&keys(4096)), 0);
    assert_eq!(qsu.overflow(&keys(4100)), 16);
    assert_eq!(qsu.resident(&keys(4100)), 16384);
    let tile = TilePlan { chunks: vec![(256, 300)], unfetched: 4100 - 256, pixels: 256 };
    let machine = gscore();
    let spilled =
        replay(&workload(machine.tiles().geometry, 0, &[tile]), &machine).served.stages[1];
    // Two passes (4100 > 256 * 8), 16 bytes each way in both.
    assert_eq!((spilled.read, spilled.write), (4 * 4100 + 32, 32));
}

#[test]
fn bsu_sorts_rows_and_merges_levels() {
    let check = |units, entries, cycles, exchanges| {
        let bsu = design(|m| m.tiles_mut().gsu.bsu_per_core = units).bsu;
        assert_eq!(bsu.cycles(&Sort { keys: entries, filtered: 0 }), cycles, "{entries} entries");
        assert_eq!(bsu.compare_exchanges(bsu.chunk_rows(entries)), exchanges, "{entries} entries");
    };
    // A 16-wide network has 10 stages of 8; a merged row costs 16 + 4 * 8.
    check(1, 1, 4 + 1, 80);
    check(1, 16, 4 + 1, 80);
    check(1, 17, 2 * (4 + 2), 2 * (80 + 48));
    check(1, 256, 5 * (4 + 16), 16 * (80 + 4 * 48));
    check(2, 256, 5 * (4 + 8), 16 * (80 + 4 * 48));
    let scalar = design(|m| m.tiles_mut().gsu.bsu_width = 1).bsu;
    // Width 1 is a plain merge sort: no exchange inside a row, one per merged key.
    assert_eq!(scalar.compare_exchanges(scalar.chunk_rows(4)), 4 * 2);
}

#[test]
fn vru_pairs_entries_and_finish() {
    let vru = design(|_| ()).vru;
    let middle = |entries, pairs| Render { chunk: chunk(entries, pairs), ..Render::default() };
    assert_eq!(vru.pair_cycles(), 4);
    assert_eq!(vru.cycles(&middle(256, 300)), 1200);
    assert_eq!(vru.cycles(&middle(256, 10)), 256, "an entry leaves the buffer every cycle");
    let tile = TileWork { chunks: 1, pixels: 250, blends: 77, ..TileWork::default() };
    let end = Render { chunk: chunk(256, 300), run: None, last: Some(tile), drains: true };
    assert_eq!(vru.cycles(&end), 1 + 1200 + 192 + 16);
    let empty = Render { last: Some(TileWork { chunks: 0, ..tile }), ..Render::default() };
    assert_eq!(vru.cycles(&empty), 1 + 16, "nothing to drain");
    let unskipped = design(|m| m.tiles_mut().vru.subtile_skipping = false).vru;
    assert_eq!(unskipped.cycles(&middle(256, 300)), 4 * 4 * 256);
    for (subtile, units, pixels, cycles) in
        [(8, 16, 4, 4), (8, 8, 4, 8), (8, 5, 4, 16), (4, 16, 4, 4), (4, 16, 1, 1), (16, 16, 4, 16)]
    {
        let vru = design(|m| {
            m.tiles_mut().geometry.subtile = subtile;
            m.tiles_mut().vru.recurrence = 1;
            (m.tiles_mut().vru.units_per_core, m.tiles_mut().vru.pixels_per_unit) = (units, pixels);
        });
        assert_eq!(vru.vru.pair_cycles(), cycles, "{subtile} {units} {pixels}");
    }
    let actions = charged(&vru, &end);
    // One pixel of each pair is live.
    assert_eq!(actions.count(Phase::Rendering, work_id("alpha")), 300);
    assert_eq!(actions.count(Phase::Rendering, work_id("stopped-pixel")), 300 * 63);
    assert_eq!(actions.count(Phase::Rendering, work_id("blend")), 77);
    assert_eq!(actions.count(Phase::Rendering, work_id("pixel-finish")), 250);
    assert_eq!(actions.total(work_id("sh-colour")), 0, "colour units do that");
    assert_eq!(actions.total(sram_read(buffer_id("feature"))), 256 * 19);
    assert_eq!(actions.total(sram_write(buffer_id("pixel_out"))), 750);
}

fn dram(bandwidth: f64, efficiency: f64, latency: f64, clock: f64) -> Dram {
    let spec = DramSpec {
        model: DramModel::Bandwidth,
        bandwidth: None,
        efficiency,
        latency: Nanoseconds(latency),
        device: "test".into(),
        channels: 8,
        mapping: Order::RoBaCoCh,
        controller_latency: Nanoseconds(40.0),
        owner: MemoryOwner::Chip,
        standby_share: None,
        second_master: MasterSpec::default(),
        third_master: MasterSpec::default(),
        fourth_master: MasterSpec::default(),
    };
    Dram::new(&spec, BytesPerSecond(bandwidth), Hertz(clock), &STREAMS)
}

#[test]
fn dram_serves_in_order_at_its_rate() {
    let dram = dram(51.2e9, 1.0, 100.0, 1e9);
    let (read, write) = (STREAMS.id("features"), STREAMS.id("pixels"));
    assert_eq!((dram.service(read, 1), dram.service(read, 512)), (20, 10 * TICKS));
    assert_eq!((dram.latency(read, 7), dram.latency(write, 7)), (100 * TICKS, 0));
    let mut channel = Channel::new(dram);
    assert_eq!(channel.serve(0, read, 512), 110);
    // The bus is busy until cycle 10, then for 0.02 cycles more.
    assert_eq!(channel.serve(3, read, 1), 111);
    assert_eq!(channel.serve(3, write, 1), 11);
    assert_eq!(channel.serve(50, write, 512), 60);
    assert_eq!((channel.served(), channel.busy_cycles()), (4, 21));
    let bytes = channel.bytes();
    assert_eq!((bytes[read.index()], bytes[write.index()]), (513, 513));
}

#[test]
fn dram_rate_scales_with_clock_and_efficiency_and_is_never_above_peak() {
    assert_eq!(dram(51.2e9, 0.5, 10.0, 1e9).service(STREAMS.id("lists"), 512), 20 * TICKS);
    assert_eq!(dram(51.2e9, 1.0, 10.0, 2e9).service(STREAMS.id("lists"), 512), 20 * TICKS);
    assert_eq!(dram(51.2e9, 1.0, 10.0, 2e9).latency(STREAMS.id("lists"), 0), 20 * TICKS);
    // A rate that no tick divides: requests round up, so the sum never beats the rate by more than
    // the rounding of the rate itself (32 fractional bits).
    let odd = dram(7.3e9, 0.83, 0.0, 1.1e9);
    for bytes in [1u64, 3, 19, 64, 103, 4864, 1 << 30] {
        let ideal = bytes as f64 * 1024.0 * 1.1e9 / (7.3e9 * 0.83);
        let ticks = odd.service(STREAMS.id("records"), bytes) as f64;
        assert!(ticks >= ideal * (1.0 - 1e-9) && ticks <= ideal * (1.0 + 1e-9) + 1.0, "{bytes}");
    }
    assert!(dram(1e18, 1.0, 0.0, 1e9).service(STREAMS.id("records"), 1) == 1, "no request is free");
}

#[test]
fn rooms_admit_what_fits_and_anything_when_empty() {
    let mut room = BufferAllocator::new(100);
    assert!(room.admits(1000));
    room.fill(0, 60);
    assert!(room.admits(40) && !room.admits(41));
    room.fill(10, 30);
    room.release(15, 60);
    room.discard(20, 30);
    let seen = usage(buffer_id("feature"), [&room, &room].into_iter());
    assert_eq!((seen.capacity, seen.peak, seen.filled), (200, 180, 180));
    assert_eq!((seen.consumed, seen.discarded), (120, 60));
    assert_eq!(seen.byte_cycles, 2 * (10 * 60 + 5 * 90 + 5 * 30));
}

#[test]
#[should_panic(expected = "more bytes freed than allocated")]
fn buffers_do_not_free_more_than_is_allocated() {
    let mut room = BufferAllocator::new(100);
    room.fill(0, 5);
    room.release(0, 6);
}

#[test]
fn banks_serve_one_access_each() {
    let bank = |word, banks, ports| {
        Banks::new(&BufferSpec { capacity: Bytes(1 << 20), word: Bytes(word), banks, ports })
    };
    let one = bank(16, 4, Ports::ReadOrWrite);
    assert_eq!((one.words(33), one.words_of_records(5, 17)), (3, 10));
    assert_eq!(one.excess(20, 20, 10), 0, "4 banks serve 40 accesses in 10 cycles");
    assert_eq!(one.excess(20, 21, 10), 1);
    assert_eq!(bank(16, 4, Ports::ReadAndWrite).excess(20, 21, 5), 1);
    // 64 keys of 4 B are 16 words each way: one read and one write a cycle on one bank take twice
    // the 16 cycles; on 8 banks, 8 (1 - (7/8)^2) = 1.875 of 2 accesses are served in a cycle.
    assert_eq!(bank(16, 1, Ports::ReadOrWrite).excess_of_dealing(64, 4, 16), 16);
    assert_eq!(bank(16, 8, Ports::ReadOrWrite).excess_of_dealing(64, 4, 16), 2);
    assert_eq!(bank(16, 8, Ports::ReadOrWrite).excess_of_dealing(64, 4, 64), 0);
}

#[test]
fn traffic_of_a_frame_has_a_closed_form() {
    let mut machine = gscore();
    let tile = |n, unfetched| TilePlan { chunks: vec![(n, 2 * n)], unfetched, pixels: 256 };
    let mut frame = workload(machine.tiles().geometry, 1000, &[tile(256, 44), tile(100, 0)]);
    frame.counters.survivors = 700;
    frame.counters.intersecting_points = 300;
    let pairs = 400;
    for (fetch, read, colours) in [
        (Fetch::Everything, 1000 * 121, 0),
        (Fetch::GeometryFirst, 6000 + 700 * 115, 0),
        (Fetch::VisibleColour, 6000 + 700 * 12 + 300 * 103, 0),
        (Fetch::LazyColour, 6000 + 700 * 12, 178 * 103),
    ] {
        machine.tiles_mut().ccu.fetch = fetch;
        let replay = replay(&frame, &machine);
        let [pre, sort, render] = replay.served.stages;
        assert_eq!((pre.read, pre.write), (read, 300 * 10 + pairs * 4));
        assert_eq!((sort.read, sort.write), (pairs * 4, 0));
        assert_eq!((render.read, render.write), (356 * 19 + colours, 512 * 3));
        assert_eq!(replay.actions.count(Phase::Rendering, DRAM_READ), render.read);
        assert_eq!(replay.actions.total(DRAM_WRITE), replay.served.total().write);
    }
    machine.tiles_mut().record.position = Bytes(0);
    assert_eq!(replay(&frame, &machine).served.stages[0].read, 700 * 12);
}

#[test]
#[should_panic(expected = "machines of its geometry")]
fn a_workload_of_another_geometry_is_refused() {
    let mut machine = gscore();
    let frame = workload(machine.tiles().geometry, 0, &[]);
    machine.tiles_mut().geometry.tile = 32;
    replay(&frame, &machine);
}

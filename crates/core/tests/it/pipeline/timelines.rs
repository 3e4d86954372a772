//! Pictures of small frames: one character per cycle, the digit of the batch or tile, the first
//! letter of its cause for a stall (records, list, features, input, output, bank), `.` for idle.

use expect_test::{Expect, expect};
use powergs_base::quantity::{Bytes, Nanoseconds};
use powergs_core::flow::tile_wise::Fetch;
use powergs_core::flow::tile_wise::{FrameContext, replay_with};
use powergs_core::kernel::Memo;
use powergs_core::kernel::timeline::Timeline;
use powergs_core::machine::Machine;
use powergs_core::workload::{FrameWorkload, Geometry};

use super::support::{TilePlan, buffer, gscore, set_rate, workload};

/// One CCU and one core with short pipelines and chunks of 4.
fn small() -> Machine {
    let mut m = gscore();
    m.tiles_mut().geometry = Geometry { chunk: 4, ..Geometry::REFERENCE };
    (m.tiles_mut().ccu.units, m.tiles_mut().ccu.batch, m.tiles_mut().ccu.latency) = (1, 4, 2);
    m.tiles_mut().ccu.fetch = Fetch::LazyColour;
    (m.tiles_mut().gsu.qsu_per_core, m.tiles_mut().gsu.qsu_latency, m.tiles_mut().gsu.pivots) =
        (1, 0, 1);
    (m.tiles_mut().gsu.bsu_width, m.tiles_mut().gsu.bsu_latency) = (4, 1);
    (m.tiles_mut().vru.cores, m.tiles_mut().vru.latency, m.tiles_mut().vru.units_per_core) =
        (1, 2, 64);
    (m.tiles_mut().record.feature, m.tiles_mut().record.colour) = (Bytes(16), Bytes(8));
    (m.tiles_mut().record.projected, m.tiles_mut().record.pixel) = (Bytes(2), Bytes(1));
    set_rate(&mut m, 32e9);
    m.dram.latency = Nanoseconds(3.0);
    m
}

fn drawn(machine: &Machine, frame: &FrameWorkload) -> String {
    let mut timeline = Timeline::default();
    replay_with(frame, machine, FrameContext::default(), &Memo::default(), &mut timeline);
    timeline.draw()
}

/// Checks the rows of all units but colour units, which have nothing to do.
fn check(machine: &Machine, frame: &FrameWorkload, expected: Expect) {
    let all = drawn(machine, frame);
    let shown = all.lines().filter(|row| !row.starts_with("colour"));
    expected.assert_eq(&shown.map(|row| format!("{row}\n")).collect::<String>());
}

fn tile(chunks: &[(u32, u32)]) -> TilePlan {
    TilePlan { chunks: chunks.to_vec(), unfetched: 0, pixels: 64 }
}

/// Three tiles: two chunks after one pass, none, one chunk. Their colours are there.
fn three_tiles(machine: &Machine) -> FrameWorkload {
    let tiles = [tile(&[(4, 2), (3, 1)]), tile(&[]), tile(&[(4, 2)])];
    let mut frame = workload(machine.tiles().geometry, 10, &tiles);
    frame.chunks.iter_mut().for_each(|chunk| chunk.first_loads = 0);
    frame
}

#[test]
fn a_small_frame() {
    let machine = small();
    check(
        &machine,
        &three_tiles(&machine),
        expect![[r#"
            ccu0 |rrrrrrrrr0000111122.....................................................
            qsu0 |......................llll00000000billlllloooooo........................
            bsu0 |......................lllliiiiiiiii0000ooooooooo22......................
            vru0 |......................lllliiiiiiiiifffff000000000000000011222222222222..
        "#]],
    );
}

#[test]
fn a_feature_buffer_of_one_chunk_serialises_loading_and_rendering() {
    let mut machine = small();
    machine.tiles_mut().buffers.feature = buffer(Bytes(64));
    check(
        &machine,
        &three_tiles(&machine),
        expect![[r#"
            ccu0 |rrrrrrrrr0000111122...............................................................
            qsu0 |......................llll00000000bioooooooooooolllll.............................
            bsu0 |......................lllliiiiiiiii00ooooooooooo00ooooooooooo22...................
            vru0 |......................lllliiiiiiiiifffff00000000fffff0000000011fffff222222222222..
        "#]],
    );
}

#[test]
fn a_slow_memory_starves_everybody() {
    let mut machine = small();
    set_rate(&mut machine, 16e9);
    check(
        &machine,
        &three_tiles(&machine),
        expect![[r#"
            ccu0 |rrrrrrrrrrr0000111122..........................................................
            qsu0 |........................lllll00000000billlllllllloooo..........................
            bsu0 |........................llllliiiiiiiii0000ooooooooooo22........................
            vru0 |........................llllliiiiiiiiifffffff000000000000000011222222222222....
        "#]],
    );
}

#[test]
fn two_cores_share_the_queue_of_tiles() {
    let mut machine = small();
    machine.tiles_mut().vru.cores = 2;
    check(
        &machine,
        &three_tiles(&machine),
        expect![[r#"
            ccu0 |rrrrrrrrr0000111122.......................................
            qsu0 |......................llll00000000b.......................
            qsu1 |......................illll...............................
            bsu0 |......................lllliiiiiiiii0000...................
            bsu1 |......................illll22.............................
            vru0 |......................lllliiiiiiiiifffff0000000000000000..
            vru1 |......................ii11lffffff222222222222.............
        "#]],
    );
}

/// Two colours of 133 operations take 14 cycles of the entry and two of the pipeline, one takes 7
/// and two; the second chunk enters when the first has left the entry.
#[test]
fn a_slow_colour_unit_is_waited_for() {
    let mut machine = small();
    machine.tiles_mut().vru.colour_operations_per_cycle = 19;
    let frame = workload(machine.tiles().geometry, 0, &[tile(&[(4, 2), (3, 1)])]);
    let expected = expect![[r#"
        ccu0 |.....................................................
        qsu0 |llll00000000b........................................
        bsu0 |lllliiiiiiiii0000....................................
        vru0 |lllliiiiiiiiiffffffcccccccccccccccc0000000000000000..
        colour0 |lllliiiiiiiiiffffff000000000000000000000.............
    "#]];
    expected.assert_eq(&drawn(&machine, &frame));
}

//! Foveated frames as traces, workloads and work of machines.

use std::io::Cursor;

use powergs_base::config::embedded::{ENERGY, MACHINES, find};
use powergs_core::flow::tile_wise::replay;
use powergs_core::machine::Machine;
use powergs_core::sim::{Incompatible, Label, SimError, cost, simulate};
use powergs_core::stage::EnergyTable;
use powergs_core::stage::hardware;
use powergs_core::workload::{ChunkWork, FrameWorkload, Geometry, TileWork, bin};
use powergs_energy::action::Phase;
use powergs_frame::splat::{Cover, TileGrid};
use powergs_frame::trace::{Frame, NEVER, Reader, TraceHeader, Writer};
use powergs_raster::{Detail, FoveatedFrame, Options, render, render_foveated};
use powergs_scene::{Foveated, StorageOrder};
use powergs_testkit::foveated::{gaze_at, levels};
use powergs_testkit::scenes::front_camera;

use crate::workload::support::GEOMETRIES;

fn rendered(seed: u64, points: usize) -> (FoveatedFrame, Frame) {
    let mut parts = levels(seed, points, 0, 0.7);
    // Opaque enough that pixels stop.
    parts.iter_mut().for_each(|p| p.logit_opacities.iter_mut().for_each(|o| *o += 1.5));
    let model = Foveated::compose(&parts).expect("nested levels");
    let camera = front_camera(150, 90);
    let options = Options::reference(Detail::Counters);
    let frame = render_foveated(&model, &camera, &gaze_at([0.4, 0.6]), &options).expect("a gaze");
    (frame.clone(), frame.into_frame(&camera, [0.0; 3]))
}

fn machine(sets: &[&str]) -> Machine {
    let text = find(MACHINES, "gscore").expect("it comes with the program");
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    Machine::parse_with(text, &sets).expect("a machine")
}

#[test]
fn the_workload_counts_what_the_rasteriser_counts() {
    let (rendered, frame) = rendered(1, 6000);
    assert!(frame.pixels.stop_rank.iter().any(|&s| s != NEVER && s > 0), "some pixels stop");
    let w = bin(&frame, Geometry::REFERENCE);
    assert_eq!(w.counters, rendered.counters);
    let fovea = w.fovea.as_ref().expect("a foveated frame");
    assert_eq!(fovea.counters, rendered.fovea);
    assert_eq!(fovea.regions.len(), w.tiles.len());
    for (i, (tile, own)) in w.tiles.iter().zip(&rendered.tiles).enumerate() {
        let count = &own.count;
        assert_eq!((tile.entries, tile.loaded), (count.entries, count.loaded), "tile {i}");
        assert_eq!(tile.alpha_evaluations, count.alpha_evaluations, "tile {i}");
        assert_eq!(tile.blends, count.blends, "tile {i}");
        assert_eq!((tile.blends_2, tile.extra_alpha), (own.blends_2, own.extra_alpha), "tile {i}");
    }
}

/// Entries that a pixel iterates of a list: one after the other.
fn iterated(list: &[u32], stop: u32) -> u32 {
    list.iter().filter(|&&rank| stop == NEVER || rank <= stop).count() as u32
}

struct Naive<'a> {
    frame: &'a Frame,
    w: &'a FrameWorkload,
    tiles: powergs_frame::fovea::TileLevels,
}

impl Naive<'_> {
    fn check_tile(&self, index: usize, tile: &TileWork) {
        let (frame, w) = (self.frame, self.w);
        let fovea = frame.fovea.as_ref().expect("foveated");
        let level = self.tiles.tiles[index];
        let (tx, ty) = (index as u32 % w.tiles_x, index as u32 / w.tiles_x);
        let grid = self.tiles.grid;
        let touches = |&rank: &u32| {
            let cover = Cover::new(&frame.splats[rank as usize], grid, w.geometry.test);
            let highest = fovea.highest_level[rank as usize];
            highest >= level.first && cover.row(ty).is_some_and(|r| (r.x0..r.x1).contains(&tx))
        };
        let list: Vec<u32> = (0..frame.splats.len() as u32).filter(touches).collect();
        assert_eq!(w.list_of(tile), list, "tile {index} of {:?}", w.geometry);
        let is_second =
            |rank: u32| level.blends && fovea.highest_level[rank as usize] > level.first;
        let (x0, y0, x1, y1) = grid.pixels(tx, ty);
        let width = frame.facts.camera.width;
        let (mut evaluated, mut most) = (0, 0);
        // How long any pixel of each sub-tile blends both.
        let side = w.geometry.subtiles_per_side();
        let mut both_until = vec![0; w.geometry.subtiles() as usize];
        for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
            let i = (y * width + x) as usize;
            let stops = [frame.pixels.stop_rank[i], fovea.stop_rank_2[i]];
            let [a, b] = stops.map(|stop| iterated(&list, stop));
            evaluated += u64::from(a.max(b));
            most = most.max(a.max(b));
            let subtile = (y - y0) / w.geometry.subtile * side + (x - x0) / w.geometry.subtile;
            if level.blends && stops.iter().all(|&stop| stop > 0) {
                let until = &mut both_until[subtile as usize];
                *until = a.min(b).max(*until);
            }
        }
        assert_eq!(tile.alpha_evaluations, evaluated, "tile {index}");
        let chunks = most.div_ceil(w.geometry.chunk).max(u32::from(!list.is_empty()));
        assert_eq!(tile.chunks, chunks, "tile {index}");
        let mut at = 0;
        for chunk in w.chunks_of(tile) {
            let own = &list[at as usize..][..chunk.entries as usize];
            let seconds = own.iter().filter(|&&rank| is_second(rank)).count() as u32;
            assert_eq!(chunk.seconds, seconds, "tile {index}");
            let both = |end: &u32| {
                let reach = end.saturating_sub(at).min(chunk.entries) as usize;
                own[..reach].iter().filter(|&&rank| is_second(rank)).count() as u32
            };
            let pairs: u32 = both_until.iter().map(both).sum();
            assert_eq!(chunk.unskipped.both_pairs, pairs, "tile {index}");
            assert!(chunk.skipping.both_pairs <= pairs);
            at += chunk.entries;
        }
        assert_eq!(tile.mixed, if level.blends { tile.pixels } else { 0 });
    }
}

#[test]
fn lists_and_chunks_by_definition_under_other_geometries() {
    let (_, frame) = rendered(2, 500);
    for geometry in GEOMETRIES {
        let w = bin(&frame, geometry);
        let grid = TileGrid::new(150, 90, geometry.tile);
        let map = gaze_at([0.4, 0.6]).eccentricity_map([150, 90]).expect("a gaze");
        let tiles = powergs_frame::fovea::TileLevels::new(&map, grid);
        let naive = Naive { frame: &frame, w: &w, tiles };
        w.tiles.iter().enumerate().for_each(|(i, tile)| naive.check_tile(i, tile));
        for group in 0..w.groups.len() as u32 {
            let list = w.group_list(group);
            assert_eq!(w.groups[group as usize].entries, list.len() as u32, "{geometry:?}");
        }
        // Colours of all levels that splats need, each once.
        let further: u64 = w.chunks.iter().map(|c: &ChunkWork| u64::from(c.level_loads)).sum();
        let levels = w.fovea.as_ref().expect("foveated").counters.points_by_levels;
        assert_eq!(further, levels[1] + 2 * levels[2] + 3 * levels[3]);
        assert_eq!(levels.iter().sum::<u64>(), w.counters.fetched_points);
    }
}

/// Actions and DRAM bytes of the regions, and what belongs to none of them, are those of the frame.
#[test]
fn regions_add_up() {
    let (_, frame) = rendered(3, 4000);
    for sets in [&[][..], &["schedule.merge-below=300"], &["geometry.sort-group=64"]] {
        let machine = machine(sets);
        let w = bin(&frame, machine.tiles().geometry);
        let replay = replay(&w, &machine);
        let regions = replay.regions.as_ref().expect("a foveated frame");
        let mut tiles = 0;
        for stage in [Phase::Sorting, Phase::Rendering] {
            for (action, _) in hardware().actions() {
                let sum: u64 = regions.iter().map(|r| r.actions.count(stage, action)).sum();
                let all = replay.actions.count(stage, action);
                let vain = replay.speculation.count(stage, action);
                assert_eq!(sum, all - vain, "{sets:?} {stage:?} {action:?}");
            }
        }
        for region in regions {
            tiles += region.tiles;
            assert!(region.tiles > 0 && region.cycles > 0 && region.entries > 0);
        }
        assert_eq!(tiles, w.tiles.len() as u64);
    }
}

#[test]
fn accumulators_take_time_or_area() {
    let (_, frame) = rendered(4, 8000);
    let table = EnergyTable::parse(find(ENERGY, "gscore-28nm").expect("a table"));
    let table = table.expect("a table");
    let on = |sets: &[&str]| {
        let mut sets = sets.to_vec();
        // Fast memory: what the rendering units do shows.
        sets.extend(["dram.model=bandwidth", "dram.device=none", "dram.bandwidth=1 TB/s"]);
        let machine = machine(&sets);
        let prices = cost::prices(&table, &machine).expect("prices");
        let w = bin(&frame, machine.tiles().geometry);
        simulate(Label::default(), &w, &machine, &prices)
    };
    let [one, two] =
        ["fovea.accumulators=1", "fovea.accumulators=2"].map(|set| on(&[set]).expect("a frame"));
    let cycles = |r: &powergs_core::sim::FrameReport| r.timing().expect("timed").frame;
    assert!(cycles(&two) < cycles(&one), "{} {}", cycles(&two), cycles(&one));
    let vru = |r: &powergs_core::sim::FrameReport| r.area.as_ref().expect("area").units[3].0;
    assert!((vru(&two) / vru(&one) - 1.555).abs() < 1e-12);
    let energy: f64 = one.regions().expect("regions").iter().map(|r| r.energy_pj).sum();
    assert!(energy > 0.0 && energy < one.energy.dynamic().0);
    assert_eq!(one.fovea().expect("foveated").gaze, [0.4, 0.6]);
    // A machine without accumulators says what to do.
    let refused = on(&["fovea.accumulators=0"]).expect_err("a machine that cannot");
    assert!(matches!(refused, SimError::Incompatible(Incompatible::Foveated { .. })));
    assert!(refused.to_string().contains("fovea.accumulators = 1"), "{refused}");
}

/// Less is done for a foveated frame of a pruned model than for its level 1 alone.
#[test]
fn pruned_levels_save_work() {
    let parts = levels(5, 8000, 0, 0.5);
    let model = Foveated::compose(&parts).expect("nested levels");
    let camera = front_camera(150, 90);
    let options = Options::reference(Detail::Counters);
    let plain = render(&parts[0], &camera, &options).into_frame(&camera, [0.0; 3]);
    let frame = render_foveated(&model, &camera, &gaze_at([0.5, 0.5]), &options).expect("a gaze");
    let frame = frame.into_frame(&camera, [0.0; 3]);
    let machine = machine(&[]);
    let cycles = |frame: &Frame| {
        let replay = replay(&bin(frame, machine.tiles().geometry), &machine);
        (replay.timing.frame, replay.regions.is_some())
    };
    let ((fast, is_foveated), (slow, is_plain)) = (cycles(&frame), cycles(&plain));
    assert!(is_foveated && !is_plain);
    assert!(fast < slow, "{fast} {slow}");
}

#[test]
fn traces_keep_gaze_and_screen() {
    let (_, frame) = rendered(6, 300);
    let header = TraceHeader {
        generator: "test".into(),
        scene: "s".into(),
        points: frame.facts.points,
        order: StorageOrder::Storage,
    };
    let mut writer = Writer::new(Cursor::new(Vec::new()), &header).expect("memory");
    writer.write_frame(&frame).expect("a frame");
    let bytes = writer.finish().expect("memory").into_inner();
    let mut reader = Reader::open(Cursor::new(bytes)).expect("a trace");
    let again = reader.read_block(0).expect("a block").decode().expect("a frame");
    assert_eq!(again, frame);
    assert_eq!(again.fovea.expect("foveated").screen_gaze(), gaze_at([0.4, 0.6]));
}

//! What multiplies: frames of splats on random machines that keep lists, share something between
//! two eyes, render some pixels or train, against the oracle and by the way of every session.

use powergs_base::quantity::Bytes;
use powergs_core::flow::over::kept_order::KeptOrder;
use powergs_core::flow::over::pixels::SomePixels;
use powergs_core::flow::over::second_eye::{FirstView, derived, shared};
use powergs_core::flow::steps::Updated;
use powergs_core::flow::tile_wise::measures::{self, CacheKey};
use powergs_core::flow::tile_wise::{
    FeatureSource, Fetch, FoveaSpec, FrameContext, GsuImpl, Overlap, PixelSource, SamplePattern,
    StereoImpl, Termination, VruImpl,
};
use powergs_core::flow::{FrameTask, History};
use powergs_core::kernel::Memo;
use powergs_core::machine::{BufferSpec, Machine, Ports};
use powergs_core::workload::binning::ListWrites;
use powergs_core::workload::reuse::Reuse;
use powergs_core::workload::{FrameWorkload, bin_for};
use powergs_frame::scene::Eye;
use powergs_frame::splat::Intersection;
use powergs_frame::trace::Frame;
use powergs_scene::camera::edit::stereo;
use powergs_testkit::scenes::{front_camera, random_scene};
use rayon::prelude::*;

use super::support::Dice;
use super::{States, compare_on, reached, slow_or, states_of};
use crate::workload::support::rendered;

/// How many, and with `RUN_SLOW_TESTS=1`.
pub const CASES: [u64; 2] = [600, 6000];

/// Their seeds begin here.
const FIRST: u64 = 1 << 41;

/// The machine of a case.
pub fn machine(seed: u64) -> Machine {
    let mut dice = Dice::new(FIRST + seed);
    let mut machine = dice.machine();
    dice.colour(&mut machine);
    dice.memory(&mut machine);
    machine.tiles_mut().fovea = FoveaSpec::default();
    organise(&mut dice, &mut machine);
    match dice.roll(0, 11) {
        0 => {}
        1 => keep(&mut dice, &mut machine, GsuImpl::Last),
        2 => keep(&mut dice, &mut machine, GsuImpl::Shared),
        3 => keep(&mut dice, &mut machine, GsuImpl::Update),
        4 => pair(&mut dice, &mut machine, StereoImpl::Derived),
        5 => pair(&mut dice, &mut machine, StereoImpl::Shared),
        6 => pixels(&mut dice, &mut machine, PixelSource::Warped),
        7 => pixels(&mut dice, &mut machine, PixelSource::Cached),
        8 => pixels(&mut dice, &mut machine, PixelSource::Sampled),
        _ => train(&mut dice, &mut machine),
    }
    dice.cache(&mut machine);
    if dice.roll(0, 3) == 0 {
        let levels = &mut machine.tiles_mut().levels;
        (levels.gaussians, levels.children) = (dice.pick(&[1, 16, 512]), dice.pick(&[2, 8]));
        (levels.period, levels.operations) = (dice.roll(1, 3), dice.pick(&[5, 48]));
        levels.operations_per_cycle = dice.pick(&[1, 48]);
    }
    let m = machine.tiles_mut();
    m.record.position.0 = m.record.position.0.max(1);
    if m.ccu.fetch != Fetch::LazyColour && dice.roll(0, 2) > 0 {
        m.record.feature_source = FeatureSource::Ccu;
        m.record.projected = m.record.feature;
    }
    if m.stereo.implementation != StereoImpl::Shared && dice.roll(0, 2) == 0 {
        m.ccu.clusters = dice.pick(&[32, 64]);
        m.ccu.cluster = Bytes(u64::from(dice.roll(1, 40)));
    }
    if m.gsu.implementation != GsuImpl::Update && !m.gsu.keeps_lists() && dice.roll(0, 1) == 0 {
        dice.binning(&mut machine);
    }
    machine
}

/// Units of any kind.
fn organise(dice: &mut Dice, machine: &mut Machine) {
    let m = machine.tiles_mut();
    let way = dice.pick(&VruImpl::ALL);
    let vru = &mut m.vru;
    vru.implementation = way;
    m.geometry.subtile = match way {
        VruImpl::Leaders => dice.pick(&[4, 8]),
        _ if way.has_subtiles() => m.geometry.subtile,
        _ => m.geometry.tile,
    };
    let subtiles = m.geometry.subtiles();
    vru.units_per_core = match way {
        VruImpl::Parallel | VruImpl::Leaders => subtiles * dice.pick(&[1, 2]),
        VruImpl::Rows => dice.pick(&[1, 3, 8]),
        _ => dice.pick(&[4, 16, 64]),
    };
    let stops = [Termination::Subtile, Termination::Tile];
    vru.termination = match (way, way.stops()) {
        (_, Some(own)) => own,
        (VruImpl::Leaders, _) => dice.pick(&stops),
        (VruImpl::Scan, _) if vru.termination == Termination::Tile => Termination::Subtile,
        _ => vru.termination,
    };
    vru.subtile_queue = dice.pick(&[1, 2, 3, 16]);
    vru.pixel_state = Bytes(u64::from(dice.roll(1, 8)));
    vru.stop_latency = dice.pick(&[0, 0, 1, 7, 40]);
    vru.leaders_per_cycle = dice.pick(&[4, 8, 64]);
    vru.spiky_from = dice.pick(&[1, 2, 3, 65536]);
    vru.entries_per_cycle = dice.pick(&[1, 3]);
    vru.divisions_per_cycle = dice.roll(1, 8);
    // Who does not sort never stops.
    if m.gsu.implementation == GsuImpl::None {
        match way == VruImpl::Scan || dice.roll(0, 1) == 0 {
            true => m.gsu.implementation = GsuImpl::Split,
            false => vru.termination = Termination::None,
        }
    }
}

/// Lists or an order of frames before.
fn keep(dice: &mut Dice, machine: &mut Machine, way: GsuImpl) {
    sort(dice, machine);
    let m = machine.tiles_mut();
    m.gsu.implementation = way;
    (m.gsu.reuse_period, m.gsu.margin) = (dice.roll(2, 3), dice.pick(&[0, 4, 16]));
    if way != GsuImpl::Update {
        m.geometry.sort_group = m.geometry.tile;
        m.record.entry_bitmap = false;
    }
}

/// Lists are sorted, and pixels stop.
fn sort(dice: &mut Dice, machine: &mut Machine) {
    let m = machine.tiles_mut();
    if m.gsu.implementation == GsuImpl::None {
        m.gsu.implementation = dice.pick(&[GsuImpl::Split, GsuImpl::Merge]);
        m.vru.termination = m.vru.implementation.stops().unwrap_or(Termination::Subtile);
    }
}

/// Something between two eyes.
fn pair(dice: &mut Dice, machine: &mut Machine, way: StereoImpl) {
    let m = machine.tiles_mut();
    (m.stereo.implementation, m.stereo.lag) = (way, dice.roll(1, 4));
    m.ccu.fetch = Fetch::VisibleColour;
}

/// Pixels that are not rendered.
fn pixels(dice: &mut Dice, machine: &mut Machine, source: PixelSource) {
    sort(dice, machine);
    let m = machine.tiles_mut();
    m.geometry.sort_group = m.geometry.tile;
    let p = &mut m.pixels;
    p.source = source;
    p.period = dice.roll(2, 4);
    p.holes = dice.pick(&[0.0, 0.1, 0.5]);
    p.depth = Bytes(u64::from(dice.roll(1, 6)));
    (p.ids, p.ways) = (dice.roll(1, 6), dice.pick(&[1, 2, 4]));
    p.entry = Bytes(u64::from(dice.roll(1, 16)));
    p.region = dice.pick(&[16, 32, 64]);
    p.stride = dice.pick(&[1, 3, 8, 16]);
    p.pattern = dice.pick(&[SamplePattern::Grid, SamplePattern::Random, SamplePattern::Unseen]);
    p.filter = dice.roll(0, 1) == 1;
    p.per_cycle = dice.pick(&[1, 4, 64]);
    p.buffer.capacity = Bytes(64 * dice.pick(&[4, 16, 400]));
    if p.filters() {
        m.geometry.test = Intersection::Aabb;
    }
    match source {
        PixelSource::Cached if dice.roll(0, 1) == 0 => {
            let way = dice.pick(&[GsuImpl::Last, GsuImpl::Shared]);
            keep(dice, machine, way);
        }
        PixelSource::Sampled => {
            m.pixels.period = dice.pick(&[0, 0, 2]);
            if dice.roll(0, 1) == 0 {
                train(dice, machine);
            }
        }
        _ => {}
    }
}

/// Steps of training.
fn train(dice: &mut Dice, machine: &mut Machine) {
    sort(dice, machine);
    let m = machine.tiles_mut();
    if m.schedule.overlap == Overlap::Frames {
        m.schedule.overlap = Overlap::Tiles;
    }
    let buffer = |dice: &mut Dice, capacity: &[u64]| BufferSpec {
        capacity: Bytes(dice.pick(capacity)),
        word: Bytes(dice.pick(&[4, 16])),
        banks: dice.pick(&[1, 4]),
        ports: dice.pick(&[Ports::ReadOrWrite, Ports::ReadAndWrite]),
    };
    let t = &mut m.training;
    t.interval = dice.pick(&[1, 2, 8]);
    t.state = Bytes(u64::from(dice.roll(1, 30)));
    t.record = Bytes(u64::from(dice.roll(1, 40)));
    (t.loss, t.chain) = (dice.pick(&[0, 20, 450]), dice.pick(&[0, 20, 420]));
    t.update = dice.pick(&[Updated::All, Updated::Visible, Updated::None, Updated::Pose]);
    t.widths.parameter = Bytes(dice.pick(&[2, 4]));
    t.widths.gradient = Bytes(dice.pick(&[2, 4]));
    t.widths.moment = Bytes(dice.pick(&[0, 2, 4]));
    (t.step, t.densify) = (dice.roll(1, 12), dice.pick(&[0, 0, 1, 100]));
    let g = &mut m.gradients;
    g.behind = dice.roll(0, 2) > 0;
    (g.lanes, g.sum_cycles) = (dice.pick(&[1, 16, 256]), dice.pick(&[1, 4]));
    g.operations_per_cycle = dice.pick(&[16, 128, 4096]);
    (g.kept, g.pixels) = (Bytes(u64::from(dice.roll(1, 20))), dice.pick(&[1, 64, 256]));
    (g.misses, g.ways) = (dice.pick(&[1, 16]), dice.pick(&[1, 4]));
    g.buffer = buffer(dice, &[64, 1 << 10, 1 << 20]);
    g.cache = buffer(dice, &[0, 64, 1 << 10, 1 << 16]);
}

/// Frames of a camera that moves, or the views of two eyes.
fn frames(seed: u64, machine: &Machine) -> Vec<Frame> {
    let mut dice = Dice::new(2 * FIRST + seed);
    let degree = dice.pick(&[0, 1, 3]);
    let mut scene = random_scene(seed, dice.roll(20, 160) as usize, degree);
    scene.logit_opacities.iter_mut().for_each(|o| *o += 2.0);
    let camera = front_camera(dice.roll(17, 50), dice.roll(17, 40));
    let m = machine.tiles();
    if m.stereo.implementation != StereoImpl::Separate {
        let distance = dice.pick(&[0.01, 0.05]);
        return stereo(&camera, distance)
            .map(|camera| {
                let mut frame = rendered(&scene, &camera).1;
                frame.facts.camera.eye = camera.eye;
                frame
            })
            .into();
    }
    let goes_on = m.gsu.keeps_lists() || m.gsu.period() > 1 || m.pixels.source != PixelSource::All;
    let most = if goes_on { dice.pick(&[1, 2, 2, 2, 3]) } else { 1 };
    let step = dice.pick(&[0.0, 0.02, 0.1]);
    let one = |i: u32| {
        let mut camera = camera.clone();
        camera.centre.x += step * f64::from(i);
        camera.world_to_camera *= glam::DMat3::from_rotation_y(0.3 * step * f64::from(i));
        rendered(&scene, &camera).1
    };
    (0..most).map(one).collect()
}

/// What a frame takes over.
#[derive(Default)]
struct Taken {
    kept: Option<KeptOrder>,
    pixels: Option<SomePixels>,
    reuse: Option<Reuse>,
    /// The frame as the second eye of a pair has it.
    second: Option<FrameWorkload>,
    derived: bool,
}

impl Taken {
    /// By the parts of the dataflow one by one; `None` of views that are refused as a pair.
    fn of(
        machine: &Machine,
        work: &FrameWorkload,
        eye: Option<Eye>,
        history: &mut History,
    ) -> Option<Taken> {
        let m = machine.tiles();
        let mut taken = Taken::default();
        if let Some(eye) = eye {
            taken.derived = m.stereo.implementation == StereoImpl::Derived && eye == Eye::Right;
            if eye == Eye::Left {
                let blends = m.stereo.implementation == StereoImpl::Derived;
                history.keep(Some(eye), FirstView::new(work, blends));
                return Some(taken);
            }
            let first = history.take::<FirstView>(Some(Eye::Left)).expect("the left one came");
            let reach = (m.stereo.lag * m.geometry.tile) as f32;
            taken.second = Some(match taken.derived {
                true => {
                    let (made, summary) = derived(&first, work, reach).expect("a pair");
                    let most = summary.pixels as f64 / 100.0;
                    (summary.cut_off_pixels as f64 <= most).then_some(made)?
                }
                false => shared(&first, work).expect("a pair"),
            });
            return Some(taken);
        }
        let keeping = m.gsu.keeping();
        taken.kept = keeping.map(|keeping| KeptOrder::of(keeping, work, eye, history));
        let made = taken.kept.as_ref().and_then(|kept| kept.made.as_deref());
        let filter = m.pixel_filter();
        let frame = made.unwrap_or(work);
        taken.pixels = filter.map(|filter| SomePixels::of(filter, frame, eye, history, false));
        if m.gsu.period() > 1 {
            taken.reuse = measures::reuse(work, eye, m.gsu.period(), history);
        }
        Some(taken)
    }

    /// The frame that is run.
    fn made<'a>(&'a self, work: &'a FrameWorkload) -> &'a FrameWorkload {
        let pixels = self.pixels.as_ref().and_then(|pixels| pixels.made.as_deref());
        let kept = self.kept.as_ref().and_then(|kept| kept.made.as_deref());
        pixels.or(kept).or(self.second.as_ref()).unwrap_or(work)
    }
}

/// Compares the last frame (of a pair both) with the oracle; the states that came up.
fn compare(seed: u64) -> Vec<States> {
    let machine = machine(seed);
    let flow = machine.flow();
    let mut dice = Dice::new(3 * FIRST + seed);
    let (frames, m) = (frames(seed, &machine), machine.tiles());
    let (mut history, mut own) = (History::default(), History::default());
    let mut states = Vec::new();
    for (i, frame) in frames.iter().enumerate() {
        let work = bin_for(frame, m.geometry, m.detail());
        let eye = frame.facts.camera.eye;
        let before = flow.hand_over(&machine, &work, eye, &mut history);
        let Some(taken) = Taken::of(&machine, &work, eye, &mut own) else { break };
        if i + 1 < frames.len() && eye.is_none() {
            continue;
        }
        let made = taken.made(&work);
        let lists = m.list_shape().filter(|_| !taken.derived);
        let lists = lists.map(|shape| ListWrites::new(made, shape));
        let hits: Option<Vec<u32>> = match taken.derived {
            // Features of a derived eye come on chip.
            true => Some(made.chunks.iter().map(|chunk| chunk.entries).collect()),
            false => CacheKey::of(&machine).map(|key| key.replay(made).hits),
        };
        let given = FrameContext {
            hits: hits.as_deref(),
            reuse: taken.reuse.as_ref().map(|reuse| reuse.lists.as_slice()),
            table: taken.kept.as_ref().map(|kept| &kept.lists),
            pixels: taken.pixels.as_ref(),
            lists: lists.as_ref(),
            derived: taken.derived,
            ..FrameContext::default()
        };
        let other = dice.another(&machine);
        let replay = compare_on(made, &machine, &other, given, seed);
        let memo = Memo::default();
        let task =
            FrameTask { before: before.as_ref(), ..FrameTask::first(&machine, &work, &memo) };
        let outcome = flow.run(&task, None).expect("it runs");
        assert_eq!(outcome.timing, replay.timing, "seed {seed}");
        assert_eq!(outcome.served, replay.served, "seed {seed}");
        states.push(states_of(&replay));
    }
    states
}

#[test]
fn modes_of_real_frames_are_those_of_the_oracle() {
    let all = (0..slow_or(CASES)).into_par_iter().flat_map_iter(compare);
    let all: Vec<States> = all.collect();
    let expected = ["0rob.", "0lsiob.", "0lsiob.", "0lsfciob.", "0fo.", "0fio.", "0lsfi.", "0r."];
    assert_eq!(reached(&all), expected);
}

/// No machine of these is one that its check would refuse for what it combines.
#[test]
fn modes_that_are_run_do_not_contradict_each_other() {
    for seed in 0..CASES[0] {
        let machine = machine(seed);
        let found = machine.contradictions();
        let found = found.iter().map(|problem| format!("{problem:?}"));
        let found: Vec<String> = found.filter(|text| text.contains("contradict")).collect();
        assert!(found.is_empty(), "seed {seed}: {found:#?}");
    }
}

//! A small workload that reaches everything: lists of several chunks, tiles that end early, frames
//! that turn a little.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, LazyLock, Mutex};

use powergs_core::flow::tile_wise::{FoveaSpec, StereoImpl, StereoSpec};
use powergs_core::flow::{FrameTask, Handed, History, TakesOver, Work, WorkKey};
use powergs_core::kernel::Memo;
use powergs_core::machine::Machine;
use powergs_core::sim::{self, FrameReport, Label, SimError, Timed, priced, time};
use powergs_core::stage::EnergyTable;
use powergs_energy::Prices;
use powergs_frame::fovea::{Screen, ScreenGaze};
use powergs_frame::trace::Frame;
use powergs_raster::{Detail, Options, render, render_foveated};
use powergs_scene::foveated::LevelPaint;
use powergs_scene::{Eye, Foveated, Gaussians, ShDegree};
use powergs_testkit::scenes::{front_camera, random_scene};

/// Frames, so that an order can be updated.
const FRAMES: usize = 2;

fn frames() -> &'static [Frame] {
    static ALL: LazyLock<Vec<Frame>> = LazyLock::new(|| {
        let mut scene = random_scene(5, 10_000, 0);
        // Much in one place, so that lists differ.
        for i in (0..scene.means.len()).step_by(3) {
            scene.means[i] =
                [scene.means[i][0] * 0.08, scene.means[i][1] * 0.08, scene.means[i][2]];
            scene.log_scales[i] = scene.log_scales[i].map(|s| s - 2.5);
        }
        // Light comes through in one corner of the second.
        let mut holed = scene.clone();
        for i in 0..scene.means.len() {
            let ([x, y, z], sizes) = (scene.means[i], scene.log_scales[i]);
            let reach = 3.0 * sizes.iter().fold(0.0f32, |most, size| most.max(size.exp()));
            if x + reach > 0.5 * z && y + reach > 0.32 * z {
                holed.logit_opacities[i] = -6.0;
            }
        }
        let one = |i: usize| {
            let mut camera = front_camera(136, 96);
            camera.centre.x += 0.01 * i as f64;
            let scene = if i == 1 { &holed } else { &scene };
            let rendered = render(scene, &camera, &Options::reference(Detail::Counters));
            let mut frame = rendered.into_frame(&camera, [0.0; 3]);
            // Colours of several degrees, so that every part of their records counts.
            frame.facts.sh_degree = ShDegree::new(3 - 2 * i as u8);
            frame
        };
        (0..FRAMES).map(one).chain([foveated(&scene)]).collect()
    });
    &ALL
}

/// The same scene with four levels, seen by an eye whose levels all fit a small image.
fn foveated(scene: &Gaussians) -> Frame {
    let paint = |i: usize| LevelPaint {
        dc: [scene.sh[3 * i], scene.sh[3 * i + 1] + 0.1, scene.sh[3 * i + 2]],
        logit_opacity: scene.logit_opacities[i] + 0.2,
    };
    let model = Foveated {
        base: scene.clone(),
        highest: (0..scene.len()).map(|i| (i * 7 % 4) as u8).collect(),
        paints: (0..scene.len()).map(|i| [paint(i); 3]).collect(),
    };
    let screen = Screen { pooling_rate: 0.4, ..Screen::PUBLISHED };
    let gaze = ScreenGaze { point: [0.4, 0.5], screen };
    let (camera, options) = (front_camera(136, 96), Options::reference(Detail::Counters));
    let rendered = render_foveated(&model, &camera, &gaze, &options).expect("a gaze");
    let mut frame = rendered.into_frame(&camera, [0.0; 3]);
    frame.facts.sh_degree = None;
    frame
}

type Shared<K, V> = LazyLock<Mutex<HashMap<K, Arc<V>>>>;

fn cached<K: std::hash::Hash + Eq, V>(
    cache: &Shared<K, V>,
    key: K,
    make: impl FnOnce() -> V,
) -> Arc<V> {
    if let Some(known) = cache.lock().expect("no panic").get(&key) {
        return known.clone();
    }
    let made = Arc::new(make());
    cache.lock().expect("no panic").insert(key, made.clone());
    made
}

/// The frames as a machine needs them.
fn works(machine: &Machine) -> Arc<Vec<Box<dyn Work>>> {
    static ALL: Shared<WorkKey, Vec<Box<dyn Work>>> = LazyLock::new(Default::default);
    let key = machine.flow().work_key(machine);
    cached(&ALL, key.clone(), || frames().iter().map(|frame| key.prepare(frame)).collect())
}

/// What a machine takes over into each frame.
fn handed(machine: &Machine) -> Arc<Vec<Option<Handed>>> {
    static ALL: Shared<TakesOver, Vec<Option<Handed>>> = LazyLock::new(Default::default);
    let flow = machine.flow();
    let Some(key) = TakesOver::of(machine) else {
        return Arc::new(works(machine).iter().map(|_| None).collect());
    };
    cached(&ALL, key, || {
        let mut history = History::default();
        let all = works(machine);
        // The second view is to the right of the first one.
        let is_pair = machine
            .tables
            .get::<StereoSpec>()
            .is_some_and(|s| s.implementation != StereoImpl::Separate);
        let eyes = Eye::ALL.into_iter().map(|eye| Some(eye).filter(|_| is_pair));
        let eyes = eyes.chain(std::iter::repeat(None));
        let mut hand = |w: &dyn Work, eye| flow.hand_over(machine, w, eye, &mut history);
        all.iter().zip(eyes).map(|(w, eye)| hand(&**w, eye)).collect()
    })
}

/// Everything that comes out of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    pub frames: Vec<FrameReport>,
    pub prices: Prices,
    peak_w: Vec<(&'static str, f64)>,
}

/// Takes the frames through a machine.
pub fn outcome(machine: &Machine) -> Result<Outcome, String> {
    static MEMOS: Shared<WorkKey, Vec<Memo>> = LazyLock::new(Default::default);
    let table = table(&machine.energy).ok_or("no such energy table")?;
    let prices = sim::cost::prices(&table, machine).map_err(|e| e.to_string())?;
    let memos = || (0..=FRAMES).map(|_| Memo::default()).collect();
    let memos = cached(&MEMOS, machine.flow().work_key(machine), memos);
    let timed = timed(machine, &memos, true);
    let report = |timed: Result<Timed, SimError>| match timed {
        Err(SimError::Incompatible(refused)) => Err(refused.to_string()),
        timed => {
            let timed = timed.expect("accounts close");
            Ok(priced(Label::default(), &timed, &prices).expect("accounts close"))
        }
    };
    let frames = timed.into_iter().map(report).collect::<Result<_, String>>()?;
    let peak_w = sim::cost::peak_w(machine, &prices);
    Ok(Outcome { frames, prices, peak_w })
}

/// The frames on a machine, with a memo each.
fn timed(machine: &Machine, memos: &[Memo], checks_order: bool) -> Vec<Result<Timed, SimError>> {
    let (works, handed) = (works(machine), handed(machine));
    // Machines without accumulators for levels see plain frames only, and so do those that train.
    let shows_levels = machine.tables.get::<FoveaSpec>().is_some_and(|f| f.accumulators > 0)
        && machine.flow().task(machine).is_shown();
    let frames = (0..).zip(works.iter()).take(if shows_levels { FRAMES + 1 } else { FRAMES });
    let task = |(frame, work): (usize, _)| FrameTask {
        frame,
        before: handed[frame].as_ref(),
        checks_order,
        ..FrameTask::first(machine, work, &memos[frame])
    };
    frames.map(|(frame, work)| time(&task((frame, &**work)))).collect()
}

/// Takes the frames through a machine alone, and again with what other machines left in `memos`
/// (one a frame of its work): the two results, without accounts of energy.
pub fn alone_and_shared(
    machine: &Machine,
    memos: &mut BTreeMap<WorkKey, Vec<Memo>>,
) -> [Vec<Result<Timed, String>>; 2] {
    let memos = memos.entry(machine.flow().work_key(machine)).or_default();
    memos.resize_with(FRAMES + 1, Memo::default);
    let own: Vec<Memo> = memos.iter().map(|_| Memo::default()).collect();
    [&own, memos].map(|memos| {
        let all = timed(machine, memos, false).into_iter();
        all.map(|timed| timed.map_err(|e| e.to_string())).collect()
    })
}

/// An energy table that comes with the program.
pub fn table(name: &str) -> Option<EnergyTable> {
    static ALL: LazyLock<BTreeMap<&str, EnergyTable>> = LazyLock::new(|| {
        let parse = |text| EnergyTable::parse(text).expect("a table that comes with the program");
        let files = powergs_base::config::embedded::ENERGY.iter();
        files.map(|file| (file.name, parse(file.text))).collect()
    });
    ALL.get(name).cloned()
}

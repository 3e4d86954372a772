//! A small workload that reaches everything: lists of several chunks, tiles that end early, frames
//! that turn a little.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, LazyLock, Mutex};

use powergs_core::flow::tile_wise::Memo;
use powergs_core::machine::Machine;
use powergs_core::sim::{
    self, FrameReport, Label, Lists, Measured, SimError, Timed, simulate_measured, time, time_again,
};
use powergs_core::stage::EnergyTable;
use powergs_core::workload::{FrameWorkload, Geometry, bin};
use powergs_energy::Prices;
use powergs_frame::fovea::{Screen, ScreenGaze};
use powergs_frame::trace::Frame;
use powergs_raster::{Detail, Options, render, render_foveated};
use powergs_scene::foveated::LevelPaint;
use powergs_scene::{Foveated, Gaussians, ShDegree};
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
        let one = |i: usize| {
            let mut camera = front_camera(136, 96);
            camera.centre.x += 0.01 * i as f64;
            let rendered = render(&scene, &camera, &Options::reference(Detail::Counters));
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

/// The frames under a geometry.
pub fn workloads(geometry: Geometry) -> Arc<Vec<FrameWorkload>> {
    static ALL: Shared<Geometry, Vec<FrameWorkload>> = LazyLock::new(Default::default);
    cached(&ALL, geometry, || frames().iter().map(|f| bin(f, geometry)).collect())
}

/// What is measured of the frames once for all machines that have the same of everything that it
/// depends on.
fn measured(machine: &Machine) -> Arc<Vec<Measured>> {
    static ALL: Shared<String, Vec<Measured>> = LazyLock::new(Default::default);
    let (gsu, cache) = (&machine.tiles().gsu, &machine.tiles().cache);
    let key = format!(
        "{:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?}",
        machine.tiles().geometry,
        cache.capacity,
        cache.ways,
        cache.eviction,
        cache.distance_bits,
        machine.tiles().record.feature_pitch,
        machine.tiles().schedule.order,
        gsu.depth,
        gsu.pivots,
        gsu.pivot_rule,
        gsu.reuse_period,
    );
    cached(&ALL, key, || {
        let mut lists = Lists::default();
        let all = workloads(machine.tiles().geometry);
        all.iter().map(|w| Measured::of(w, None, machine, &mut lists, true)).collect()
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
    let table = table(&machine.energy).ok_or("no such energy table")?;
    let prices = sim::cost::prices(&table, machine).map_err(|e| e.to_string())?;
    let (workloads, measured) = (workloads(machine.tiles().geometry), measured(machine));
    let one = |(w, m): (&FrameWorkload, &Measured)| match simulate_measured(
        Label::default(),
        w,
        m,
        machine,
        &prices,
    ) {
        Err(SimError::Incompatible(refused)) => Err(refused.to_string()),
        report => Ok(report.expect("accounts close")),
    };
    // Machines without accumulators for levels see plain frames only.
    let can = |w: &FrameWorkload| w.fovea.is_none() || machine.tiles().fovea.accumulators > 0;
    let all = workloads.iter().zip(measured.iter());
    let frames = all.filter(|(w, _)| can(w)).map(one).collect::<Result<_, String>>()?;
    let peak_w = sim::cost::peak_w(machine, &prices);
    Ok(Outcome { frames, prices, peak_w })
}

/// Takes the frames through a machine alone, and again with what other machines left in `memos`
/// (one a frame of its geometry): the two results, without accounts of energy.
pub fn alone_and_shared(
    machine: &Machine,
    memos: &mut BTreeMap<Geometry, Vec<Memo>>,
) -> [Vec<Result<Timed, String>>; 2] {
    let (workloads, measured) = (workloads(machine.tiles().geometry), measured(machine));
    let memos = memos.entry(machine.tiles().geometry).or_default();
    memos.resize_with(workloads.len(), Memo::default);
    let can = |w: &FrameWorkload| w.fovea.is_none() || machine.tiles().fovea.accumulators > 0;
    let frames = || workloads.iter().zip(measured.iter()).enumerate().filter(|(_, (w, _))| can(w));
    let alone = frames().map(|(i, (w, m))| time(i, w, m, machine).map_err(|e| e.to_string()));
    let shared = frames()
        .map(|(i, (w, m))| time_again(i, w, m, machine, &memos[i]).map_err(|e| e.to_string()));
    [alone.collect(), shared.collect()]
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

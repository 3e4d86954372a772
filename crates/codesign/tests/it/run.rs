//! Whole runs on a tiny scene: from nothing, resumed, and where nothing is to be found.

use std::sync::atomic::{AtomicU32, Ordering};

use powergs_base::budget::Budget;
use powergs_codesign::compare::Way;
use powergs_codesign::export::smallest;
use powergs_codesign::halving::{Trial, better};
use powergs_codesign::machines::Machines;
use powergs_codesign::model::ModelPoint;
use powergs_codesign::pricing::Fate;
use powergs_codesign::space::SpaceFile;
use powergs_codesign::watch::CodesignWatch;
use powergs_codesign::{Codesign, CodesignError, Finished};
use powergs_core::run::{MemoryStore, Watch};
use powergs_optimize::campaign::Campaign;
use powergs_optimize::oracle::CycleOracle;
use powergs_optimize::request::{Goal, Goals, Request};
use powergs_optimize::settings::Settings;
use powergs_scene::camera::edit::resized;
use powergs_scene::synth::{Preset, cameras, generate};
use powergs_study::sweep::run::SweepWatch;

const SPACE: &str = "\
[model]
rho = [0.0, 0.4]
sh-degree = [3, 1]

[[model.formats]]
name = \"mixed\"
scale = \"e5m8\"
rotation = \"e4m8\"
colour-dc = \"e4m7\"
colour-rest = \"e4m5\"

[machine]
[machine.set]
clock = \"500 MHz\"

[[machine.axes]]
key = \"vru.cores\"
values = [1, 2, 4]

[[machine.axes]]
key = \"dram.channels\"
values = [4, 8]

[machine.derived]
\"buffers.sorting.capacity\" = \"16 KiB * vru.cores\"
";

fn campaign(space: &SpaceFile, text: &str, psnr_db: f64, views: usize) -> Campaign {
    let preset = Preset::named("demo").unwrap();
    let dense = generate(preset, 400, 3);
    let cameras = cameras(preset).into_iter().step_by(6).take(views);
    let cameras = cameras.map(|c| resized(&c, 48, 36)).collect();
    let machines = Machines::open(&space.machine, text, "space").unwrap();
    let display = machines.base.display().unwrap().clone();
    let (system, fps) = (machines.base.clone(), machines.fps());
    let oracle = CycleOracle { system, fps, memory: Budget::DEFAULT };
    let settings = Settings {
        iterations: 24,
        final_iterations: 24,
        interval: 4,
        checkpoint_every: 5,
        ..Settings::DEFAULT
    };
    let goals = Goals { goal: Some(Goal::Absolute { psnr_db, ssim: 0.0 }), ..Goals::default() };
    let request = Request::new("tiny", dense, cameras, oracle, display);
    Campaign::open(Request { settings, goals, ..request }, &()).unwrap()
}

fn codesign(text: &str, psnr_db: f64, views: usize) -> Result<Codesign, CodesignError> {
    let space = SpaceFile::parse(text).unwrap();
    let campaign = campaign(&space, text, psnr_db, views);
    Codesign::open(campaign, space, text, "space")
}

fn finished(codesign: &Codesign, store: &MemoryStore) -> Finished {
    codesign.run(store, &()).unwrap().expect("not cancelled")
}

/// Stops after so many questions.
struct Impatient(AtomicU32);

impl Watch for Impatient {
    fn is_cancelled(&self) -> bool {
        let left = self.0.load(Ordering::Relaxed);
        self.0.store(left.saturating_sub(1), Ordering::Relaxed);
        left == 0
    }
}

impl SweepWatch for Impatient {}
impl CodesignWatch for Impatient {}

#[test]
fn a_run_prices_every_pair_and_goes_on_to_the_same_result_from_anywhere() {
    let codesign = codesign(SPACE, 24.0, 12).unwrap();
    let whole = finished(&codesign, &MemoryStore::new());
    assert_eq!(whole.models.len(), 5);
    for (model, row) in whole.models.iter().zip(&whole.rows) {
        assert!(model.point.is_dense || model.facts.passed, "{model:?}");
        assert_eq!(row.pairs.len(), 7, "six machines and the base machine");
        assert!(row.pairs.values().all(|fate| matches!(fate, Fate::Priced(_))));
    }
    let joint = whole.of(Way::Joint).and_then(|c| c.watts()).expect("a pair");
    for other in &whole.comparisons {
        assert!(other.watts().is_none_or(|watts| joint <= watts));
    }
    assert!(whole.gain_w().is_some_and(|gain| gain >= 0.0));
    // What a pruned model with a short record reads is less.
    let traffic = |model: usize| whole.price((model, None)).unwrap().dram_bytes;
    let least = (1..5).map(traffic).fold(f64::INFINITY, f64::min);
    assert!(least < 0.8 * traffic(0), "{least} {}", traffic(0));
    // Stopped at many moments, in fine-tunes and in sweeps.
    let store = MemoryStore::new();
    let mut stops = 0;
    let again = loop {
        let patience = Impatient(AtomicU32::new(5 + 3 * stops));
        match codesign.run(&store, &patience).unwrap() {
            Some(again) => break again,
            None => stops += 1,
        }
        assert!(stops < 200);
    };
    assert!(stops >= 10, "{stops}");
    assert_eq!(again.models, whole.models);
    assert_eq!(again.rows, whole.rows);
    assert_eq!(again.comparisons, whole.comparisons);
    assert_eq!(again.alternatives, whole.alternatives);
    for (a, b) in whole.models.iter().zip(&again.models).skip(1) {
        let scene = codesign.scene(&store, a).unwrap();
        assert_eq!(scene.len(), b.facts.points);
        // What is kept is what a machine reads.
        let near = a.point.formats.read(&scene);
        let far = |a: &f32, b: &f32| (a - b).abs() > 1e-4 * a.abs().max(1.0);
        assert!(!scene.sh.iter().zip(&near.sh).any(|(a, b)| far(a, b)));
    }
    // A space with more machines trains nothing again.
    let wider = SPACE.replace("[4, 8]", "[2, 4, 8]");
    let wider = self::codesign(&wider, 24.0, 12).unwrap();
    let more = finished(&wider, &store);
    assert_eq!(more.models, whole.models);
    assert_eq!(more.rows[0].pairs.len(), 10);
    // The machine of the pair has the record of the model.
    let toml = codesign.machine_toml(&codesign.models[1], Some(0)).unwrap();
    // 3 x 12 and 45 x 10 bits.
    assert!(toml.contains("colour = \"61 B\""), "{toml}");
    // So has that of a model which is not in the space, as alternation makes them.
    let other = ModelPoint { rho: 0.123, ..codesign.models[1].clone() };
    assert_eq!(codesign.machine_toml(&other, Some(0)).unwrap(), toml);
}

#[test]
fn a_quality_that_no_model_reaches_is_told_with_the_best() {
    let codesign = codesign(SPACE, 70.0, 12).unwrap();
    let error = codesign.run(&MemoryStore::new(), &()).expect_err("out of reach");
    let CodesignError::OutOfReach(message) = &error else { panic!("{error}") };
    assert!(message.contains("no model of space reaches the quality"), "{message}");
    assert!(message.contains("-mixed with ") && message.contains("short"), "{message}");
}

#[test]
fn a_budget_that_no_pair_keeps_is_told_with_the_limit_and_the_nearest_miss() {
    let text = format!("{SPACE}\n[budget]\narea = \"0.5 mm2\"\n");
    let codesign = codesign(&text, 24.0, 12).unwrap();
    let error = codesign.run(&MemoryStore::new(), &()).expect_err("too small");
    let CodesignError::Infeasible(message) = &error else { panic!("{error}") };
    assert!(message.contains("are larger than 0.5000 mm2"), "{message}");
    assert!(message.contains("the nearest miss is"), "{message}");
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_trained() {
    let one = codesign(SPACE, 24.0, 1).err().expect("one view");
    assert!(matches!(one, CodesignError::TooFewViews { views: 1 }), "{one}");
    let wide = SPACE.replace("colour-rest = \"e4m5\"", "colour-rest = \"e8m7\"");
    let contradiction = codesign(&wide, 24.0, 12).err().expect("a contradiction");
    assert!(contradiction.to_string().contains("cannot hold every e8m7"), "{contradiction}");
}

fn watts(finished: &Finished, way: Way) -> f64 {
    finished.of(way).and_then(|c| c.watts()).expect("a pair")
}

#[test]
fn an_adaptive_search_compares_all_models_on_the_machines_that_are_best_for_one() {
    let search = "[machine.sampling]\nmethod = \"nsga2\"\npopulation = 4\ngenerations = 6\n";
    let adaptive = codesign(&format!("{SPACE}\n{search}"), 24.0, 12).unwrap();
    let store = MemoryStore::new();
    let found = finished(&adaptive, &store);
    let machines: Vec<_> = found.rows[0].pairs.keys().collect();
    assert!(machines.contains(&&None), "the base machine is among them");
    for row in &found.rows {
        assert_eq!(row.pairs.keys().collect::<Vec<_>>(), machines);
        assert!(row.pairs.values().all(|fate| matches!(fate, Fate::Priced(_))));
    }
    // Of six machines it looks at all, and finds what is found on the grid.
    let whole = finished(&codesign(SPACE, 24.0, 12).unwrap(), &store);
    assert_eq!(found.models, whole.models);
    for way in [Way::Dense, Way::Base, Way::Joint] {
        assert_eq!(watts(&found, way), watts(&whole, way), "{way:?}");
    }
    assert_eq!(finished(&adaptive, &store).rows, found.rows, "from the store");
}

#[test]
fn an_adaptive_search_chooses_banks_for_a_codebook_as_a_grid_does() {
    let text = SPACE.replace("sh-degree = [3, 1]", "sh-degree = [3]\ncodebook = [0, 65536]");
    let search = "[machine.sampling]\nmethod = \"nsga2\"\npopulation = 4\ngenerations = 6\n";
    let store = MemoryStore::new();
    let found = finished(&codesign(&format!("{text}\n{search}"), 24.0, 12).unwrap(), &store);
    let whole = finished(&codesign(&text, 24.0, 12).unwrap(), &store);
    for (row, all) in found.rows.iter().zip(&whole.rows) {
        assert!(row.pairs.values().all(|fate| matches!(fate, Fate::Priced(_))), "{row:?}");
        assert!(row.pairs.len() > 4 && row.pairs.len() <= all.pairs.len());
    }
    for way in [Way::Dense, Way::Base, Way::Joint] {
        assert_eq!(watts(&found, way), watts(&whole, way), "{way:?}");
    }
}

#[test]
fn a_budget_that_no_pair_keeps_names_the_right_model_after_halving() {
    let store = MemoryStore::new();
    let whole = finished(&codesign(SPACE, 24.0, 12).unwrap(), &store);
    let text = format!("{SPACE}\n[budget]\narea = \"0.5 mm2\"\n");
    let mut halved = codesign(&text, 24.0, 12).unwrap();
    halved.halving = true;
    let error = halved.run(&store, &()).expect_err("too small");
    let CodesignError::Infeasible(message) = &error else { panic!("{error}") };
    let nearest = message.split("the nearest miss is ").nth(1).expect("a nearest miss");
    let name = nearest.split(' ').next().unwrap();
    let model = whole.models.iter().position(|model| model.point.name() == name).unwrap();
    let machine = nearest.split("machine #").nth(1).and_then(|m| m.split(' ').next()?.parse().ok());
    let price = whole.price((model, machine)).expect("it was priced");
    let shown = nearest.split(" mm2, ").nth(1).and_then(|ms| ms.split(' ').next()).unwrap();
    let frame_ms: f64 = shown.parse().unwrap();
    assert!((price.frame_ms / frame_ms - 1.0).abs() < 0.01, "{message}: {price:?}");
}

#[test]
fn halving_trains_the_better_half_in_full() {
    let store = MemoryStore::new();
    let whole = finished(&codesign(SPACE, 24.0, 12).unwrap(), &store);
    let mut halved = codesign(SPACE, 24.0, 12).unwrap();
    halved.halving = true;
    let found = finished(&halved, &store);
    let left: Vec<String> = found.left.iter().map(|(point, _)| point.name()).collect();
    assert_eq!((found.models.len(), left.len()), (3, 2), "{left:?}");
    assert!(found.left.iter().all(|(_, iterations)| *iterations == 3), "an eighth of 24");
    for model in &found.models {
        assert!(whole.models.contains(model) && !left.contains(&model.point.name()));
    }
    let (all, few) = (watts(&whole, Way::Joint), watts(&found, Way::Joint));
    assert!(all <= few && few <= 1.1 * all, "{few} W, {all} W with all models");
    assert_eq!(finished(&halved, &store).comparisons, found.comparisons, "from the store");
}

#[test]
fn what_stays_is_beaten_by_the_fewest_in_watts_and_quality() {
    let trial = |watts: f64, margin_db: f64| Trial { watts, margin_db };
    let dim_but_bad = trial(1.0, -3.0);
    let good_but_dear = trial(3.0, 0.0);
    let between = trial(2.0, -1.0);
    let beaten = trial(2.5, -2.0);
    let trials = [beaten, good_but_dear, dim_but_bad, between];
    assert_eq!(better(&trials, 3), [false, true, true, true]);
    assert_eq!(better(&trials, 1), [false, true, false, false], "the nearest to the quality");
    assert_eq!(better(&trials, 2), [false, true, true, false], "then the fewest watts");
    assert_eq!(better(&[between; 3], 2), [true, true, false], "then the first");
    let cheap = trial(2.0, 0.0);
    assert_eq!(better(&[good_but_dear, cheap], 1), [false, true], "of as good ones the cheaper");
    let refused = trial(f64::INFINITY, 0.0);
    assert_eq!(better(&[refused, good_but_dear], 1), [false, true]);
}

#[test]
fn a_codebook_spares_traffic_and_takes_area() {
    let text = SPACE.replace("sh-degree = [3, 1]", "sh-degree = [3]\ncodebook = [0, 32]");
    let found = finished(&codesign(&text, 24.0, 12).unwrap(), &MemoryStore::new());
    let names: Vec<String> = found.models.iter().map(|m| m.point.name()).collect();
    let wanted = [
        "dense",
        "rho0-sh3-mixed",
        "rho0-sh3-mixed-cb32",
        "rho0.4-sh3-mixed",
        "rho0.4-sh3-mixed-cb32",
    ];
    assert_eq!(names, wanted);
    for pair in [[1, 2], [3, 4]] {
        let [own, shared] = pair.map(|model| found.price((model, Some(0))).expect("a price"));
        assert!(shared.dram_bytes < 0.9 * own.dram_bytes, "{shared:?} {own:?}");
        assert!(shared.area_mm2 > own.area_mm2, "{shared:?} {own:?}");
    }
}

#[test]
fn a_codebook_that_no_table_prices_is_refused_before_anything_is_trained() {
    let space = |entries: u32, more: &str| {
        let model = format!("rho = [0.0, 0.4]\ncodebook = [{entries}]");
        let machine = format!("[machine.set]\n{more}");
        SPACE.replace("rho = [0.0, 0.4]", &model).replace("[machine.set]\n", &machine)
    };
    let opened = |entries, more| codesign(&space(entries, more), 24.0, 12).map(drop);
    // A copy of 6 MiB at degree 3 is 96 banks of 64 KiB, rounded up to a power of two.
    opened(65_536, "").unwrap();
    let one = "\"codebook.banks\" = 1\n";
    let by_default = codesign(&space(65_536, one), 24.0, 12).unwrap();
    let table = &by_default.machines.left_out[0].0;
    let energy = format!("\n[[machine.energy]]\nlabel = \"rtl\"\ntable = \"{table}\"\n");
    let named = space(65_536, one) + &energy;
    let whole = codesign(&named, 24.0, 12).map(drop).unwrap_err().to_string();
    assert!(whole.contains("`banks` or `word` of `codebook`"), "{whole}");
    assert!(whole.contains("model rho0-sh3-mixed-cb65536"), "{whole}");
}

#[test]
fn the_joint_model_is_written_in_compressed_formats_and_looked_at() {
    let found = finished(&codesign(SPACE, 24.0, 12).unwrap(), &MemoryStore::new());
    assert_eq!(found.exports.len(), 3);
    for export in &found.exports {
        let bytes = export.bytes().expect("a file");
        // A model of 400 Gaussians of degree 3 at most: 94 kB of raw parameters.
        assert!(bytes < 94_000 && export.gate.is_some(), "{:?}: {bytes} B", export.target);
        assert_eq!(export.passed, export.gate.is_some_and(|g| g.quality.psnr_db >= 24.0));
    }
    let best = smallest(&found.exports).expect("24 dB are not much");
    assert!(found.exports.iter().all(|e| !e.passed || e.bytes() >= best.bytes()));
}

#[test]
fn axes_of_a_codebook_count_for_models_that_have_one() {
    let axis = "[[machine.axes]]\nkey = \"codebook.banks\"\nvalues = [1, 2]\n";
    let text = SPACE.replace("sh-degree = [3, 1]", "sh-degree = [3]\ncodebook = [0, 32]");
    let text = text.replace("[machine.derived]", &format!("{axis}\n[machine.derived]"));
    let found = finished(&codesign(&text, 24.0, 12).unwrap(), &MemoryStore::new());
    let axes: Vec<&str> = found.rows[0].axes().into_iter().map(|(_, name)| name).collect();
    assert_eq!(axes, ["vru.cores", "dram.channels", "codebook.banks"]);
    for (model, row) in found.models.iter().zip(&found.rows) {
        let has_codebook = model.point.formats.codebook.is_some();
        let banks = |(machine, settings): (&Option<u64>, &Vec<String>)| {
            machine.map(|_| settings[2].clone())
        };
        let mut banks: Vec<String> = row.settings.iter().filter_map(banks).collect();
        // The base machine and six others, or twelve.
        assert_eq!(row.pairs.len(), if has_codebook { 13 } else { 7 }, "{}", model.point.name());
        banks.sort_unstable();
        banks.dedup();
        let wanted: &[&str] = if has_codebook { &["1", "2"] } else { &[""] };
        assert_eq!(banks, wanted, "{}", model.point.name());
    }
    // A machine of both has one number.
    let dense = &found.rows[0];
    let with = found.models.iter().position(|m| m.point.formats.codebook.is_some()).unwrap();
    for machine in dense.settings.keys().filter(|machine| machine.is_some()) {
        let [own, other] = [dense, &found.rows[with]].map(|row| &row.settings[machine][..2]);
        assert_eq!(own, other, "{machine:?}");
    }
    assert!(found.of(Way::MachineFirst).unwrap().found.is_ok());

    // Where no model has a codebook, the axis is a mistake.
    let none = text.replace("\ncodebook = [0, 32]", "");
    let error = codesign(&none, 24.0, 12).map(drop).unwrap_err().to_string();
    assert!(error.contains("`codebook.banks` changes nothing"), "{error}");
}

#[test]
fn a_table_that_nobody_asked_for_refuses_nothing() {
    // Entries of 8 colours are 720 B: no table of `rtl/` has so small a bank.
    let text = SPACE.replace("sh-degree = [3, 1]", "sh-degree = [3]\ncodebook = [8]");
    let small = codesign(&text, 24.0, 12).unwrap();
    let [(label, why)] = &small.machines.left_out[..] else {
        panic!("{:?}", small.machines.left_out)
    };
    assert!(label.starts_with("gscore-rtl-") && why.contains("B"), "{label}: {why}");
    assert!(codesign(SPACE, 24.0, 12).unwrap().machines.left_out.is_empty());
    // Where it is asked for, it says so.
    let named = format!("{text}\n[[machine.energy]]\nlabel = \"rtl\"\ntable = \"{label}\"\n");
    assert!(codesign(&named, 24.0, 12).is_err());
}

#[test]
fn more_machines_than_anybody_prices_are_refused() {
    let axes: String = ["buffers.feature.capacity", "buffers.tile-list.capacity"]
        .iter()
        .map(|key| {
            let range = "range = { from = \"1 KiB\", to = \"4000 KiB\", step = \"1 KiB\" }";
            format!("[[machine.axes]]\nkey = \"{key}\"\n{range}\n\n")
        })
        .collect();
    let text = SPACE.replace("[machine.derived]", &format!("{axes}[machine.derived]"));
    let error = codesign(&text, 24.0, 12).map(drop).unwrap_err().to_string();
    assert!(error.contains("96000001 machines") && error.contains("sampling"), "{error}");
    let some = format!("{text}\n[machine.sampling]\nmethod = \"lhs\"\npoints = 20\n");
    assert_eq!(codesign(&some, 24.0, 12).unwrap().machines_most().unwrap(), 21);
}

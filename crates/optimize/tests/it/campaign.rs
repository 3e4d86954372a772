//! Whole campaigns in memory: cancelled, resumed, refused.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicU32, Ordering};

use powergs_base::budget::Budget;
use powergs_core::run::{MemoryStore, Store, Watch};
use powergs_core::run::{RunError, System};
use powergs_frame::fovea::Screen;
use powergs_optimize::campaign::{Campaign, CampaignError, Finished};
use powergs_optimize::checkpoint::Checkpoints;
use powergs_optimize::invalid::Invalid;
use powergs_optimize::job::Place;
use powergs_optimize::lambda::LambdaRule;
use powergs_optimize::oracle::{CycleOracle, PaperOracle};
use powergs_optimize::outcome::Outcome;
use powergs_optimize::references::ReferenceImages;
use powergs_optimize::request::{Foveation, Goal, Goals, Request};
use powergs_optimize::role::{Baseline, Role};
use powergs_optimize::schedule::Schedule;
use powergs_optimize::settings::{Dimming, Kind, Mark, SETTINGS, Setting, Settings, Value};
use powergs_optimize::target::{Level, Quality, Target};
use powergs_optimize::tune::{Iteration, Trains};
use powergs_optimize::views::PowerViews;
use powergs_optimize::watch::CampaignWatch;

use super::scenes::tiny;

/// A short campaign.
pub fn request() -> Request {
    let tiny = tiny(200, 3, (48, 36));
    let settings = Settings {
        iterations: 5,
        first_effort: 1.0,
        held_out_iterations: 10,
        final_iterations: 6,
        interval: 2,
        checkpoint_every: 2,
        ..Settings::DEFAULT
    };
    let goals = Goals {
        goal: Some(Goal::Absolute { psnr_db: 20.0, ssim: 0.0 }),
        schedule: Schedule::listed(&[0.0, 0.2, 0.4]).unwrap(),
        baselines: vec![Baseline::RenderOnly],
        ratio_study: true,
        ..Goals::default()
    };
    let oracle = PaperOracle::published(60.0).unwrap();
    let asked = Request::new("tiny", tiny.dense, tiny.cameras, oracle, tiny.display);
    Request { settings, goals, display_ratio: Some(0.5), least_gate: 0, ..asked }
}

/// The same with levels for the periphery, on a screen on which 48 pixels show all of them.
pub fn foveated() -> Request {
    let screens = Screen { pooling_rate: 1.2, ..Screen::PUBLISHED }.into();
    let clock = CycleOracle {
        system: System::named("gscore").unwrap(),
        fps: 60.0,
        memory: Budget::DEFAULT,
    };
    let foveation = Foveation::new(screens, clock, 215.0).unwrap();
    let request = request();
    let schedule = Schedule::listed(&[0.0, 0.3]).unwrap();
    let goals = Goals { schedule, ratio_study: false, ..request.goals };
    Request { goals, foveation: Some(foveation), ..request }
}

pub fn open(request: Request) -> Campaign {
    Campaign::open(request, &()).unwrap()
}

/// Cancels after so many iterations.
struct CancelsAfter(AtomicU32);

impl Watch for CancelsAfter {
    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }
}

impl CampaignWatch for CancelsAfter {
    fn advanced(&self, n: u64) {
        // What was done before is announced at once.
        if n == 1 {
            let _ = self.0.try_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1));
        }
    }
}

/// Cancels again and again; how often.
fn in_pieces(campaign: &Campaign, store: &MemoryStore, iterations: u32) -> (Finished, u32) {
    let mut pieces = 0;
    loop {
        pieces += 1;
        assert!(pieces < 100, "no end");
        let watch = CancelsAfter(AtomicU32::new(iterations));
        if let Some(finished) = campaign.run(store, &watch).unwrap() {
            return (finished, pieces);
        }
    }
}

#[track_caller]
fn same(a: &Finished, b: &Finished) {
    // As text: HVSQ and FLIP may be no numbers, which are never equal.
    assert_eq!(format!("{:?}", a.outcomes), format!("{:?}", b.outcomes));
    assert_eq!(format!("{:?}", a.history), format!("{:?}", b.history));
    assert_eq!(a.results.to_json(), b.results.to_json());
    assert_eq!((&a.model, &a.pictures, &a.ratios), (&b.model, &b.pictures, &b.ratios));
    let model = |f: &Finished| f.foveated.as_ref().and_then(|f| f.result.clone());
    assert_eq!(model(a), model(b));
}

#[test]
fn a_cancelled_campaign_goes_on_bit_for_bit() {
    let (whole, broken) = (MemoryStore::new(), MemoryStore::new());
    let once = open(request()).run(&whole, &()).unwrap().expect("it was not cancelled");
    assert!(once.model.is_some() && once.pictures.is_some() && !once.ratios.is_empty());
    let (pieces, count) = in_pieces(&open(request()), &broken, 7);
    assert!(count > 3, "{count} pieces");
    same(&once, &pieces);
    let names = whole.list("checkpoints").unwrap();
    assert_eq!(names, broken.list("checkpoints").unwrap());
    for name in names {
        let of = |store: &MemoryStore| store.read(&format!("checkpoints/{name}")).unwrap();
        assert!(of(&whole) == of(&broken), "{name}");
    }
    // A finished campaign that is run again says the same.
    same(&once, &open(request()).run(&whole, &()).unwrap().unwrap());
}

#[test]
fn results_say_where_lambda_steered_a_model() {
    let asked = request();
    let dimming = Dimming::Term(LambdaRule::Damped);
    let asked = Request { settings: Settings { dimming, ..asked.settings }, ..asked };
    let finished = open(asked).run(&MemoryStore::new(), &()).unwrap().expect("not cancelled");
    let target = Target::Likeness(Quality::likeness(20.0, 0.0));
    let mut steered = 0;
    for (job, (outcome, model)) in
        finished.outcomes.iter().zip(&finished.results.models).enumerate()
    {
        let from = outcome.iterations - outcome.iterations.div_ceil(10);
        let rows = finished.history.iter().filter(|row| row.job == job).map(|row| row.iteration);
        let last = rows.filter(|row| row.iteration >= from && row.lambda > 0.0);
        let margins: Vec<f64> = last
            .filter_map(|row| row.check)
            .map(|check| target.margin_db(check.seen.quality))
            .collect();
        let margin_db =
            (!margins.is_empty()).then(|| margins.iter().sum::<f64>() / margins.len() as f64);
        assert_eq!(model.steered_db, margin_db, "{}", outcome.name);
        assert_eq!(margin_db.is_some(), outcome.lambda.is_some(), "{}", outcome.name);
        steered += usize::from(margin_db.is_some());
    }
    assert!(steered >= 3, "samples and the optimum");
    assert!(finished.results.models.iter().any(|m| m.baseline.is_some() && m.steered_db.is_none()));
}

/// A search beyond its rendering end: pruning stops at two thirds, and takes least there.
fn search() -> Request {
    let asked = request();
    let settings = Settings { iterations: 24, final_iterations: 24, ..asked.settings };
    let goal = Some(Goal::Absolute { psnr_db: 24.0, ssim: 0.0 });
    let goals = Goals { goal, schedule: Schedule::FIVE, ..asked.goals };
    Request { settings, goals, display_ratio: Some(0.1), ..asked }
}

#[test]
fn samples_that_start_from_each_other_are_cancelled_and_go_on_bit_for_bit() {
    let once = open(search()).run(&MemoryStore::new(), &()).unwrap().expect("not cancelled");
    for iterations in [7, 10] {
        let (pieces, count) = in_pieces(&open(search()), &MemoryStore::new(), iterations);
        assert!(count > 8, "{count} pieces");
        same(&once, &pieces);
    }
}

#[test]
fn priced_anew_the_levels_are_parts_of_the_model_that_takes_least_then() {
    let foveated = || {
        let asked = foveated();
        let settings = Settings { iterations: 60, final_iterations: 60, ..asked.settings };
        let schedule = Schedule::listed(&[0.0, 0.05, 0.7]).unwrap();
        let goal = Some(Goal::Absolute { psnr_db: 15.0, ssim: 0.0 });
        Request {
            settings,
            goals: Goals { goal, schedule, ..asked.goals },
            keep_all: true,
            ..asked
        }
    };
    let store = MemoryStore::new();
    let first = open(foveated()).run(&store, &()).unwrap().unwrap();
    let levels = |finished: &Finished| {
        let level = |o: &&Outcome| o.place.level > 0 && o.role.baseline().is_none();
        finished.outcomes.iter().filter(level).map(|o| o.name.clone()).collect::<Vec<_>>()
    };
    assert!(levels(&first).iter().any(|name| name.contains("optimum")), "no level passes");
    let best = |finished: &Finished| finished.conclusion.best.clone();
    let mut moved = 0;
    for ratio in [0.5, 0.002, 500.0] {
        let other = || open(Request { display_ratio: Some(ratio), ..foveated() });
        let (mut to_price, mut to_make) = (other(), other());
        let (priced, made) = (MemoryStore::new(), MemoryStore::new());
        let priced = to_price.reprice(&store, &priced, false, &()).unwrap().unwrap();
        // Composing checks that every level is a part of the one before, bit for bit.
        let priced = priced.priced().unwrap();
        let made = to_make.reprice(&store, &made, true, &()).unwrap().unwrap();
        let made = made.work(&()).unwrap().unwrap();
        assert!(levels(&made).iter().any(|name| name.contains("optimum")), "{ratio}");
        let same = [best(&first), best(&first).map(|name| format!("former-{name}"))];
        if same.contains(&best(&priced)) {
            assert!(!levels(&priced).is_empty(), "{ratio}");
        } else {
            moved += 1;
            assert_eq!(levels(&priced), Vec::<String>::new(), "{ratio}");
        }
    }
    assert!(moved > 0, "no ratio moves the model: the test says nothing");
}

#[test]
fn a_level_trains_on_the_colours_of_the_level_before_as_they_were_before_it_was_dimmed() {
    let asked = foveated();
    let goal = Some(Goal::Absolute { psnr_db: 15.0, ssim: 0.0 });
    let goals = Goals { goal, schedule: Schedule::listed(&[0.0]).unwrap(), ..asked.goals };
    let campaign = open(Request { goals, keep_all: true, ..asked });
    let store = MemoryStore::new();
    let found = campaign.run(&store, &()).unwrap().unwrap();
    let constants = |name: &str| {
        let outcome = found.outcomes.iter().find(|o| o.name == name).expect(name);
        let kept = Checkpoints::new(&store, campaign.fingerprint()).load_model(name).unwrap().scene;
        let gains = outcome.gains.expect("there is much to spend");
        let mut bright = kept.clone();
        gains.undo(&mut bright, Trains::ColoursAndOpacities);
        let all = (usize::from(kept.sh_degree) + 1).pow(2);
        [bright, kept].map(|scene| scene.sh.iter().copied().step_by(all).collect::<Vec<f32>>())
    };
    let far = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>();
    let [before, dimmed] = constants(found.conclusion.best.as_ref().unwrap());
    let [trained, _] = constants("level2-sample-01");
    assert_eq!(trained.len(), before.len(), "nothing is pruned between them");
    let (moved, lost) = (far(&trained, &before), far(&dimmed, &before));
    assert!(moved < 0.2 * lost, "training moved them by {moved}, gains by {lost}");
}

#[test]
fn priced_anew_a_few_samples_are_taken_around_the_minimum() {
    let store = MemoryStore::new();
    open(Request { keep_all: true, ..search() }).run(&store, &()).unwrap().unwrap();
    let other = || open(Request { display_ratio: Some(5.0), keep_all: true, ..search() });
    let (mut to_price, mut to_make) = (other(), other());
    let (priced, made) = (MemoryStore::new(), MemoryStore::new());
    let priced = to_price.reprice(&store, &priced, false, &()).unwrap().unwrap().priced().unwrap();
    let run = to_make.reprice(&store, &made, true, &()).unwrap().unwrap();
    let hears = Hears::default();
    let found = run.work(&hears).unwrap().unwrap();
    // A bar counts what is trained here, not what was before.
    let most = to_make.plan.most_iterations(&to_make.settings);
    let advanced = u64::from(hears.advanced.into_inner());
    assert!(advanced >= found.history.len() as u64 && advanced <= most, "{advanced} of {most}");
    let samples = |f: &Finished| f.outcomes.iter().filter(|o| o.role == Role::Sample).count();
    let more = samples(&found) - samples(&priced);
    assert!((1..=2).contains(&more), "{more} more samples");
    let mut names: Vec<&str> = found.outcomes.iter().map(|o| &*o.name).collect();
    assert!(names.contains(&"optimum"), "{names:?}");
    names.sort_unstable();
    assert!(names.windows(2).all(|two| two[0] != two[1]), "{names:?}");
    let watts = |f: &Finished| {
        let best = f.outcomes.iter().find(|o| Some(&o.name) == f.conclusion.best.as_ref());
        best.unwrap().watts.total_w()
    };
    assert!(watts(&found) <= watts(&priced));
    // In the same place it goes on.
    let mut again = other();
    let run = again.reprice(&store, &made, true, &()).unwrap().unwrap();
    same(&found, &run.work(&()).unwrap().unwrap());
}

#[test]
fn so_does_a_foveated_one() {
    let once = open(foveated()).run(&MemoryStore::new(), &()).unwrap().unwrap();
    let found = once.foveated.as_ref().expect("levels were made");
    assert!(found.result.is_some() && found.album.is_some() && found.measured.len() >= 2);
    let (pieces, count) = in_pieces(&open(foveated()), &MemoryStore::new(), 19);
    assert!(count > 2, "{count} pieces");
    same(&once, &pieces);
}

#[test]
fn a_quality_is_the_same_whatever_lower_ones_are_asked_for() {
    let run = |levels: &[Level], schedule: Schedule| {
        let tiny = tiny(200, 3, (48, 36));
        let asked = request();
        let goal = Some(Goal::Levels(levels.to_vec()));
        let goals = Goals { goal, schedule, ratio_study: false, ..asked.goals };
        let references = ReferenceImages::Photos(Box::new(tiny.references));
        let settings = Settings { iterations: 8, held_out_iterations: 16, ..asked.settings };
        let request = Request { goals, references, settings, ..asked };
        open(request).run(&MemoryStore::new(), &()).unwrap().unwrap()
    };
    let [h, m, l] = Level::ALL;
    for schedule in [Schedule::listed(&[0.0, 0.2]).unwrap(), Schedule::FIVE] {
        let alone = run(&[m], schedule.clone());
        let beside = run(&[l, m], schedule.clone());
        assert!(alone.model.is_some() && alone.model == beside.model);
        let whole = run(&[h, m, l], schedule.clone());
        let two = run(&[h, m], schedule);
        assert_eq!(two.model, whole.model);
        assert_eq!(two.others[..], whole.others[..1], "M");
        let (n, place) = (two.outcomes.len(), Place { variant: 1, level: 0 });
        let of = |done: &[Outcome]| format!("{:?}", &done[..n]);
        assert_eq!(of(&two.outcomes), of(&whole.outcomes));
        assert!(two.outcomes[n - 1].place == place && whole.outcomes.len() > n);
        // What is asked of a lower quality takes no more than a higher one.
        let watts = |name: &str| whole.results.result(name).unwrap().total_w();
        assert!(watts("H") >= watts("M") && watts("M") >= watts("L"));
    }
}

/// Counts what it hears.
#[derive(Default)]
struct Hears {
    iterations: AtomicU32,
    advanced: AtomicU32,
    outcomes: AtomicU32,
}

impl Watch for Hears {}

impl CampaignWatch for Hears {
    fn iteration(&self, _: &str, _: &Iteration) {
        self.iterations.fetch_add(1, Ordering::Relaxed);
    }

    fn advanced(&self, n: u64) {
        self.advanced.fetch_add(n as u32, Ordering::Relaxed);
    }

    fn outcome(&self, _: &powergs_optimize::outcome::Outcome) {
        self.outcomes.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn a_watch_hears_every_iteration_and_every_model() {
    let (store, campaign) = (MemoryStore::new(), open(request()));
    assert!(campaign.run(&store, &CancelsAfter(AtomicU32::new(4))).unwrap().is_none());
    let hears = Hears::default();
    let finished = campaign.run(&store, &hears).unwrap().unwrap();
    assert_eq!(hears.iterations.into_inner() as usize, finished.history.len());
    // The dense model was measured before.
    assert_eq!(hears.outcomes.into_inner() as usize, finished.outcomes.len() - 1);
    let most = campaign.plan.most_iterations(&campaign.settings);
    assert!(u64::from(hears.advanced.into_inner()) <= most);
    assert_eq!(finished.outcomes[0].role, Role::Dense);
}

/// `settings` with another value of one of them.
fn other(changed: &Setting, settings: &Settings) -> Settings {
    let value = match (changed.kind, changed.of(settings)) {
        (Kind::Real(low, _), Value::Real(x)) => Value::Real(f64::midpoint(low, x)),
        (Kind::Name(names), _) => Value::Name(names()[1].0),
        (_, Value::Count(n)) => Value::Count(n + 1),
        other => panic!("{other:?}"),
    };
    let given = SETTINGS.iter().map(|setting| (setting, setting.of(settings)));
    Settings::with(&given.chain([(changed, value)]).collect::<Vec<_>>()).unwrap()
}

#[test]
fn a_fingerprint_changes_with_everything_that_numbers_depend_on() {
    let others: [fn(&mut Request); 14] = [
        |r| r.name.push('2'),
        |r| r.dense.sh[5] += 1e-3,
        |r| r.externals.push(("mini".into(), r.dense.clone())),
        |r| r.cameras[3].fx += 1.0,
        |r| r.background = [1.0; 3],
        |r| r.validation_every = 3,
        |r| r.least_gate = 5,
        |r| r.power_views = PowerViews::Spread(NonZeroUsize::MIN),
        |r| r.goals.goal = Some(Goal::Absolute { psnr_db: 21.0, ssim: 0.0 }),
        |r| r.goals.baselines.clear(),
        |r| r.goals.lambda_study = true,
        |r| r.goals.schedule = Schedule::FIVE,
        |r| r.oracle = Box::new(PaperOracle::published(30.0).unwrap()),
        |r| r.display_ratio = None,
    ];
    let print = |change: &dyn Fn(&mut Request)| {
        let mut request = request();
        change(&mut request);
        open(request).fingerprint()
    };
    let mut prints = vec![print(&|_| ())];
    let counts = SETTINGS.iter().filter(|setting| !setting.is(Mark::Harmless));
    prints.extend(counts.map(|setting| print(&|r| r.settings = other(setting, &r.settings))));
    prints.extend(others.iter().map(|change| print(change)));
    prints.push(open(foveated()).fingerprint());
    let count = prints.len();
    prints.sort_unstable();
    prints.dedup();
    assert_eq!(prints.len(), count);
    // When checkpoints are written changes no number.
    let often = print(&|r| r.settings.checkpoint_every = 1);
    assert!(prints.contains(&often));
}

#[test]
fn another_campaign_is_not_continued() {
    let store = MemoryStore::new();
    let campaign = open(request());
    assert!(matches!(campaign.resume(&store), Err(CampaignError::NoRun)));
    assert!(campaign.run(&store, &CancelsAfter(AtomicU32::new(1))).unwrap().is_none());
    assert!(matches!(campaign.begin(&store), Err(CampaignError::HoldsRun)));
    let mut other = request();
    other.settings.seed = 2;
    let error = open(other).run(&store, &()).unwrap_err();
    let CampaignError::Run(RunError::Input { message, .. }) = error else { panic!("{error}") };
    assert!(message.contains("other inputs or settings"), "{message}");
}

#[track_caller]
fn refused(change: impl Fn(&mut Request), expected: Invalid) {
    let mut request = request();
    change(&mut request);
    match Campaign::open(request, &()) {
        Err(CampaignError::Invalid(invalid)) => assert_eq!(invalid, expected),
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("accepted: {expected}"),
    }
}

#[test]
fn requests_that_cannot_be_met_say_which_key_and_what_it_may_be() {
    let range = |key, value, low, high| Invalid::Range { key, value, low, high };
    refused(|r| r.settings.interval = 0, range("interval", 0.0, 1.0, 1e7));
    refused(|r| r.settings.display_weight = -1.0, range("display_weight", -1.0, 1e-6, 1e6));
    refused(|r| r.display_ratio = Some(0.0), range("display_ratio", 0.0, 0.001, 1000.0));
    refused(|r| r.goals.goal = Some(Goal::Share(0.99)), Invalid::ShareOfPerfect);
    let bright = |r: &mut Request| {
        r.goals.goal = Some(Goal::Absolute { psnr_db: 500.0, ssim: 0.0 });
    };
    refused(bright, Invalid::Likeness);
    let taken = |r: &mut Request| r.externals.push(("optimum".into(), r.dense.clone()));
    refused(taken, Invalid::NameTaken("optimum".into()));
    let mut blind = request();
    for camera in &mut blind.cameras {
        camera.centre += 1000.0 * camera.forward();
    }
    assert!(matches!(Campaign::open(blind, &()), Err(CampaignError::NothingSeen)));
}

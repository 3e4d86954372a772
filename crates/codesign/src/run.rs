//! A co-design from its space to the five pairs.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use powergs_base::format::significant;
use powergs_core::machine::DramModel;
use powergs_core::run::files::DiskFiles;
use powergs_core::run::{RunError, Store};
use powergs_optimize::campaign::Campaign;
use powergs_optimize::pictures::BeforeAfter;
use powergs_optimize::target::Target;
use powergs_optimize::views::Priced;
use powergs_scene::Gaussians;
use powergs_study::sweep::file::Method;
use powergs_study::sweep::run::{Designs, Shard};

use super::alternate::{self, Round};
use super::compare::{
    CompareBudget, Comparison, Found, Limit, Market, Nothing, Pair, Way, compare, front,
};
use super::error::CodesignError;
use super::export::{Exported, exports};
use super::fit::{Fitted, Fitter};
use super::halving::{Trial, better};
use super::machines::Machines;
use super::model::{ModelPoint, models};
use super::pricing::{Fate, MachinePoint, Price, Pricer, Row};
use super::space::SpaceFile;
use super::stability::{Alternative, Coupling, alternatives, coupling};
use super::watch::CodesignWatch;

/// Memory for binned frames by default, bytes.
pub const MEMORY: usize = 512 << 20;

/// Machines of a model that others are priced on, too, the best ones.
const BEST: usize = 32;
/// Parts of the iterations that short fine-tunes have, one after the other.
const RUNGS: [u32; 2] = [8, 4];
/// So many models, the dense one among them, are not halved any more.
const FEW: usize = 4;
/// Machines of a space at most: each is simulated for every model.
pub const MACHINES_MAX: u64 = 1_000_000;
/// Rounds by default.
pub const ROUNDS: u32 = 5;
/// The settings of the optimiser that a co-design can have otherwise than by default.
pub const FIT_SETTINGS: [&str; 4] = ["iterations", "interval", "seed", "checkpoint_every"];

/// The models that are fine-tuned in full, and those that are not with the iterations they had.
type Finalists = (Vec<ModelPoint>, Vec<(ModelPoint, u32)>);

/// A co-design, checked.
pub struct Codesign {
    /// The dense model, its views and what it must reach.
    pub campaign: Campaign,
    /// The machines.
    pub machines: Machines,
    /// The models: the dense one first.
    pub models: Vec<ModelPoint>,
    /// Iterations of a fine-tune.
    pub iterations: u32,
    /// Rounds at most in which the joint machine gives another ratio.
    pub rounds: u32,
    /// Whether all models are first fine-tuned for a part of the iterations, and only the better
    /// ones for all of them.
    pub halving: bool,
    /// What the space file says of budgets.
    space: SpaceFile,
    /// What messages call the space file.
    origin: String,
    /// Memory for binned frames, bytes.
    pub memory: usize,
}

/// What a co-design was made from, for people.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// The scene.
    pub scene: String,
    /// The base machine.
    pub base: String,
    /// The display.
    pub display: String,
    /// Frames that it shows in a second.
    pub fps: f64,
    /// Views, those that decide about quality, and those that are only reported.
    pub views: [usize; 3],
    /// Where watts are counted.
    pub priced: Priced,
    /// Most iterations of a fine-tune.
    pub iterations: u32,
    /// Whether the winners were simulated once more with the banked model of the DRAM.
    pub is_confirmed: bool,
}

/// Everything that a co-design finds.
#[derive(Debug, Clone)]
pub struct Finished {
    /// What it was made from.
    pub about: About,
    /// What models had to reach.
    pub target: Target,
    /// What a pair may take.
    pub budget: CompareBudget,
    /// Labels of the energy tables; the first decides.
    pub tables: Vec<String>,
    /// The models, the dense one first.
    pub models: Vec<Fitted>,
    /// Their prices on all machines, in the same order.
    pub rows: Vec<Row>,
    /// The front of watts, area and frame time.
    pub front: Vec<Pair>,
    /// (a) to (e).
    pub comparisons: Vec<Comparison>,
    /// Ratios that were fitted with the machine of the joint pair, until it stood still.
    pub rounds: Vec<Round>,
    /// The joint model in compressed formats.
    pub exports: Vec<Exported>,
    /// Models that were left after a short fine-tune, and its iterations.
    pub left: Vec<(ModelPoint, u32)>,
    /// The same under every energy table, and on each half of the views.
    pub alternatives: Vec<Alternative>,
    /// Why the joint pair is one.
    pub coupling: Option<Coupling>,
}

impl Finished {
    /// Whether each model reaches the quality; the dense one is what they are compared with.
    pub fn passed(models: &[Fitted]) -> Vec<bool> {
        models.iter().map(|model| model.point.is_dense || model.facts.passed).collect()
    }

    /// What a way finds.
    pub fn of(&self, way: Way) -> Option<&Comparison> {
        self.comparisons.iter().find(|c| c.way == way)
    }

    /// The calibrated price of a pair under the first table.
    pub fn price(&self, (model, machine): Pair) -> Option<&Price> {
        match self.rows.get(model)?.pairs.get(&machine)? {
            Fate::Priced(prices) => prices.first()?.first(),
            Fate::Refused(_) => None,
        }
    }

    /// The area of a price, mm²; not a number where its table has none.
    pub fn area(&self, price: &Price) -> f64 {
        price.area_mm2.unwrap_or(f64::NAN)
    }

    /// Watts that the joint pair saves against the best of (a) to (d), confirmed.
    pub fn gain_w(&self) -> Option<f64> {
        let watts = |way: Way| self.of(way).and_then(Comparison::watts);
        let [a, b, c, d, e] = Way::ALL.map(watts);
        Some([a, b, c, d].into_iter().flatten().reduce(f64::min)? - e?)
    }
}

/// The machines of a model; `origin` is what messages call the space file.
fn designs(
    machines: &Machines,
    model: &ModelPoint,
    dram: DramModel,
    origin: &str,
) -> Result<Designs, RunError> {
    let file = machines.sweep(model, dram);
    let files: Arc<dyn powergs_core::run::files::Files> = Arc::new(DiskFiles);
    Designs::new(&file, Vec::new(), &files, origin)
}

impl Codesign {
    /// Checks a space on an opened campaign: `text` is that of its file, `origin` what messages
    /// call it.
    ///
    /// # Errors
    /// [`CodesignError::Space`]: a record that the machine cannot read; [`RunError::Config`]: a
    /// machine, an axis or a display that cannot be; fewer than two views.
    pub fn open(
        campaign: Campaign,
        space: SpaceFile,
        text: &str,
        origin: &str,
    ) -> Result<Codesign, CodesignError> {
        let views = campaign.given.count;
        if views < 2 {
            return Err(CodesignError::TooFewViews { views });
        }
        let mut machines = Machines::open(&space.machine, text, origin)?;
        let models = models(&space.model, &campaign.dense);
        machines.has_codebooks = models.iter().any(|model| model.formats.codebook.is_some());
        let top = campaign.dense.sh_degree;
        if let Some(degree) = models.iter().map(|m| m.sh_degree).find(|degree| *degree > top) {
            let message = format!(
                "`model.sh-degree`: {degree} is more than the dense model has, {top}: give at most \
                 that"
            );
            return Err(CodesignError::Space { place: origin.to_owned(), message });
        }
        machines.check(&models, origin)?;
        let iterations = campaign.settings.iterations;
        let mut codesign = Codesign {
            campaign,
            machines,
            models,
            iterations,
            rounds: ROUNDS,
            halving: false,
            space,
            origin: origin.to_owned(),
            memory: MEMORY,
        };
        // First, because a table that is there by default must not refuse the space.
        codesign.leave_out_tables();
        // What is wrong with the axes, and what a record has no price for, is said before anything
        // is trained.
        codesign.records_have_designs(&codesign.machines)?;
        let machines = codesign.machines_most()?;
        if machines > MACHINES_MAX {
            let message = format!(
                "{machines} machines: at most {MACHINES_MAX}, each is simulated for every model; \
                 fewer values on the axes, or some of the machines: `machine.sampling`, with \
                 `method = \"lhs\"` and `points`, or `method = \"nsga2\"`"
            );
            return Err(CodesignError::Space { place: origin.to_owned(), message });
        }
        Ok(codesign)
    }

    /// Machines that a model is priced on at most, the base machine among them.
    ///
    /// # Errors
    /// A space that cannot be.
    pub fn machines_most(&self) -> Result<u64, RunError> {
        let space = self.designs(&self.models[0], DramModel::Calibrated)?.space;
        let sampling = space.sampling();
        let all = match sampling.method {
            Method::Nsga2 => sampling.searched(),
            Method::Grid | Method::Random | Method::Lhs | Method::Sobol => space.lattice().points(),
        };
        let points = all.min(space.lattice().points()).min(sampling.points.unwrap_or(u64::MAX));
        Ok(points.saturating_add(1))
    }

    /// Checks the machines with the record of each model.
    fn records_have_designs(&self, machines: &Machines) -> Result<(), RunError> {
        let mut records = Vec::new();
        for model in &self.models {
            // Ratios of pruning do not reach the machine: one model of each record is enough.
            let record = (model.sh_degree, model.formats, model.is_dense);
            if records.contains(&record) {
                continue;
            }
            let designs = designs(machines, model, DramModel::Calibrated, &self.origin);
            designs.map_err(|error| match error {
                RunError::Config { message, .. } if !model.is_dense => {
                    RunError::config(format!("{}, model {}", self.origin, model.name()), message)
                }
                error => error,
            })?;
            records.push(record);
        }
        Ok(())
    }

    /// Leaves out energy tables that nobody asked for where they alone refuse machines of the
    /// space.
    fn leave_out_tables(&mut self) {
        let Err(mut error) = self.records_have_designs(&self.machines) else { return };
        let mut machines = self.machines.clone();
        loop {
            // The table without which the error is another one, or none.
            let found = (1..machines.tables().count()).find_map(|n| {
                let others = machines.without(n)?;
                let rest = self.records_have_designs(&others);
                let is_other =
                    rest.as_ref().err().is_none_or(|e| e.to_string() != error.to_string());
                is_other.then_some((n, others, rest))
            });
            let Some((n, mut others, rest)) = found else { return };
            let label = machines.tables().nth(n).unwrap_or_default().to_owned();
            others.left_out.push((label, error.to_string()));
            match rest {
                Ok(()) => {
                    self.machines = others;
                    return;
                }
                Err(next) => (machines, error) = (others, next),
            }
        }
    }

    /// The machines of a model, which need not be one of the space.
    fn designs(&self, model: &ModelPoint, dram: DramModel) -> Result<Designs, RunError> {
        designs(&self.machines, model, dram, &self.origin)
    }

    /// A machine with the record of a model, as a file.
    ///
    /// # Errors
    /// [`RunError::Internal`]: there is no such machine.
    pub fn machine_toml(
        &self,
        model: &ModelPoint,
        machine: MachinePoint,
    ) -> Result<String, RunError> {
        let design = self.designs(model, DramModel::Banked)?.design(machine);
        let design = design.map_err(|why| RunError::Internal(why.to_string()))?;
        Ok(design.machine.to_toml())
    }

    /// Runs everything that the store does not know yet. `None`: it was cancelled, and goes on from
    /// there when it is run again.
    ///
    /// # Errors
    /// [`CodesignError::OutOfReach`], [`CodesignError::Infeasible`], a store that fails, a defect
    /// of the simulator.
    pub fn run(
        &self,
        store: &dyn Store,
        watch: &dyn CodesignWatch,
    ) -> Result<Option<Finished>, CodesignError> {
        let fitter = Fitter::new(&self.campaign, store);
        let pricer = self.pricer(store);
        let Some((points, left)) = self.finalists(&fitter, &pricer, watch)? else {
            return Ok(None);
        };
        let Some(mut models) = self.fit(&points, &fitter, watch)? else { return Ok(None) };
        let mut rows = Vec::new();
        for model in &models {
            let Some(row) = self.row(&fitter, &pricer, model, None, watch)? else {
                return Ok(None);
            };
            rows.push(row);
        }
        let designs = self.designs(&self.models[0], DramModel::Calibrated)?;
        let tables = designs.tables();
        let budget = self.budget(&rows[0], 0)?;
        // An adaptive search has taken other machines for every model: all are compared on those
        // that are best for one of them.
        let mut common = None;
        if designs.is_adaptive() {
            let passed = Finished::passed(&models);
            let market = Market { rows: &rows, passed: &passed, budget, table: 0, scope: 0 };
            let best = (0..models.len()).flat_map(|model| market.best(model, BEST));
            // With the base machine, which (b) and (d) start from.
            let best: BTreeSet<MachinePoint> = best.chain([None]).collect();
            let machines: Vec<MachinePoint> = best.into_iter().collect();
            for (row, model) in rows.iter_mut().zip(&models) {
                let priced = self.row(&fitter, &pricer, model, Some(&machines), watch)?;
                let Some(priced) = priced else { return Ok(None) };
                *row = priced;
            }
            common = Some(machines);
        }
        let common = common.as_deref();
        let mut rounds: Vec<Round> = Vec::new();
        let (comparisons, joint) = loop {
            let passed = Finished::passed(&models);
            let market = Market { rows: &rows, passed: &passed, budget, table: 0, scope: 0 };
            let compared = self.compared(&market, (&fitter, &models, &pricer), watch)?;
            let Some((comparisons, joint)) = compared else { return Ok(None) };
            // Only now is it known what became of the model of the round before.
            if let Some(round) = rounds.last_mut() {
                (round.pair, round.watts) = (joint.pair, joint.confirmed.total_w);
            }
            let next = alternate::next(&models, &market, joint.pair);
            let Some(point) = next.filter(|_| rounds.len() < self.rounds as usize) else {
                break (comparisons, joint.pair);
            };
            let Some(model) = fitter.fit(&point, self.iterations, watch)? else { return Ok(None) };
            watch.fitted(&model);
            // On the machines of the others: an adaptive search would take machines of its own for
            // it.
            let priced = self.row(&fitter, &pricer, &model, common, watch)?;
            let Some(row) = priced else { return Ok(None) };
            rounds.push(Round { rho: point.rho, pair: joint.pair, watts: f64::NAN });
            models.push(model);
            rows.push(row);
        };
        let passed = Finished::passed(&models);
        let market = Market { rows: &rows, passed: &passed, budget, table: 0, scope: 0 };
        let under = |table: usize| self.budget(&rows[0], table).unwrap_or(budget);
        let alternatives = alternatives(&market, &tables, Some(joint), &under);
        let coupling = coupling(&market, &comparisons);
        let front = front(&market);
        let scene = fitter.scene(&models[joint.0])?;
        let exports = exports(&self.campaign, &scene, fitter.target())?;
        Ok(Some(Finished {
            about: self.about(),
            target: fitter.target(),
            budget,
            tables,
            models,
            rows,
            front,
            comparisons,
            rounds,
            exports,
            left,
            alternatives,
            coupling,
        }))
    }

    /// Makes and prices one part of the models, and finds nothing: when the store has all parts,
    /// [`Codesign::run`] does. `None`: it was cancelled.
    ///
    /// # Errors
    /// A store that fails, numbers that are not finite, a defect of the simulator.
    pub fn run_part(
        &self,
        part: Shard,
        store: &dyn Store,
        watch: &dyn CodesignWatch,
    ) -> Result<Option<()>, CodesignError> {
        let fitter = Fitter::new(&self.campaign, store);
        let pricer = self.pricer(store);
        let count = self.models.len() as u64;
        let numbered = (0..).zip(&self.models).filter(|(i, _)| part.has(*i, count));
        let models: Vec<&ModelPoint> = numbered.map(|(_, model)| model).collect();
        self.announce(models.iter().copied(), self.iterations, watch);
        let mut fitted = Vec::new();
        for model in models {
            let Some(model) = fitter.fit(model, self.iterations, watch)? else { return Ok(None) };
            watch.fitted(&model);
            fitted.push(model);
        }
        for model in &fitted {
            if self.row(&fitter, &pricer, model, None, watch)?.is_none() {
                return Ok(None);
            }
        }
        Ok(Some(()))
    }

    fn pricer<'a>(&'a self, store: &'a dyn Store) -> Pricer<'a> {
        let Codesign { campaign, machines, memory, .. } = self;
        Pricer { campaign, machines, store, memory: *memory }
    }

    /// Says how many models are to be made.
    fn announce<'a>(
        &self,
        models: impl Iterator<Item = &'a ModelPoint>,
        iterations: u32,
        watch: &dyn CodesignWatch,
    ) {
        let tuned = models.filter(|model| !model.is_dense).count();
        watch.fitting(tuned, tuned as u64 * u64::from(iterations));
    }

    /// A model on all machines, or on some; without pairs where it misses the quality. `None` after
    /// a cancellation.
    fn row(
        &self,
        fitter: &Fitter<'_>,
        pricer: &Pricer<'_>,
        model: &Fitted,
        machines: Option<&[MachinePoint]>,
        watch: &dyn CodesignWatch,
    ) -> Result<Option<Row>, RunError> {
        // It can win nothing, and simulating its machines is what takes time.
        if !model.point.is_dense && !model.facts.passed {
            return Ok(Some(Row::default()));
        }
        let scene = Arc::new(fitter.scene(model)?);
        match machines {
            None => pricer.all(model, scene, watch),
            Some(machines) => pricer.on(model, scene, machines, watch),
        }
    }

    /// The models that are fine-tuned in full, and those that are not. `None` after a cancellation.
    ///
    /// With `halving` all are fine-tuned for an eighth of the iterations, the better half of them
    /// for a quarter, and the better half of these in full. Better is who takes fewer watts on the
    /// best machine for the dense model or one that is nearly as good, or is nearer to the quality:
    /// a model goes only if enough others are better in one and not worse in the other, before the
    /// watts alone decide.
    fn finalists(
        &self,
        fitter: &Fitter<'_>,
        pricer: &Pricer<'_>,
        watch: &dyn CodesignWatch,
    ) -> Result<Option<Finalists>, CodesignError> {
        let (mut points, mut left) = (self.models.clone(), Vec::new());
        if !self.halving {
            return Ok(Some((points, left)));
        }
        let dense = fitter.fit(&points[0], self.iterations, watch)?.expect("it takes no time");
        let Some(row) = self.row(fitter, pricer, &dense, None, watch)? else { return Ok(None) };
        let budget = self.budget(&row, 0)?;
        let (rows, passed) = (&[row], &[true]);
        let market = Market { rows, passed, budget, table: 0, scope: 0 };
        let mut machines = market.best(0, BEST);
        // Without one in the budget the base machine tells models apart.
        if machines.is_empty() {
            machines.push(None);
        }
        for part in RUNGS {
            let iterations = (self.iterations / part).max(1);
            if points.len() <= FEW {
                break;
            }
            self.announce(points.iter(), iterations, watch);
            let mut trials = Vec::new();
            for point in &points[1..] {
                let Some(model) = fitter.fit(point, iterations, watch)? else { return Ok(None) };
                watch.fitted(&model);
                let scene = Arc::new(fitter.scene(&model)?);
                let Some(row) = pricer.on(&model, scene, &machines, watch)? else {
                    return Ok(None);
                };
                let watts = |fate: &Fate| match fate {
                    Fate::Priced(prices) => prices[0][0].total_w,
                    Fate::Refused(_) => f64::INFINITY,
                };
                let watts = row.pairs.values().map(watts).fold(f64::INFINITY, f64::min);
                // Quality beyond the target is worth nothing: among models that reach it watts
                // alone decide.
                trials.push(Trial { watts, margin_db: model.facts.margin_db.min(0.0) });
            }
            let stays = better(&trials, trials.len().div_ceil(2));
            let mut kept = vec![points[0].clone()];
            for (point, stays) in points.into_iter().skip(1).zip(stays) {
                match stays {
                    true => kept.push(point),
                    false => left.push((point, iterations)),
                }
            }
            points = kept;
        }
        Ok(Some((points, left)))
    }

    /// The five ways, and what the joint one finds. `None` after a cancellation.
    fn compared(
        &self,
        market: &Market<'_>,
        (fitter, models, pricer): (&Fitter<'_>, &[Fitted], &Pricer<'_>),
        watch: &dyn CodesignWatch,
    ) -> Result<Option<(Vec<Comparison>, Found)>, CodesignError> {
        // Before anything is simulated with banks, which takes far longer.
        if let Err(nothing) = market.ranked(market.pairs()) {
            return Err(CodesignError::Infeasible(self.infeasible(&nothing, market, models)));
        }
        let mut confirm = |pairs: &[Pair]| self.confirm(fitter, models, pricer, pairs, watch);
        let mut each = |comparison: &Comparison| watch.confirmed(comparison);
        let compared = compare(market, &mut confirm, &mut each)?;
        let Some(mut comparisons) = compared else { return Ok(None) };
        match comparisons.pop().map(|joint| (joint.way, joint.found)) {
            Some((way, Ok(found))) => {
                comparisons.push(Comparison { way, found: Ok(found) });
                Ok(Some((comparisons, found)))
            }
            Some((_, Err(nothing))) => Err(CodesignError::Infeasible(format!(
                "with the calibrated model of the DRAM pairs keep the budget, with the banked one \
                 none of the best does: {}",
                self.infeasible(&nothing, market, models)
            ))),
            None => Err(RunError::Internal("no way was gone".into()).into()),
        }
    }

    fn about(&self) -> About {
        let campaign = &self.campaign;
        About {
            scene: campaign.name.clone(),
            base: self.machines.base.label(),
            display: campaign.display.name.clone(),
            fps: self.machines.fps(),
            views: [campaign.given.count, campaign.gate_views(), campaign.split.test.len()],
            priced: campaign.priced.clone(),
            iterations: self.iterations,
            is_confirmed: self.machines.has_banks(),
        }
    }

    /// A model in the first test view, beside the dense one.
    ///
    /// # Errors
    /// [`RunError::Input`]: the store does not have it.
    pub fn picture(&self, store: &dyn Store, model: &Fitted) -> Result<BeforeAfter, RunError> {
        let scene = Fitter::new(&self.campaign, store).scene(model)?;
        Ok(BeforeAfter::of(&self.campaign.setup(), &scene, model.point.name()))
    }

    /// The parameters of a model as a machine reads them.
    ///
    /// # Errors
    /// [`RunError::Input`]: the store does not have it.
    pub fn scene(&self, store: &dyn Store, model: &Fitted) -> Result<Gaussians, RunError> {
        Fitter::new(&self.campaign, store).scene(model)
    }

    /// Makes models in full. `None` after a cancellation.
    fn fit(
        &self,
        points: &[ModelPoint],
        fitter: &Fitter<'_>,
        watch: &dyn CodesignWatch,
    ) -> Result<Option<Vec<Fitted>>, CodesignError> {
        self.announce(points.iter(), self.iterations, watch);
        let mut fitted = Vec::new();
        for model in points {
            let Some(model) = fitter.fit(model, self.iterations, watch)? else { return Ok(None) };
            watch.fitted(&model);
            fitted.push(model);
        }
        // The dense model passes by definition, so that it says nothing of the target.
        let tuned = || fitted.iter().filter(|model| !model.point.is_dense);
        if tuned().any(|model| model.facts.passed) {
            return Ok(Some(fitted));
        }
        let margin = |model: &&Fitted| model.facts.margin_db;
        let best = tuned().max_by(|a, b| margin(a).total_cmp(&margin(b)));
        let what = best.map_or_else(String::new, |best| {
            let quality = best.facts.gate.quality;
            format!(
                "; the best is {} with {:.2} dB and an SSIM of {:.4} over the gate views, {:.2} dB \
                 short",
                best.point.name(),
                quality.psnr_db,
                quality.ssim,
                -best.facts.margin_db
            )
        });
        Err(CodesignError::OutOfReach(format!(
            "no model of {}reaches the quality{what}; give it more iterations, less pruning, more \
             bits, or a lower quality{}",
            if self.origin.is_empty() { String::new() } else { format!("{} ", self.origin) },
            if self.halving { "; without --halving no model is left out" } else { "" }
        )))
    }

    /// Simulates pairs with the banked model of the DRAM.
    fn confirm(
        &self,
        fitter: &Fitter<'_>,
        fitted: &[Fitted],
        pricer: &Pricer<'_>,
        pairs: &[Pair],
        watch: &dyn CodesignWatch,
    ) -> Result<Option<Vec<Option<Price>>>, CodesignError> {
        let mut machines: BTreeMap<usize, Vec<_>> = BTreeMap::new();
        for (model, machine) in pairs {
            machines.entry(*model).or_default().push(*machine);
        }
        let mut priced: BTreeMap<usize, Row> = BTreeMap::new();
        for (model, points) in machines {
            let scene = Arc::new(fitter.scene(&fitted[model])?);
            let row = match self.machines.has_banks() {
                true => pricer.confirmed(&fitted[model], scene, &points, watch)?,
                false => pricer.on(&fitted[model], scene, &points, watch)?,
            };
            let Some(row) = row else { return Ok(None) };
            priced.insert(model, row);
        }
        let price = |(model, machine): &Pair| match priced[model].pairs.get(machine)? {
            Fate::Priced(prices) => Some(prices.first()?[0]),
            Fate::Refused(_) => None,
        };
        Ok(Some(pairs.iter().map(price).collect()))
    }

    /// What a pair may take under an energy table: what the space file says, or what the base
    /// machine takes and the display shows.
    fn budget(&self, dense: &Row, table: usize) -> Result<CompareBudget, CodesignError> {
        let frame_ms = self.space.budget.frame_time.map(|time| time.0 * 1e-6);
        let frame_ms = frame_ms.unwrap_or(1e3 / self.machines.fps());
        let of_base = |table: usize| match dense.pairs.get(&None) {
            Some(Fate::Priced(prices)) => prices.get(table)?[0].area_mm2,
            Some(Fate::Refused(_)) | None => None,
        };
        // Under another table the same share of the base machine: nodes differ.
        let area = match self.space.budget.area.map(|area| area.0) {
            Some(stated) if table == 0 => Some(stated),
            Some(stated) => {
                of_base(table).zip(of_base(0)).map(|(here, first)| stated * here / first)
            }
            None => of_base(table),
        };
        match area {
            Some(area_mm2) => Ok(CompareBudget { area_mm2, frame_ms }),
            None => Err(CodesignError::Space {
                place: self.origin.clone(),
                message: "no area to keep to: the base machine cannot run the frames, or its \
                          energy table has no areas; give `budget.area` and a table with areas"
                    .into(),
            }),
        }
    }

    /// Which limit binds, and the nearest miss.
    fn infeasible(&self, nothing: &Nothing, market: &Market<'_>, models: &[Fitted]) -> String {
        let Nothing { pairs, limits, refused, nearest } = nothing;
        let budget = &market.budget;
        let mut why: Vec<String> = Vec::new();
        for (limit, count) in limits {
            why.push(match limit {
                Limit::Area => format!("{count} are larger than {:.4} mm2", budget.area_mm2),
                Limit::FrameTime => {
                    format!(
                        "{count} take more than {} ms for a frame",
                        significant(budget.frame_ms)
                    )
                }
                Limit::Both => format!(
                    "{count} are larger than {:.4} mm2 and take more than {} ms for a frame",
                    budget.area_mm2,
                    significant(budget.frame_ms)
                ),
                Limit::NoArea => format!("{count} have no area in the energy table"),
            });
        }
        if *refused > 0 {
            why.push(format!("{refused} are invalid configurations, or cannot run the frames"));
        }
        let nearest = nearest.as_ref().map_or_else(String::new, |nearest| {
            let ((model, machine), price) = **nearest;
            let called = |m: u64| format!("machine #{m} ({})", market.rows[model].name(Some(m)));
            let machine = machine.map_or("the base machine".into(), called);
            let area = price.area_mm2.map_or_else(String::new, |a| format!("{a:.4} mm2, "));
            format!(
                "; the nearest miss is {} on {machine}: {area}{} ms",
                models.get(model).map_or_else(String::new, |model| model.point.name()),
                significant(price.frame_ms)
            )
        });
        format!(
            "no pair keeps the budget: of {pairs} pairs {}{nearest}; give a larger budget, or a \
             space with other machines",
            why.join(", ")
        )
    }
}

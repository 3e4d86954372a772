//! What every pair of a model and a machine costs: a sweep of the machines for each model.

use std::collections::BTreeMap;
use std::sync::Arc;

use powergs_core::machine::DramModel;
use powergs_core::run::files::DiskFiles;
use powergs_core::run::{RunError, Store};
use powergs_optimize::campaign::Campaign;
use powergs_scene::{Camera, Gaussians};
use powergs_study::sweep::run::{
    Existing, OpenedSweep, Plan, ResultSink, Results, Shard, SharedResults, SweepFolder,
    SweepTrace, search::search, work,
};
use powergs_study::sweep::table::{Cell, TraceLabel};
use powergs_views::RenderedViews;

use super::fit::Fitted;
use super::machines::{CODEBOOK, Machines};
use super::part::CodesignPart;
use super::watch::CodesignWatch;

/// The halves of the views, as their rows are called.
pub const HALVES: [&str; 2] = ["first-half", "second-half"];
/// Means over all views, then over each half: places in [`ModelPrices`].
pub const SCOPES: usize = 1 + HALVES.len();

/// A machine of the space: its point, `None` for the base machine.
pub type MachinePoint = Option<u64>;

/// What a pair costs under one energy table over some views.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Price {
    /// Display, rendering and standby at the display rate, watts.
    pub total_w: f64,
    /// The display alone, watts.
    pub display_w: f64,
    /// Preprocessing, sorting, rendering, and standby (leakage, background and refresh), watts.
    pub stages_w: [f64; 4],
    /// The chip, mm²; `None` where the energy table has no areas.
    pub area_mm2: Option<f64>,
    /// The slowest frame, ms.
    pub frame_ms: f64,
    /// Read from and written to DRAM for a frame, bytes.
    pub dram_bytes: f64,
}

impl Price {
    /// The columns of [`Price::stages_w`].
    const STAGES: [&str; 4] =
        ["power_w.preprocessing", "power_w.sorting", "power_w.rendering", "power_w.standby"];

    fn of(table: &Results, row: &[Cell]) -> Option<Price> {
        let number = |column: &str| table.number(row, column);
        let [a, b, c, d] = Price::STAGES.map(number);
        Some(Price {
            total_w: number("rendering_plus_display_w")?,
            display_w: number("display_power_w")?,
            stages_w: [a?, b?, c?, d?],
            area_mm2: number("area_mm2"),
            frame_ms: number("frame_time_ms.max")?,
            dram_bytes: number("dram_bytes")?,
        })
    }
}

/// Prices under each energy table of the space, in its order, over all views and over each half.
pub type ModelPrices = Vec<[Price; SCOPES]>;

/// What became of a pair.
#[derive(Debug, Clone, PartialEq)]
pub enum Fate {
    /// It was simulated.
    Priced(ModelPrices),
    /// There is no such machine, or it cannot run the frames, for this reason.
    Refused(String),
}

/// A model on all machines.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Row {
    /// By machine.
    pub pairs: BTreeMap<MachinePoint, Fate>,
    /// The columns of the axes, then those of keys that follow from them.
    pub columns: Vec<String>,
    /// How many of the columns are of axes.
    pub axes: usize,
    /// The machines in these columns.
    pub settings: BTreeMap<MachinePoint, Vec<String>>,
    /// Points that a constraint of the space excludes, under the constraint.
    pub excluded: BTreeMap<String, u64>,
}

/// Prices pairs and keeps the results in a store.
pub struct Pricer<'a> {
    /// The views and the background.
    pub campaign: &'a Campaign,
    /// The machines.
    pub machines: &'a Machines,
    /// Where results are kept.
    pub store: &'a dyn Store,
    /// Memory for binned frames, bytes.
    pub memory: usize,
}

impl Pricer<'_> {
    /// A model on all machines, or those that an adaptive search takes for it, with the
    /// `calibrated` model of the DRAM; `None` after a cancellation.
    ///
    /// # Errors
    /// A space that cannot be, a store that fails, a defect of the simulator.
    pub fn all(
        &self,
        model: &Fitted,
        scene: Arc<Gaussians>,
        watch: &dyn CodesignWatch,
    ) -> Result<Option<Row>, RunError> {
        watch.pricing(&model.point, false);
        self.priced(model, scene, DramModel::Calibrated, None, watch)
    }

    /// A model on some machines, with the `calibrated` model of the DRAM; `None` after a
    /// cancellation.
    ///
    /// # Errors
    /// As [`Pricer::all`].
    pub fn on(
        &self,
        model: &Fitted,
        scene: Arc<Gaussians>,
        points: &[MachinePoint],
        watch: &dyn CodesignWatch,
    ) -> Result<Option<Row>, RunError> {
        watch.pricing(&model.point, false);
        self.priced(model, scene, DramModel::Calibrated, Some(points), watch)
    }

    /// A model on some machines, with the `banked` model of the DRAM; `None` after a cancellation.
    ///
    /// # Errors
    /// As [`Pricer::all`].
    pub fn confirmed(
        &self,
        model: &Fitted,
        scene: Arc<Gaussians>,
        points: &[MachinePoint],
        watch: &dyn CodesignWatch,
    ) -> Result<Option<Row>, RunError> {
        watch.pricing(&model.point, true);
        self.priced(model, scene, DramModel::Banked, Some(points), watch)
    }

    fn priced(
        &self,
        model: &Fitted,
        scene: Arc<Gaussians>,
        dram: DramModel,
        points: Option<&[MachinePoint]>,
        watch: &dyn CodesignWatch,
    ) -> Result<Option<Row>, RunError> {
        let name = model.point.name();
        let file = self.machines.sweep(&model.point, dram);
        let traces = self.traces(&scene)?;
        let mut sweep = OpenedSweep::of(&name, file, Arc::new(DiskFiles), traces)?;
        let id = self.machines.id(&model.point, dram);
        let (model_id, id) = (model.id as u64, id as u64);
        let part = CodesignPart::new(self.store, format!("pairs/{model_id:016x}-{id:016x}"));
        let mut folder = SweepFolder::open(&part, &sweep.state, Existing::Resume, None)?;
        let mut shared = SharedResults::default();
        let plan = match points {
            Some(points) => Plan::of(&sweep.designs, points.iter().copied().flatten(), watch),
            None if sweep.designs.is_adaptive() => {
                search(&mut sweep, &mut folder, &mut shared, self.memory, watch)?
            }
            None => Plan::new(&sweep.designs, watch),
        };
        let Some(plan) = plan else { return Ok(None) };
        let is_wanted = |design: &u32| {
            points.is_none_or(|points| points.contains(&plan.designs[*design as usize].point))
        };
        // A plan always has the base machine, wanted or not.
        let mut machines = plan.machines(Shard::WHOLE);
        machines.iter_mut().for_each(|machine| machine.retain(is_wanted));
        machines.retain(|machine| !machine.is_empty());
        let sink = ResultSink { folder: &mut folder, shared: &mut shared };
        if !work(&mut sweep, &plan, &machines, sink, self.memory, watch)? {
            return Ok(None);
        }
        let table = Results::of(&sweep, &plan, &mut folder.records)?;
        let columns = sweep.designs.columns().iter().map(|c| c.name.clone()).collect();
        let axes = sweep.designs.axis_columns();
        let mut row = Row { columns, axes, excluded: plan.excluded, ..Row::default() };
        row.take(&table, &sweep.designs.tables())?;
        if self.machines.has_codebooks && model.point.formats.codebook.is_none() {
            row.clear(CODEBOOK);
        }
        Ok(Some(row))
    }

    /// The views of a model in two halves, which weigh as many views as they have.
    fn traces(&self, scene: &Arc<Gaussians>) -> Result<Vec<SweepTrace<'static>>, RunError> {
        let views = &self.campaign.power_views;
        // Never between the eyes of a pair.
        let eyes = powergs_core::run::frames::eyes(views);
        let (first, second) = views.split_at((views.len() / eyes).div_ceil(2) * eyes);
        let halves = HALVES.into_iter().zip([first, second]);
        let trace = |(label, views): (&str, &[Camera])| {
            let frames = RenderedViews::new(label, Arc::clone(scene), views.to_vec());
            let frames = frames.on_background(self.campaign.background);
            let label = TraceLabel { label: label.into(), weight: views.len() as f64 };
            SweepTrace::new(Box::new(frames), label)
        };
        halves.map(trace).collect()
    }
}

impl Row {
    /// The machines have no value in columns whose names begin with this.
    fn clear(&mut self, prefix: &str) {
        let columns = self.columns.iter().enumerate();
        let cleared = columns.filter(|(_, name)| name.starts_with(prefix)).map(|(i, _)| i);
        for i in cleared {
            self.settings.values_mut().for_each(|settings| settings[i].clear());
        }
    }

    /// Takes the pairs from the table of a sweep with these energy tables.
    fn take(&mut self, table: &Results, tables: &[String]) -> Result<(), RunError> {
        let place = |name: &str| {
            let place = table.columns.iter().position(|c| c.name == name);
            place.ok_or_else(|| RunError::Internal(format!("results without `{name}`")))
        };
        let (point, status, reason) = (place("point")?, place("status")?, place("reason")?);
        let (energy, scope, trace) = (place("energy_table")?, place("scope")?, place("trace")?);
        let axes = scope + 1..scope + 1 + self.columns.len();
        let mut found: BTreeMap<MachinePoint, Vec<[Option<Price>; SCOPES]>> = BTreeMap::new();
        for row in &table.rows {
            let text = |at: usize| row[at].text();
            let over = match text(scope).as_str() {
                "mean" => Some(0),
                "trace" => HALVES.iter().position(|half| *half == text(trace)).map(|i| 1 + i),
                _ => None,
            };
            let under = tables.iter().position(|label| *label == text(energy));
            let (Some(over), Some(under)) = (over, under) else { continue };
            let machine = match row[point] {
                Cell::Integer(point) => Some(point as u64),
                Cell::Empty | Cell::Text(_) | Cell::Real(_) | Cell::Truth(_) => None,
            };
            match text(status).as_str() {
                "ok" => {
                    let none = || vec![[None; SCOPES]; tables.len()];
                    found.entry(machine).or_insert_with(none)[under][over] = Price::of(table, row);
                    let cells = || row[axes.clone()].iter().map(Cell::text).collect();
                    self.settings.entry(machine).or_insert_with(cells);
                }
                // Of machines that were not asked for.
                "missing" => {}
                _ => {
                    self.pairs.entry(machine).or_insert_with(|| Fate::Refused(text(reason)));
                }
            }
        }
        for (machine, prices) in found {
            let whole =
                |[all, first, second]: [Option<Price>; SCOPES]| Some([all?, first?, second?]);
            // What one table refused stays refused: `or_insert` leaves the reason.
            if let Some(prices) = prices.into_iter().map(whole).collect() {
                self.pairs.entry(machine).or_insert(Fate::Priced(prices));
            }
        }
        Ok(())
    }
}

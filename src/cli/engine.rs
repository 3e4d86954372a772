//! What `replay` runs on: a trace and a model of a machine, opened and checked.

use std::ops::ControlFlow;

use super::machine_file::{LoadedMachine, Text, load_machine_with, read};
use super::replay::{Args, DramArg, EachFrame, Engine, ModelArg};
use super::run_folder::RunFolder;
use super::timeline::{self, Asked};
use super::trace_source::{TraceFrame, TraceSource, hashed};
use super::what_if::{Experiment, Variant, cost};
use super::{Exit, Failure, OrExit, dram_dump};
use powergs_base::config::embedded::ENERGY;
use powergs_core::accel::Machine;
use powergs_core::accel::machine::DramModel;
use powergs_core::accel::timeline::{Observer, Span};
use powergs_core::action::Action;
use powergs_core::energy::{self, EnergyTable};
use powergs_core::sim::check::fits;
use powergs_core::sim::paper::UnitPrices;
use powergs_core::sim::{
    Breach, FrameReport, Label, Lists, Measured, observed, paper, simulate_measured,
};
use powergs_core::workload::paper::Padding;
use powergs_core::workload::{FrameWorkload, Geometry, bin};
use powergs_report::roofline::Roofline;
use powergs_report::tile_load::Picture;
use powergs_report::what_if::Cost;
use powergs_report::{DramModels, Extras, Facts, MachineFacts, TileLoad};

/// The energy table of the `paper` model.
const PAPER_TABLE: &str = "paper";

/// How frames become reports.
enum Simulator {
    Cycle(Box<LoadedMachine>),
    Paper { prices: UnitPrices, padding: Padding, table: Text },
}

impl Simulator {
    fn new(args: &Args) -> Result<Simulator, Failure> {
        if args.model == ModelArg::Cycle {
            if args.reference_padding {
                let what = "--reference-padding belongs to --model paper";
                return Err(Failure::new(Exit::Usage, what));
            }
            let mut sets = args.sets.clone();
            if let Some(model) = args.dram_model {
                sets.push(format!("dram.model={}", model.key()));
            }
            let loaded = load_machine_with(&args.arch, &sets, args.energy.as_deref())?;
            return Ok(Simulator::Cycle(Box::new(loaded)));
        }
        let machine_only = args.dram_model.is_some() || args.timeline.is_some();
        if !args.sets.is_empty() || machine_only || args.energy.is_some() {
            let what = "--set, --energy, --dram-model, --timeline: the paper model has no \
                        machine; use --model cycle";
            return Err(Failure::new(Exit::Usage, what));
        }
        let table = read("energy table", PAPER_TABLE, ENERGY, None)?;
        let parsed = EnergyTable::parse(&table.text).or_exit(Exit::Internal, &table.origin)?;
        let flat = parsed
            .flat_pj()
            .ok_or_else(|| Failure::new(Exit::Internal, "the table `paper` has no flat prices"))?;
        let [flop_pj, sram_pj_per_byte, dram_pj_per_byte] = flat;
        let prices = UnitPrices { flop_pj, sram_pj_per_byte, dram_pj_per_byte };
        let padding = if args.reference_padding { Padding::Reference } else { Padding::TrueTiles };
        Ok(Simulator::Paper { prices, padding, table })
    }

    fn geometry(&self) -> Geometry {
        match self {
            Simulator::Cycle(loaded) => loaded.machine.geometry,
            Simulator::Paper { .. } => Geometry::REFERENCE,
        }
    }

    /// Simulates a frame with what was measured of it.
    fn report(
        &self,
        label: Label,
        workload: &FrameWorkload,
        measured: &Measured,
    ) -> Result<FrameReport, Failure> {
        match self {
            Simulator::Cycle(loaded) => {
                let name = label.name.clone();
                simulate_measured(label, workload, measured, &loaded.machine, &loaded.prices)
                    .map_err(|breach| refused(breach, &name))
            }
            Simulator::Paper { prices, padding, .. } => {
                Ok(paper::simulate(label, workload, *padding, prices))
            }
        }
    }

    /// What is measured of a frame; `lists` are those of the frame before.
    fn measured(&self, workload: &FrameWorkload, lists: &mut Lists) -> Measured {
        match self {
            Simulator::Cycle(loaded) => Measured::of(workload, &loaded.machine, lists),
            Simulator::Paper { .. } => Measured::default(),
        }
    }

    /// Whether a frame needs the lists of the one before.
    fn is_sequential(&self) -> bool {
        match self {
            Simulator::Cycle(loaded) => loaded.machine.gsu.reuse_period > 1,
            Simulator::Paper { .. } => false,
        }
    }

    fn facts(&self) -> MachineFacts {
        match self {
            Simulator::Cycle(loaded) => machine_facts(loaded),
            Simulator::Paper { table, .. } => MachineFacts {
                name: "paper".into(),
                energy_table: table.origin.clone(),
                clock_hz: None,
                dram_peak_gb_s: None,
                roofline: None,
            },
        }
    }

    /// Configuration files that were read, with their roles and what they resolved to.
    fn files(&self) -> Vec<(&'static str, &Text, &str)> {
        match self {
            Simulator::Cycle(l) => vec![
                ("machine", &l.machine_file, l.resolved_toml.as_str()),
                ("energy", &l.energy_file, l.energy_toml.as_str()),
                ("dram", &l.device_file, l.device_file.text.as_str()),
            ],
            Simulator::Paper { table, .. } => vec![("energy", table, table.text.as_str())],
        }
    }
}

/// The failure of a frame: a machine that cannot run it, or a defect.
pub fn refused(breach: Breach, frame: &str) -> Failure {
    match breach.is_refusal() {
        true => Failure::new(Exit::Usage, format!("frame {frame}: {breach}")),
        false => Failure::new(Exit::Internal, format!("internal error in frame {frame}: {breach}")),
    }
}

/// What reports say about a machine.
pub fn machine_facts(loaded: &LoadedMachine) -> MachineFacts {
    MachineFacts {
        name: loaded.machine.name.clone(),
        energy_table: loaded.energy_table.name.clone(),
        clock_hz: Some(loaded.machine.clock.0),
        dram_peak_gb_s: Some(dram_peak(&loaded.machine) * 1e-9),
        roofline: roofline(&loaded.machine),
    }
}

/// Peaks of a machine in the operations that PowerGS counts. A CCU takes a Gaussian through
/// everything each interval and makes its box tests beside that; a rendering unit evaluates and
/// blends a pixel each cycle. Sorting counts no operations.
fn roofline(machine: &Machine) -> Option<Roofline> {
    let flops = energy::flops::per_action();
    let sum = |actions: &[Action]| f64::from(actions.iter().map(|a| flops[a.index()]).sum::<u32>());
    let (ccu, vru) = (&machine.ccu, &machine.vru);
    let gaussian = [Action::Cull, Action::Project, Action::ObbPrepare, Action::ShColour];
    let per_ccu = sum(&gaussian) / f64::from(ccu.initiation_interval)
        + sum(&[Action::ObbTest]) * f64::from(ccu.intersection_units);
    let lanes = f64::from(vru.cores) * f64::from(vru.units_per_core);
    let ceilings = vec![
        ("CCU", machine.clock.0 * f64::from(ccu.units) * per_ccu),
        ("VRU", machine.clock.0 * lanes * sum(&[Action::Alpha, Action::Blend])),
    ];
    Some(Roofline { flops, ceilings, dram_bytes_s: dram_peak(machine) })
}

/// Peak rate of the DRAM that is timed, bytes per second.
fn dram_peak(machine: &Machine) -> f64 {
    match (machine.dram.model, &machine.device) {
        (DramModel::Window | DramModel::Banked, Some(device)) => device.peak_gb_s() * 1e9,
        (DramModel::Bandwidth, _) | (_, None) => machine.dram.bandwidth.0,
    }
}

/// A trace and a simulator.
pub struct TraceEngine {
    source: TraceSource,
    simulator: Simulator,
    facts: Facts,
    experiment: Experiment,
    /// The same machine with the `window` model of the DRAM, where both were asked for.
    window: Option<Variant>,
    /// Sums over frames of the two models.
    models: (u32, DramModels),
}

impl TraceEngine {
    /// Opens and checks everything that `args` name.
    pub fn open(args: &Args) -> Result<TraceEngine, Failure> {
        let simulator = Simulator::new(args)?;
        let source = TraceSource::open(&args.trace, args.frames, &args.display)?;
        if let Some(asked) = &args.timeline {
            let tile = simulator.geometry().tile;
            let tiles = source.facts.width.div_ceil(tile) * source.facts.height.div_ceil(tile);
            asked.check(source.range(), tiles)?;
        }
        let [trace_input, display_input] = source.inputs.clone();
        let mut inputs = vec![trace_input];
        let mut configuration = toml::Table::new();
        for (role, file, resolved) in simulator.files() {
            inputs.push(hashed(role, &file.origin, &mut file.text.as_bytes(), &file.origin)?);
            let table = resolved.parse().or_exit(Exit::Internal, &file.origin)?;
            configuration.insert(role.to_owned(), toml::Value::Table(table));
        }
        inputs.push(display_input);
        configuration.insert("display".into(), toml::Value::Table(source.display_toml.clone()));
        let facts = Facts {
            model: args.model.into(),
            display_fps: args.fps,
            trace: source.facts.clone(),
            machine: simulator.facts(),
            inputs,
            configuration,
        };
        let (mut experiment, mut window) = (Experiment::default(), None);
        if let Simulator::Cycle(loaded) = &simulator {
            experiment = Experiment::new(loaded, source.spread(args.what_if));
            if args.dram_model == Some(DramArg::Both) {
                let variant = Variant::of(loaded, &["dram.model=window".to_owned()]);
                window = Some(variant.map_err(|e| Failure::new(Exit::Usage, e))?);
            }
        }
        let models = (0, DramModels::default());
        Ok(TraceEngine { source, simulator, facts, experiment, window, models })
    }

    /// The machine of the `cycle` model.
    pub fn machine(&self) -> Option<&LoadedMachine> {
        match &self.simulator {
            Simulator::Cycle(loaded) => Some(loaded),
            Simulator::Paper { .. } => None,
        }
    }

    /// One frame of the run, binned for the machine.
    ///
    /// # Errors
    /// Exit code 3 for a frame that cannot be read.
    pub fn workload(&mut self, number: usize) -> Result<FrameWorkload, Failure> {
        let TraceFrame { label, frame } = self.source.frame(number)?;
        let workload = bin(&frame, self.simulator.geometry());
        if let Some(loaded) = self.machine() {
            fits(&workload, &loaded.machine).map_err(|breach| refused(breach, &label.name))?;
        }
        Ok(workload)
    }
}

/// A simulated frame, what its heatmap needs, and the same frame on other machines.
struct Done {
    report: FrameReport,
    tiles: TileLoad,
    doubled: Option<Vec<Cost>>,
    window: Option<FrameReport>,
}

impl Engine for TraceEngine {
    fn facts(&self) -> Facts {
        self.facts.clone()
    }

    fn frames(&mut self, each: &mut EachFrame<'_>) -> Result<(), Failure> {
        let (simulator, window) = (&self.simulator, self.window.as_ref());
        let experiment = &self.experiment;
        let mut gathered = experiment.clone();
        let models = &mut self.models;
        let each = |done: Done| {
            if let Some(others) = &done.doubled {
                gathered.add(&done.report, others);
            }
            if let Some(window) = &done.window {
                gather_models(models, &done.report, window);
            }
            let mut tiles = Some(done.tiles);
            let mut take = || tiles.take().expect("the tiles of a frame are asked for once");
            match each(done.report, &mut take) {
                ControlFlow::Continue(()) => ControlFlow::Continue(()),
                ControlFlow::Break(()) => ControlFlow::Break(()),
            }
        };
        let on = |frame, lists: &mut Lists| one_frame(simulator, experiment, window, frame, lists);
        if simulator.is_sequential() {
            let mut lists = Lists::default();
            self.source.in_sequence(|frame| on(frame, &mut lists), each)?;
        } else {
            self.source.in_order(|frame| on(frame, &mut Lists::default()), each)?;
        }
        self.experiment = gathered;
        Ok(())
    }

    fn timeline(&mut self, folder: &RunFolder, asked: &Asked) -> Result<Option<String>, Failure> {
        let workload = self.workload(asked.frame)?;
        let Some(loaded) = self.machine() else { return Ok(None) };
        timeline::write(folder, asked, &loaded.machine, &workload)
    }

    fn dram_requests(&mut self, sink: &mut dram_dump::Sink<'_>) -> Result<(), Failure> {
        let workload = self.workload(self.source.range().start)?;
        let Some(loaded) = self.machine() else {
            let what = "--dump-dram: the paper model makes no requests; use --model cycle";
            return Err(Failure::new(Exit::Usage, what));
        };
        observed(&workload, &loaded.machine, &mut Requests(sink));
        Ok(())
    }

    fn extras(&mut self) -> Extras {
        let what_if = std::mem::take(&mut self.experiment).finish();
        let (n, sums) = self.models;
        let mean = |sum: f64| sum / f64::from(n);
        let dram_models = (n > 0).then(|| DramModels {
            window_ms: mean(sums.window_ms),
            banked_ms: mean(sums.banked_ms),
            window_bytes: mean(sums.window_bytes),
            banked_bytes: mean(sums.banked_bytes),
        });
        Extras { what_if, dram_models }
    }
}

/// Hands on the requests to the DRAM.
struct Requests<'a, 'b>(&'a mut dram_dump::Sink<'b>);

impl Observer for Requests<'_, '_> {
    const WANTS_REQUESTS: bool = true;

    fn span(&mut self, _: Span) {}

    fn request(&mut self, is_write: bool, address: u64, bytes: u64) {
        (self.0)(is_write, address, bytes);
    }
}

fn gather_models((n, sums): &mut (u32, DramModels), banked: &FrameReport, window: &FrameReport) {
    let moved = |report: &FrameReport| {
        let Some(timing) = report.timing() else { return 0.0 };
        let bursts = |c: &powergs_core::accel::DramCommands| {
            c.stages.iter().map(|s| s.reads + s.writes).sum::<u64>() * c.burst_bytes
        };
        timing.dram.commands.as_ref().map_or(0, bursts) as f64
    };
    *n += 1;
    sums.banked_ms += cost(banked).frame_time_ms;
    sums.window_ms += cost(window).frame_time_ms;
    sums.banked_bytes += moved(banked);
    sums.window_bytes += moved(window);
}

fn one_frame(
    simulator: &Simulator,
    experiment: &Experiment,
    window: Option<&Variant>,
    TraceFrame { label, frame }: TraceFrame,
    lists: &mut Lists,
) -> Result<Done, Failure> {
    let number = label.frame;
    let workload = bin(&frame, simulator.geometry());
    // No variant has another geometry, cache, key or tile order: what was measured holds for all.
    let measured = simulator.measured(&workload, lists);
    let on = |variant: &Variant| {
        let (machine, prices) = (&variant.machine, &variant.prices);
        simulate_measured(label.clone(), &workload, &measured, machine, prices)
            .map_err(|breach| refused(breach, &label.name))
    };
    let doubled = if experiment.wants(number) {
        let costs = experiment.doubled.iter().map(|d| on(&d.variant).map(|r| cost(&r)));
        Some(costs.collect::<Result<Vec<_>, Failure>>()?)
    } else {
        None
    };
    let window = window.map(on).transpose()?;
    let report = simulator.report(label.clone(), &workload, &measured)?;
    let picture = frame.preview.map(|p| Picture { width: p.width, height: p.height, rgb: p.rgb });
    Ok(Done { report, tiles: TileLoad::of(number, &workload, picture), doubled, window })
}

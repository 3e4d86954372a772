//! Hand-made runs: plausible numbers whose accounting closes, without a simulator.

use powergs_base::quantity::{Hertz, Picojoules, SquareMillimetres};
use powergs_core::flow::Task;
use powergs_core::flow::over::pixels::PixelSummary;
use powergs_core::flow::over::second_eye::StereoSummary;
use powergs_core::flow::steps::StepCycles;
use powergs_core::flow::tile_wise::gradients::{ADDITIONS, FOUND_SUMS};
use powergs_core::flow::tile_wise::{cache, measures};
use powergs_core::kernel::{BufferUse, DramUse, FrameTiming, Histogram, UnitCycles};
use powergs_core::machine::MASTERS;
use powergs_core::run::Input;
use powergs_core::sim::{
    CycleReport, FoveaSummary, Foveal, FrameReport, Model, ModelReport, PaperReport, RegionReport,
    StageBytes,
};
use powergs_core::stage::{Measured, Stall, buffer_id, hardware, sram_read, stage_id, work_id};
use powergs_dram::{DramCommands, StageCommands};
use powergs_energy::action::{ActionCounts, BufferId, Phase};
use powergs_energy::{Area, Component, EnergyBreakdown, Standby};
use powergs_frame::splat::{Counters, FoveaCounters};
use powergs_scene::ShDegree;
use powergs_study::findings::cost::Cost;
use powergs_study::findings::limits::not_modelled;
use powergs_study::findings::masters::MastersAsked;
use powergs_study::findings::roofline::Roofline;
use powergs_study::findings::what_if::{Skipped, Step};
use powergs_study::findings::{Picture, TileLoad, WhatIf};
use powergs_study::run_record::{Experiments, Facts, MachineFacts, Run, Shown, TraceFacts};

use powergs_core::workload::cache::CacheReplay;
use powergs_core::workload::reuse::ReuseSummary;

/// Leakage, DRAM background and refresh, watts.
const STATIC_W: [f64; 3] = [0.06, 0.025, 0.005];

/// A chip of nothing but what is neither unit nor buffer.
pub fn area_of(rest: SquareMillimetres) -> Area {
    let nothing = |areas: Vec<_>| areas.iter().map(|_| SquareMillimetres(0.0)).collect();
    let Area { units, buffers, .. } = area();
    Area { units: nothing(units), buffers: nothing(buffers), rest, ..Area::default() }
}

fn area() -> Area {
    let mm2 = SquareMillimetres;
    // Those of other dataflows have none.
    let all = |own: &[f64], count: usize| {
        (0..count).map(|i| mm2(own.get(i).copied().unwrap_or_default())).collect()
    };
    Area {
        units: all(&[0.68, 0.002, 0.05, 1.5], hardware().units().count()),
        buffers: all(&[0.06, 0.15, 0.29, 0.64, 0.09], hardware().buffers().count()),
        rest: mm2(0.35),
        phy: mm2(8.0),
        controllers: mm2(0.8),
    }
}

/// A frame of about `millions` of cycles at 1 GHz.
pub fn frame(number: usize, millions: f64) -> FrameReport {
    let cycles = (millions * 1e6) as u64;
    let n = cycles / 10;
    let mut actions = ActionCounts::default();
    actions.charge(Phase::Preprocessing, work_id("cull"), 250_000);
    actions.charge(Phase::Sorting, work_id("compare-exchange"), 3 * n);
    actions.charge(Phase::Rendering, work_id("alpha"), 40 * n);
    actions.charge(Phase::Rendering, sram_read(buffer_id("feature")), 60 * n);
    let mut energy = EnergyBreakdown::default();
    let mj = |x: f64| Picojoules(x * 1e9 * millions);
    energy.add(Phase::Preprocessing, Component::Dram, mj(0.05));
    energy.add(Phase::Preprocessing, Component::Sram, mj(0.01));
    energy.add(Phase::Preprocessing, Component::Flop, mj(0.02));
    energy.add(Phase::Sorting, Component::Dram, mj(0.08));
    energy.add(Phase::Sorting, Component::Sram, mj(0.015));
    energy.add(Phase::Sorting, Component::Flop, mj(0.01));
    energy.add(Phase::Rendering, Component::Dram, mj(0.12));
    energy.add(Phase::Rendering, Component::Sram, mj(0.04));
    energy.add(Phase::Rendering, Component::Flop, mj(0.2));
    energy.add(Phase::Standby, Component::Leakage, mj(0.06));
    energy.add(Phase::Standby, Component::Background, mj(0.025));
    energy.add(Phase::Standby, Component::Refresh, mj(0.005));
    FrameReport {
        frame: number,
        name: format!("view_{number:04}"),
        eye: None,
        eyes: 1,
        sh_degree: Some(ShDegree::MAX),
        counters: counters(n),
        stages: [bytes(5 * n, n, 12 * n), bytes(2 * n, 0, 9 * n), bytes(8 * n, n, 60 * n)],
        actions,
        energy,
        standby: Standby { running_w: STATIC_W, idle_w: STATIC_W },
        area: Some(area()),
        phy_standby_w: 0.012,
        display_w: Some(0.9 + 0.01 * (number % 10) as f64),
        model: ModelReport::Cycle(Box::new(CycleReport {
            timing: timing(cycles),
            clock: Hertz(1e9),
            task: Task::RENDER,
            latency: cycles,
            unwritten_bytes: 0,
            executed_evaluations: 64 * n,
            live_evaluations: 50 * n,
            measured: measured(n),
            fovea: Some(Foveal {
                summary: fovea(n),
                regions: std::array::from_fn(|k| region(n, k as u64)),
            }),
        })),
    }
}

/// What only the `cycle` model knows of a frame.
pub fn cycle(frame: &mut FrameReport) -> &mut CycleReport {
    match &mut frame.model {
        ModelReport::Cycle(cycle) => cycle,
        ModelReport::Paper(_) => panic!("a frame of the `paper` model"),
    }
}

/// As [`frame`], with the order of the frame before.
pub fn reusing_frame(number: usize, millions: f64) -> FrameReport {
    let mut frame = frame(number, millions);
    let n = frame.counters.intersecting_points;
    let (new, gone, out_of_order) = (n / 5, n / 4, n / 90);
    let (old_lists, keeping, rank_shift_p99, missing) = (900, 700, 3, 0);
    let reuse = ReuseSummary {
        old_lists,
        keeping,
        kept: n,
        new,
        gone,
        rank_shift_p99,
        out_of_order,
        missing,
    };
    let cycle = cycle(&mut frame);
    cycle.measured.extend(measures::measured(&reuse));
    cycle.timing.dram.master_bytes = [64; MASTERS.len()];
    frame
}

/// Something of everything that stages measure, but of a kept order.
fn measured(n: u64) -> Measured {
    let mut all = Measured::of(&[
        (&measures::NEIGHBOURS, 2 * n),
        (&measures::DISORDERED, n / 100),
        (&measures::EQUAL_KEYS, n / 50),
        (&measures::INVERSIONS, n / 40),
    ]);
    let replay = CacheReplay { loads: n + n / 2, hit_loads: n, ..CacheReplay::default() };
    all.extend(cache::measured(&replay));
    let pixels = PixelSummary {
        pixels: 10 * n,
        rendered: 4 * n,
        taken: 5 * n,
        filled: n,
        lookups: 4 * n,
        hits: n,
    };
    all.extend(pixels.measured());
    all.extend(StepCycles([n, 3 * n, n, 2 * n]).measured());
    let stereo = StereoSummary {
        handed_on: n,
        entries: 2 * n,
        kept: n / 2,
        blends: 9 * n,
        lost_blends: n / 9,
        pixels: 3 * n,
        changed_pixels: n / 300,
        cut_off_pixels: n / 900,
        largest_disparity: 41.5,
    };
    all.extend(stereo.measured());
    all.extend(Measured::of(&[(&ADDITIONS, 4 * n), (&FOUND_SUMS, n)]));
    all
}

fn fovea(n: u64) -> FoveaSummary {
    FoveaSummary {
        gaze: [0.25, 0.75],
        tiles: 8160,
        blending_tiles: 2500,
        counters: FoveaCounters {
            lookups: 4 * n,
            prepared_published: n / 3,
            points_by_levels: [n / 4, n / 8, n / 16, n / 16],
            extra_alpha: 3 * n,
            blends_2: n / 2,
        },
    }
}

fn region(n: u64, k: u64) -> RegionReport {
    RegionReport {
        tiles: 2040,
        entries: n / (k + 1),
        cycles: 3 * n / (k + 1),
        energy_pj: 1e4 * n as f64 / (k + 1) as f64,
    }
}

fn counters(n: u64) -> Counters {
    Counters {
        points: 250_000,
        survivors: 200_000,
        tile_pairs: 2 * n,
        intersecting_points: n,
        fetched_points: n / 2,
        obb_tests: 3 * n,
        obb_prepared: n / 3,
        tile_loads: n + n / 2,
        alpha_evaluations: 40 * n,
        blends: 12 * n,
    }
}

fn bytes(read: u64, write: u64, sram: u64) -> StageBytes {
    StageBytes { read, write, sram, flops: 0 }
}

/// Waits for records, lists, spilled keys, features, input, output, banks as accounts have them.
pub fn stalls(all: [u64; 7]) -> [u64; Stall::MOST] {
    let own = ["records", "list", "spill", "features"].map(Stall::of);
    let causes = own.into_iter().chain([Stall::INPUT, Stall::OUTPUT, Stall::BANK]);
    let mut stalls = [0; Stall::MOST];
    causes.zip(all).for_each(|(cause, cycles)| stalls[cause.index()] = cycles);
    stalls
}

fn timing(cycles: u64) -> FrameTiming {
    let unit = |key: &str, instances: u32, shares: [f64; 4]| {
        let all = cycles * u64::from(instances);
        let part = |share: f64| (all as f64 * share) as u64;
        let [busy, dram, input, output] = shares.map(part);
        let idle = all - busy - dram - input - output;
        UnitCycles {
            unit: stage_id(key),
            instances,
            busy,
            stalls: stalls(match key {
                "ccu" => [dram, 0, 0, 0, input, output, 0],
                "qsu" | "bsu" => [0, dram, 0, 0, input, output, 0],
                _ => [0, 0, 0, dram, input, output, 0],
            }),
            idle,
        }
    };
    FrameTiming {
        frame: cycles,
        preprocessing_end: cycles / 4,
        units: vec![
            unit("ccu", 4, [0.10, 0.12, 0.0, 0.01]),
            unit("qsu", 8, [0.05, 0.14, 0.02, 0.20]),
            unit("bsu", 4, [0.22, 0.02, 0.11, 0.30]),
            unit("vru", 64, [0.61, 0.08, 0.04, 0.003]),
            unit("pxu", 1, [0.03, 0.01, 0.0, 0.01]),
            unit("ltu", 1, [0.02, 0.01, 0.0, 0.0]),
            unit("gru", 4, [0.02, 0.01, 0.0, 0.02]),
            unit("colour", 4, [0.02, 0.0, 0.0, 0.0]),
        ],
        dram: DramUse {
            read_bytes: 15 * (cycles / 10),
            write_bytes: 2 * (cycles / 10),
            requests_issued: cycles / 700,
            requests_served: cycles / 700,
            busy_cycles: cycles / 3,
            master_bytes: [0; 3],
            commands: Some(commands(cycles / 10)),
        },
        buffers: buffers(cycles),
        tile_cycles: tile_cycles(cycles),
    }
}

/// Of every hundred bursts of rendering 41 open a row.
fn commands(n: u64) -> DramCommands {
    let stage = |reads, writes, activates| StageCommands { reads, writes, activates };
    DramCommands {
        burst_bytes: 32,
        stages: [
            stage(n / 5, n / 20, n / 50),
            stage(n / 10, 0, n / 40),
            stage(3 * n / 10, n / 20, 41 * n * 35 / 10_000),
        ],
        precharges: n / 6,
        refreshes: n / 400,
        bank_refreshes: 0,
    }
}

fn buffers(cycles: u64) -> Vec<BufferUse> {
    let sizes = [8u64, 32, 64, 128, 16];
    let held = |(buffer, (i, kib)): (BufferId, (usize, u64))| BufferUse {
        buffer,
        capacity: kib << 10,
        peak: (kib << 10) * (5 + i as u64) / 10,
        byte_cycles: u128::from(kib << 10) * u128::from(cycles) / (3 + i as u128),
        filled: 3 * cycles,
        consumed: 3 * cycles - cycles / 8,
        discarded: cycles / 8,
    };
    let filled = hardware().buffers().filter(|(_, facts)| facts.fills).map(|(id, _)| id);
    filled.zip(sizes.into_iter().enumerate()).map(held).collect()
}

/// Two thousand tiles around a thousandth of the frame, some of none and a few long ones.
fn tile_cycles(cycles: u64) -> Histogram {
    let mut bins = Histogram::EMPTY;
    for i in 0..2000u64 {
        let spread = (i * 7919) % 1000;
        let long = if i % 97 == 0 { 8 } else { 1 };
        bins.count(if i % 40 == 0 { 0 } else { cycles * (spread + 60) * long / 1_000_000 });
    }
    bins
}

/// A frame of the `paper` model.
pub fn paper_frame(number: usize, millions: f64) -> FrameReport {
    let mut frame = frame(number, millions);
    frame.model = ModelReport::Paper(PaperReport { fovea: frame.fovea().copied() });
    let mut energy = EnergyBreakdown::default();
    for stage in Phase::WORK {
        for component in [Component::Dram, Component::Sram, Component::Flop] {
            energy.add(stage, component, frame.energy.part(stage, component));
        }
    }
    frame.energy = energy;
    frame.stages.iter_mut().for_each(|s| s.flops = 1_000_000);
    frame.actions = ActionCounts::default();
    frame.standby = Standby::default();
    frame.area = None;
    frame.phy_standby_w = 0.0;
    frame.display_w = None;
    frame
}

/// What went into the runs of these tests.
pub fn facts(frames: usize) -> Facts {
    let shown = Shown { eyes: 1, width: 979, height: 546 };
    Facts {
        model: Model::Cycle,
        display_fps: 60.0,
        latency_ms: None,
        trace: TraceFacts { name: "garden".into(), frames, shown },
        machine: MachineFacts {
            name: "gscore".into(),
            task: Task::RENDER,
            energy_table: "gscore-28nm".into(),
            node_nm: Some(28.0),
            clock_hz: Some(1e9),
            dram_peak_gb_s: Some(51.2),
            dram_model: None,
            dram_byte_price: Some("powergs".into()),
            masters: MastersAsked::default(),
            left_out: not_modelled(),
            roofline: Some(roofline()),
            sources: vec!["A5".into(), "gscore".into()],
            doubts: Vec::new(),
        },
        inputs: vec![Input {
            role: "trace",
            name: "garden.bin".into(),
            bytes: 1_234_567,
            xxh3: 0x0123_4567_89ab_cdef_0011_2233_4455_6677,
        }],
        configuration: toml::from_str("[machine]\nclock = \"1 GHz\"\n[machine.vru]\ncores = 4\n")
            .expect("a table"),
    }
}

/// A run over frames of these millions of cycles.
pub fn run(millions: &[f64]) -> Run {
    let frames: Vec<_> = millions.iter().enumerate().map(|(i, &m)| frame(i, m)).collect();
    Run {
        facts: facts(frames.len()),
        frames,
        tiles: Some(tiles(979, 546, 16)),
        experiments: Experiments { what_if: Some(what_if()), ..Experiments::default() },
    }
}

/// 47 operations a cull, 13 an alpha; nothing else counts.
fn roofline() -> Roofline {
    let mut flops = vec![0; hardware().actions().count()];
    flops[work_id("cull").index()] = 47;
    flops[work_id("alpha").index()] = 13;
    flops[work_id("compare-exchange").index()] = 1;
    let units = [("CCU", 1.9e12), ("QSU + BSU", 0.4e12), ("VRU", 1.5e12)];
    let units = units.map(|(name, peak)| (name.to_owned(), peak));
    Roofline { operations: flops, units, dram_bytes_s: 51.2e9, overlaps: false }
}

/// Three steps: one that helps, one that does not, one that is no machine.
pub fn what_if() -> WhatIf {
    let cost = |frame_time_ms, energy_pj, area: f64| Cost {
        frame_time_ms,
        energy_pj,
        power_w: 0.1 + energy_pj * 60e-12,
        area_mm2: Some(8.0 + area),
    };
    let step = |resource, sets: &[&str], cost, assumptions| Step {
        resource,
        sets: sets.iter().map(|s| (*s).to_owned()).collect(),
        cost,
        assumptions,
    };
    let channels = ["dram.channels=16"];
    let steps = vec![
        step("gsu.qsu-per-core", &["gsu.qsu-per-core=4"], cost(11.0, 6.93e9, 4.04), &["A23"]),
        step("dram.channels", &channels, cost(8.36, 6.8e9, 12.03), &["A4"]),
        step("vru.units-per-core", &["vru.units-per-core=32"], cost(10.1, 6.9e9, 5.9), &["A26"]),
    ];
    let reason = "`buffers.feature.capacity` = 256 KiB is too small".to_owned();
    let skipped = vec![Skipped { resource: "vru.cores", reason }];
    WhatIf::new(vec![4, 12, 20], cost(11.0, 6.93e9, 4.03), steps, skipped)
}

/// The standard run: 24 frames of 4 to 20 ms, two of them over the deadline.
pub fn garden() -> Run {
    let wave = |i: usize| 11.0 + 6.8 * (i as f64 / 24.0 * std::f64::consts::TAU).sin();
    run(&(0..24).map(wave).collect::<Vec<_>>())
}

/// The same trace in the `paper` model.
pub fn paper() -> Run {
    let mut run = garden();
    run.facts.model = Model::Paper;
    run.experiments = Experiments::default();
    run.facts.machine = MachineFacts {
        name: "paper".into(),
        task: Task::RENDER,
        energy_table: "paper".into(),
        node_nm: None,
        clock_hz: None,
        dram_peak_gb_s: None,
        dram_model: None,
        dram_byte_price: Some("powergs".into()),
        masters: MastersAsked::default(),
        left_out: not_modelled(),
        roofline: None,
        sources: Vec::new(),
        doubts: Vec::new(),
    };
    run.frames = run.frames.iter().map(|f| paper_frame(f.frame, 5.2)).collect();
    run
}

/// Lists that are long in the middle, over a picture of rings.
pub fn tiles(width: u32, height: u32, tile: u32) -> TileLoad {
    let (tiles_x, tiles_y) = (width.div_ceil(tile), height.div_ceil(tile));
    let far = |x: u32, y: u32, w: u32, h: u32| {
        let dx = f64::from(x) / f64::from(w) - 0.5;
        let dy = f64::from(y) / f64::from(h) - 0.5;
        (dx * dx + dy * dy).sqrt()
    };
    let entry = |i: u32| {
        let d = far(i % tiles_x, i / tiles_x, tiles_x, tiles_y);
        (1800.0 * (-6.0 * d * d).exp()) as u32 + (i * 7919) % 90
    };
    let (w, h) = (160, 90);
    let pixel = |i: u32| [((far(i % w, i / w, w, h) * 60.0).sin() * 100.0 + 128.0) as u8; 3];
    TileLoad {
        frame: 6,
        width,
        height,
        tile,
        tiles_x,
        entries: (0..tiles_x * tiles_y).map(entry).collect(),
        picture: Some(Picture { width: w, height: h, rgb: (0..w * h).flat_map(pixel).collect() }),
    }
}

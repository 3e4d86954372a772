//! Runs that were made elsewhere: time against an oracle, laws, and files that are refused.

use std::fmt::Write as _;

use powergs_base::config::embedded::{ENERGY, find};
use powergs_core::flow::recorded::{self, RecordedRun, RecordedSpec, STREAMS};
use powergs_core::flow::{FlowOutcome, FrameTask};
use powergs_core::kernel::dram::Dram;
use powergs_core::kernel::memory::Ranges;
use powergs_core::kernel::{Calibration, Halt, Memo};
use powergs_core::machine::Machine;
use powergs_core::sim::contract::{Trial, broken};
use powergs_core::sim::{self, cost};
use powergs_core::stage::{EnergyTable, Stall, hardware};
use powergs_frame::trace::Frame;
use rand::RngExt;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::oracle_memory;
use crate::pipeline::slow_or;
use crate::workload::support::{dense_frame, small_frame};

pub const MACHINE: &str = r#"
name = "elsewhere"
description = "for tests"
dataflow = "recorded"
clock = "1 GHz"
energy = "resident-28nm"

[recorded]
file = "run.csv"
outstanding = 8

[recorded.units.raster]
count = 2
parts.lanes = 16

[recorded.buffers]
raster-in = { capacity = "4 KiB", word = "32 B", banks = 1, ports = "1r1w" }

[dram]
model = "bandwidth"
efficiency = 0.8
latency = "100 ns"
device = "lpddr4-3200-x16x2"
channels = 2
mapping = "RoBaCoCh"
controller-latency = "40 ns"
"#;

/// A run of a frame that nobody made.
fn made_up(frame: &Frame, dice: &mut Pcg64Mcg) -> String {
    let (id, cycles) = (frame.id(), dice.random_range(50..2000_u64));
    let busy = dice.random_range(0..=2 * cycles);
    let mut text = format!(
        "frame,what,count,cycle,needed,address,phase\n\
         {id:016x},cycles,{cycles}\n{id:016x},busy.raster,{busy}\n\
         {id:016x},alpha,{},,,,\n{id:016x},sram-read.raster-in,4096,,,,sorting\n",
        dice.random_range(0..10_000),
    );
    for _ in 0..dice.random_range(0..200) {
        let what = ["dram-read", "dram-write"][dice.random_range(0..2)];
        let phase = ["", "preprocessing", "sorting", "rendering"][dice.random_range(0..4)];
        let cycle = dice.random_range(0..cycles);
        let needed = match dice.random_range(0..3) {
            0 => String::new(),
            1 => dice.random_range(cycle + 1..=cycles).to_string(),
            _ => (cycle + 1).to_string(),
        };
        let bytes = dice.random_range(1..400);
        let address = dice.random_range(0..1 << 22);
        writeln!(text, "{id:016x},{what},{bytes},{cycle},{needed},{address},{phase}")
            .expect("a text");
    }
    text
}

fn machine(sets: &[&str], run: &str) -> Result<Machine, String> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let mut machine = Machine::parse_with(MACHINE, &sets).map_err(|e| e.to_string())?;
    let run = run.as_bytes().to_vec();
    machine
        .flow()
        .attach(&mut machine, &mut |_| Ok(Box::new(std::io::Cursor::new(run.clone()))))?;
    Ok(machine)
}

fn timed(machine: &Machine, frame: &Frame, memo: &Memo) -> FlowOutcome {
    let flow = machine.flow();
    let work = flow.work_key(machine).prepare(frame);
    sim::time(&FrameTask::first(machine, &*work, memo)).expect("it fits").outcome
}

/// The run cycle by cycle, as the rules say it: how long it takes, and how long it stands still.
fn stepped(machine: &Machine, frame: &Frame, calibration: Option<&Calibration>) -> [u64; 2] {
    let spec: &RecordedSpec = machine.of_type();
    let run = &spec.run.get().expect("it is read").frames[&frame.id()];
    let flat = match calibration {
        Some(calibration) => calibration.dram(),
        None => Dram::new(&machine.dram, machine.dram_peak(), machine.clock, &STREAMS),
    };
    let end = run.requests.iter().map(|r| r.address + u64::from(r.bytes)).max().unwrap_or(0);
    let mut memory = oracle_memory::Memory::new(Ranges { end }, &STREAMS, machine, flat);
    let mut tickets = vec![None; run.requests.len()];
    let mut window: Vec<usize> = Vec::new();
    let (mut asked, mut clock) = (0, 0);
    for now in 0..10_000_000 {
        let done = |ticket: Option<usize>| ticket.is_some_and(|t| memory.is_done(t, now));
        let needs = |i: &usize| run.requests[*i].needed == clock;
        let mut goes_on = (0..asked).filter(needs).all(|i| done(tickets[i]));
        while goes_on && asked < run.requests.len() && run.requests[asked].cycle == clock {
            if window.len() == spec.outstanding as usize {
                if !tickets[window[0]].is_some_and(|t| memory.is_done(t, now)) {
                    goes_on = false;
                    break;
                }
                window.remove(0);
            }
            let request = run.requests[asked];
            let (key, place) =
                (STREAMS.key(request.stream), [request.address, u64::from(request.bytes)]);
            tickets[asked] = Some(match STREAMS.is_write(request.stream) {
                true => memory.write(now, key, place[1], place),
                false => memory.read(now, key, place[1], place),
            });
            window.push(asked);
            asked += 1;
        }
        if clock == run.cycles {
            goes_on = goes_on
                && window.iter().all(|i| tickets[*i].is_some_and(|t| memory.is_done(t, now)));
            if goes_on {
                return [now, now - clock];
            }
        }
        clock += u64::from(goes_on);
        memory.tick(now);
    }
    panic!("it does not end");
}

/// Cases, and those of `RUN_SLOW_TESTS=1`.
const CASES: [u64; 2] = [300, 3000];

#[test]
fn runs_equal_the_cycle_by_cycle_oracle() {
    let mut waited = [0; 2];
    for seed in 0..slow_or(CASES) {
        let mut dice = Pcg64Mcg::seed_from_u64(seed);
        let frame = small_frame(seed % 4);
        let text = made_up(&frame, &mut dice);
        let model = ["bandwidth", "calibrated", "banked"][dice.random_range(0..3)];
        let outstanding = [1, 2, 8, 64][dice.random_range(0..4)];
        let clock = ["300 MHz", "1 GHz", "1.7 GHz"][dice.random_range(0..3)];
        let sets = [
            format!("dram.model={model}"),
            format!("recorded.outstanding={outstanding}"),
            format!("clock={clock}"),
        ];
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        let machine = machine(&sets, &text).expect("a machine");
        let memo = Memo::default();
        let outcome = timed(&machine, &frame, &memo);
        let run = machine.of_type::<RecordedSpec>().run.get().expect("read");
        let calibration =
            recorded::calibration(&machine, &run.frames[&frame.id()], &memo, Halt::NEVER);
        let [end, still] = stepped(&machine, &frame, calibration.as_deref());
        assert_eq!(outcome.timing.frame, end, "seed {seed}: {sets:?}\n{text}");
        let unit = &outcome.timing.units[0];
        assert_eq!(unit.stalls.iter().sum::<u64>(), 2 * still, "seed {seed}");
        let busy = run.frames[&frame.id()].busy.values().sum::<u64>();
        assert_eq!(unit.busy, busy, "seed {seed}");
        let features = unit.stalls[Stall::of("features").index()];
        waited[0] += u64::from(features > 0);
        waited[1] += u64::from(unit.stalls[Stall::OUTPUT.index()] > 0);
    }
    assert!(waited.iter().all(|n| *n > slow_or(CASES) / 10), "{waited:?}");
}

#[test]
fn they_keep_the_laws() {
    let frames = [small_frame(0), dense_frame(1)];
    let mut dice = Pcg64Mcg::seed_from_u64(7);
    let runs: Vec<String> = frames.iter().map(|frame| made_up(frame, &mut dice)).collect();
    let second = runs[1].lines().skip(1).collect::<Vec<_>>().join("\n");
    let both = format!("{}{second}\n", runs[0]);
    let trial = Trial {
        machine: MACHINE,
        files: &[("run.csv", both.as_bytes())],
        variants: &[
            &[],
            &["recorded.outstanding=1", "dram.model=calibrated"],
            &["dram.model=banked", "clock=2 GHz"],
        ],
        frames: &frames,
        settled: &[],
        slack: 0.0,
        // What a frame is and how many are under way is said of the run, and not found by it.
        idle_keys: &["recorded.task", "recorded.under-way"],
    };
    assert_eq!(broken(&trial), Vec::<String>::new());
}

#[test]
fn what_a_frame_of_a_run_is_is_said() {
    let frame = small_frame(0);
    let text = made_up(&frame, &mut Pcg64Mcg::seed_from_u64(7));
    let task = |sets: &[&str]| {
        let machine = machine(sets, &text).expect("a machine");
        let flow = machine.flow();
        (flow.task(&machine).name(), flow.under_way(&machine))
    };
    assert_eq!(task(&[]), ("render".to_owned(), 1));
    let sets = ["recorded.task=track, 1 pixel in 256", "recorded.under-way=2"];
    assert_eq!(task(&sets), ("track, 1 pixel in 256".to_owned(), 2));
    let refused = machine(&["recorded.task=paint"], &text).expect_err("no task");
    assert!(refused.to_string().contains("what comparisons call a task"), "{refused}");
    // A picture is there no sooner than the next one may begin.
    let refused = machine(&["recorded.under-way=0"], &text).expect_err("less than an interval");
    assert!(refused.to_string().contains("under-way"), "{refused}");
}

#[test]
fn what_the_file_says_is_priced() {
    let frame = small_frame(0);
    let id = frame.id();
    let text = format!(
        "what,frame,count,address,cycle,needed\n\
         cycles,{id:016x},1000\nalpha,{id:016x},64\nsram-write.raster-in,{id:016x},32\n\
         dram-read,{id:016x},64,4096,0,500\ndram-write,{id:016x},32,0,999,\n"
    );
    let machine = machine(&[], &text).expect("a machine");
    let outcome = timed(&machine, &frame, &Memo::default());
    let count =
        |key: &str| outcome.actions.total(hardware().action_called(key).expect("an action"));
    let counts = ["alpha", "sram-write.raster-in", "dram-read", "dram-write", "clock.raster"];
    assert_eq!(counts.map(count), [64, 32, 64, 32, 2000 + 2 * (outcome.timing.frame - 1000)]);
    // The read is there long before it is needed; the last bytes are written behind the run.
    assert!((1001..1010).contains(&outcome.timing.frame), "{}", outcome.timing.frame);
    let table = find(ENERGY, "resident-28nm");
    let table = EnergyTable::parse(table.expect("it comes along")).expect("it is whole");
    let prices = cost::prices(&table, &machine).expect("everything has a price");
    // Two engines of 16 lanes, as those of `resident-28nm` are.
    let area = prices.area.expect("it has areas");
    let raster = hardware().units().position(|(_, unit)| unit.key == "raster").expect("a unit");
    assert!((area.units[raster].0 - 2.0 * 0.452_48).abs() < 1e-9, "{:?}", area.units[raster]);
    let bank = machine.inventory().memories.iter().filter(|memory| memory.banks > 0).count();
    assert_eq!(bank, 1);
}

#[test]
fn what_is_wrong_with_a_file_is_said_with_its_line() {
    let head = "frame,what,count,cycle,needed,address";
    let id = format!("{:016x}", small_frame(0).id());
    let cases: [(&str, &str); 19] = [
        ("", "`frame` is missing"),
        ("frame,what,number\n", "no column `number`"),
        ("frame,what,count,what\n", "the column `what` is there twice"),
        ("frame,what,count\n", "it has no frames"),
        ("frame,what,count\n12,cycles,10\n", "line 2: `frame` must be the `id` of a frame"),
        ("HEAD\nID,cycles,0\n", "line 2: `cycles` must be above 0"),
        ("HEAD\nID,cycles,ten\n", "line 2: `count` must be a whole number up to"),
        ("HEAD\nID,cycles,5\nID,cycles,5\n", "line 3: `cycles` of frame"),
        ("HEAD\nID,alpha,5\nID,alpha,5\n", "line 3: `alpha` of frame"),
        ("HEAD\nID,alpha,5\n", "it has no `cycles`"),
        ("HEAD\nID,alhpa,5\n", "no action `alhpa`; did you mean `alpha`?"),
        ("HEAD\nID,clock.raster,5\n", "`clock.raster` follows from `cycles`"),
        ("HEAD\nID,dram-read,0,1,,0\n", "a request of 0 bytes"),
        ("HEAD\nID,dram-read,8,,,0\n", "`cycle` must be a whole number up to"),
        ("HEAD\nID,dram-read,8,5,5,0\n", "it is needed in cycle 5, and made in cycle 5"),
        ("HEAD\nID,cycles,4\nID,dram-read,8,5,,0\n", "a request of cycle 5 lies behind its end"),
        ("HEAD\nID,cycles,4\nID,merged-key,1\n", "no units that do it: add one of order"),
        ("HEAD\nID,cycles,4\nID,sram-read.tail-in,1\n", "no such buffer: add it to"),
        ("HEAD\nID,cycles,4\nID,busy.raster,9\n", "2 units have 8 cycles in its 4"),
    ];
    for (text, wanted) in cases {
        let text = text.replace("HEAD", head).replace("ID", &id);
        let said = machine(&[], &text).expect_err(&text);
        assert!(said.contains(wanted), "{text:?}: {said}");
    }
    let long = format!("{head}\n{id},cycles,4,,,,,,9\n");
    assert!(RecordedRun::read(long.as_bytes()).is_err_and(|e| e.contains("line 2: 9 cells")));
    // Nothing of a file without lines, or with quotes around them, is kept in memory.
    for start in ["", "\""] {
        let begins = format!("{head}\n{start}");
        let endless = std::io::Read::chain(begins.as_bytes(), std::io::repeat(b'7'));
        let said = RecordedRun::read(endless).expect_err("no line ends");
        assert!(said.contains("a line of more than 4096 bytes"), "{said}");
    }
}

#[test]
fn what_the_run_was_made_with_stays() {
    let frame = small_frame(0);
    let text = format!("frame,what,count\n{:016x},cycles,10\n", frame.id());
    for set in ["recorded.units.raster.count=3", "recorded.file=other.csv"] {
        let said = machine(&[set], &text).expect_err(set);
        assert!(said.contains("says what the run was made with"), "{said}");
    }
    let base = machine(&[], &text).expect("a machine");
    let mut slower =
        Machine::parse(&base.to_toml().replace("\"1 GHz\"", "\"500 MHz\"")).expect("one");
    slower.keep(&base).expect("a variant");
    assert_eq!(timed(&slower, &frame, &Memo::default()).timing.frame, 10);
    let mut other = Machine::parse(&base.to_toml().replace("count = 2", "count = 4")).expect("one");
    assert!(other.keep(&base).is_err_and(|e| e.contains("recorded.units")));
    // Another frame is another run.
    let other = small_frame(1);
    let work = base.flow().work_key(&base).prepare(&other);
    let said = sim::time(&FrameTask::first(&base, &*work, &Memo::default())).expect_err("no run");
    let wanted = format!("`run.csv` has no frame {:016x}, which is frame 0", other.id());
    assert!(said.to_string().contains(&wanted), "{said}");
}

#[test]
fn tables_that_make_no_sense_are_refused() {
    let with = |from: &str, to: &str| {
        let text = MACHINE.replace(from, to);
        assert_ne!(text, MACHINE, "{from}");
        Machine::parse(&text).expect_err(to).to_string()
    };
    for (from, to, wanted) in [
        ("units.raster]", "units.rastre]", "no kind of unit `rastre`; did you mean `raster`?"),
        ("parts.lanes = 16", "", "how much of `lanes` has one of the raster engines?"),
        ("parts.lanes = 16", "parts.lanse = 16", "no part of `raster` `lanse`; did you mean"),
        ("parts.lanes = 16", "parts.lanes = -1", "must be at least 0.001"),
        ("raster-in =", "rasterin =", "no buffer `rasterin`; did you mean `raster-in`?"),
        ("\"32 B\"", "\"0 B\"", "a word above 0 B"),
    ] {
        let said = with(from, to);
        assert!(said.contains(wanted), "{to}: {said}");
    }
}

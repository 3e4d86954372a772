//! Timelines: the picture and the trace events.

use powergs_chart::Style;
use powergs_core::stage::{buffer_id, stage_id};
use powergs_energy::action::BufferId;
use powergs_testkit::charts::covered;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;

use powergs_base::config::embedded::{MACHINES, find};
use powergs_core::flow::FrameTask;
use powergs_core::kernel::Memo;
use powergs_core::kernel::timeline::{Level, Observer, Span, State};
use powergs_core::machine::Machine;
use powergs_core::stage::Stall;
use powergs_core::workload::bin;
use powergs_frame::trace::Reader;
use powergs_report::charts;
use powergs_report::perfetto::TraceWriter;
use powergs_report::timeline::{COLUMNS, IDLE, Picture, Window};
use serde_json::Value;

fn span(unit: &str, instance: u32, state: State, from: u64, to: u64) -> Span {
    Span { unit: stage_id(unit), instance, state, from, to }
}

/// Two cores: tile 0 waits in the middle, tile 1 follows, tile 2 is on the other core.
fn spans() -> Vec<Span> {
    let features = State::Stalled(Stall::of("features"));
    vec![
        span("ccu", 0, State::Busy(0), 0, 100),
        span("vru", 0, State::Idle, 0, 100),
        span("vru", 0, State::Busy(0), 100, 160),
        span("vru", 0, features, 160, 200),
        span("vru", 0, State::Busy(0), 200, 300),
        span("vru", 0, State::Busy(1), 300, 500),
        span("vru", 1, State::Busy(2), 150, 1000),
    ]
}

#[test]
fn the_window_is_the_work_on_the_tiles() {
    let mut window = Window::new(0..2);
    spans().into_iter().for_each(|s| window.span(s));
    assert_eq!(window.cycles, 100..500, "a batch of the CCU is not a tile");
    let mut none = Window::new(7..9);
    spans().into_iter().for_each(|s| none.span(s));
    assert!(none.cycles.is_empty());
}

#[test]
fn a_column_shows_what_took_most_of_it() {
    let mut picture = Picture::new(0..1000);
    spans().into_iter().for_each(|s| picture.span(s));
    picture.finish();
    let rows: Vec<_> = picture.rows().collect();
    let names: Vec<&str> = rows.iter().map(|r| r.name.as_str()).collect();
    assert_eq!(names, ["CCU 0", "VRU 0", "VRU 1"]);
    let at = |cycle: usize| cycle * COLUMNS / 1000;
    let vru = rows[1];
    assert_eq!(vru.state(at(50)), IDLE);
    assert_eq!(vru.state(at(180)), 2 + Stall::of("features").index());
    assert_eq!(vru.state(at(130)), vru.state(at(250)), "one tile, one colour");
    assert_ne!(vru.state(at(250)), vru.state(at(400)), "the next one has the other");
    assert_eq!(vru.state(at(900)), IDLE, "nothing was said of it");
    let items: Vec<_> = vru.items.iter().map(|i| (i.number, i.cycles.clone(), i.busy)).collect();
    assert_eq!(items, [(0, 100..300, 160), (1, 300..500, 200)]);
    let chart = charts::timeline(&picture, 1e9, "frame 0");
    assert_eq!(covered(&chart), Vec::<String>::new());
    assert!(chart.svg(Style::default()).expect("SVG").contains("VRU 1"));
}

fn trace(clock_hz: f64, spans: &[Span]) -> Value {
    let mut bytes = Vec::new();
    let mut writer = TraceWriter::new(&mut bytes, clock_hz, "a \"title\"").expect("written");
    spans.iter().for_each(|s| writer.span(*s));
    assert_eq!(writer.finish().expect("written"), 0);
    serde_json::from_slice(&bytes).expect("JSON")
}

#[test]
fn trace_events_follow_the_format() {
    let trace = trace(1e9, &spans());
    assert_eq!(trace["otherData"]["title"], "a \"title\"");
    let events = trace["traceEvents"].as_array().expect("events");
    let complete: Vec<&Value> = events.iter().filter(|e| e["ph"] == "X").collect();
    assert_eq!(complete.len(), 6, "idle is not an event");
    for e in events {
        assert!(e["name"].is_string() && e["pid"].is_u64() && e["tid"].is_u64(), "{e}");
        assert!(e["ph"] == "M" || (e["ts"].is_number() && e["dur"].is_number()), "{e}");
    }
    let wait = complete.iter().find(|e| e["cat"] == "stall").expect("a stall");
    assert_eq!((&wait["ts"], &wait["dur"]), (&Value::from(0.16), &Value::from(0.04)), "in us");
    assert_eq!(wait["args"]["cause"], "features");
    let threads = events.iter().filter(|e| e["name"] == "thread_name");
    let threads: Vec<_> = threads.map(|e| e["args"]["name"].as_str().expect("a name")).collect();
    assert_eq!(threads, ["ccu0", "vru0", "vru1"]);
}

/// A counter event for each change of what a buffer holds, and none where nothing changes.
#[test]
fn buffers_are_counters() {
    let mut bytes = Vec::new();
    let mut writer = TraceWriter::new(&mut bytes, 2e9, "x").expect("written");
    let level =
        |instance, from, bytes| Level { buffer: buffer_id("feature"), instance, from, bytes };
    for l in [level(0, 0, 0), level(1, 0, 7), level(0, 10, 0), level(0, 20, 64), level(1, 30, 0)] {
        writer.level(l);
    }
    writer.finish().expect("written");
    let trace: Value = serde_json::from_slice(&bytes).expect("JSON");
    let events = trace["traceEvents"].as_array().expect("events").iter();
    let counters: Vec<(&Value, f64, &Value)> = events
        .filter(|e| e["ph"] == "C")
        .map(|e| (&e["name"], e["ts"].as_f64().expect("a time"), &e["args"]["bytes"]))
        .collect();
    let expected = [("feature0", 0.0, 0), ("feature1", 0.0, 7), ("feature0", 0.01, 64)];
    let expected = expected.into_iter().chain([("feature1", 0.015, 0)]);
    let expected: Vec<(Value, f64, Value)> =
        expected.map(|(name, ts, bytes)| (name.into(), ts, bytes.into())).collect();
    let same = |(a, b): (&(&Value, f64, &Value), &(Value, f64, Value))| {
        *a.0 == b.0 && a.1 == b.1 && *a.2 == b.2
    };
    assert_eq!(counters.len(), expected.len(), "{counters:?}");
    assert!(counters.iter().zip(&expected).all(same), "{counters:?}");
}

#[test]
fn events_of_a_unit_never_overlap_whatever_the_clock() {
    // 3.3 GHz: cycles are no whole nanoseconds.
    let one = |i: u64| span("vru", 0, State::Busy(i as u32), i * 7, i * 7 + 7);
    let spans: Vec<Span> = (0..500).map(one).collect();
    let trace = trace(3.3e9, &spans);
    let events = trace["traceEvents"].as_array().expect("events");
    let ns = |v: &Value| (v.as_f64().expect("a time") * 1e3).round() as i64;
    let mut end = 0;
    for e in events.iter().filter(|e| e["ph"] == "X") {
        assert_eq!(ns(&e["ts"]), end, "neighbours touch");
        end = ns(&e["ts"]) + ns(&e["dur"]);
    }
    assert_eq!(end, (3500.0f64 / 3.3).round() as i64);
}

#[test]
fn a_full_disk_is_an_error() {
    struct Full(usize);
    impl std::io::Write for Full {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0 = self.0.checked_sub(bytes.len()).ok_or(std::io::ErrorKind::StorageFull)?;
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let mut writer = TraceWriter::new(Full(1200), 1e9, "x").expect("the head fits");
    spans().into_iter().for_each(|s| writer.span(s));
    assert!(writer.finish().is_err());
}

/// Byte-cycles and largest levels of each buffer.
#[derive(Default)]
struct Levels {
    now: BTreeMap<(BufferId, u32), (u64, u64)>,
    sums: BTreeMap<BufferId, u128>,
}

impl Observer for Levels {
    fn wants_levels(&self) -> bool {
        true
    }

    fn span(&mut self, _: Span) {}

    fn level(&mut self, level: Level) {
        let held = self.now.entry((level.buffer, level.instance)).or_default();
        let cycles = level.from - held.1;
        *self.sums.entry(level.buffer).or_default() += u128::from(held.0) * u128::from(cycles);
        *held = (level.bytes, level.from);
    }
}

/// What the counters show is what the statistics add up.
#[test]
fn levels_add_up_to_the_statistics() {
    let machine = Machine::parse(find(MACHINES, "gscore").expect("a machine")).expect("checked");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../traces/demo.bin");
    let file = BufReader::new(File::open(path).expect("the demo trace"));
    let mut reader = Reader::open(file).expect("a trace");
    let frame = reader.read_block(0).expect("a block").decode().expect("a frame");
    let workload = bin(&frame, machine.tiles().geometry);
    let (mut levels, memo) = (Levels::default(), Memo::default());
    let task = FrameTask::first(&machine, &workload, &memo);
    let timing = machine.flow().run(&task, Some(&mut levels)).expect("accounts close").timing;
    let end: Vec<Level> = (levels.now.iter())
        .map(|(&(buffer, instance), _)| Level { buffer, instance, from: timing.frame, bytes: 0 })
        .collect();
    end.into_iter().for_each(|level| levels.level(level));
    assert_eq!(levels.sums.len(), 5, "every buffer but the cache");
    for used in &timing.buffers {
        assert_eq!(levels.sums[&used.buffer], used.byte_cycles, "{:?}", used.buffer);
    }
}

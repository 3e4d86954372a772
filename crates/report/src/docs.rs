//! `docs/results.md`, written from the catalogue; a test keeps the committed file equal to it.

use std::fmt::Write;

use super::is_file_name;
use powergs_core::sim::statistics::{Kind, Statistic, catalogue};
use powergs_study::run_record::SCHEMA_VERSION;

/// What each file of a report folder is, charts once.
const FILES: [(&str, &str); 18] = [
    ("run.toml", "what the report was made from: versions, checksums, configuration as resolved"),
    ("invocation.toml", "what was typed, where and when, and how long it took"),
    ("results.csv", "the record: one row per frame, then one per aggregate"),
    ("compare.csv", "of `compare`, in place of `results.csv`: measures and means of all sides"),
    (
        "decision.csv",
        "of `compare`: who meets what; a row a trace and machine, with rates, powers and the rates \
         at which they are drawn, node, scope, and `is_met`",
    ),
    ("speedup.csv", "of `compare` with several traces: speed-ups and energy, geometric means"),
    ("summary.md", "the report for people"),
    ("report.html", "the same for browsers, with all charts inside: one file that can be mailed"),
    (
        "energy.png, .svg, .pdf",
        "energy per frame and power at the display rate, stage by component",
    ),
    ("cycles.png, .svg, .pdf", "per unit: busy, stalls by cause, idle (`cycle` model only)"),
    (
        "roofline.png, .svg, .pdf",
        "FLOP per DRAM byte against FLOP/s, under the peaks of the machine",
    ),
    ("buffers.png, .svg, .pdf", "mean and peak of what each buffer held (where it was measured)"),
    (
        "frame_time.png, .svg, .pdf",
        "frame time of every frame with the deadline (`cycle` model only)",
    ),
    ("tiles.png, .svg, .pdf", "histograms of the list lengths and of the times of tiles"),
    ("tile_load.png, .svg, .pdf", "list length per tile beside the picture of the slowest frame"),
    ("timeline.png, .svg, .pdf", "what every unit did when (`--timeline`)"),
    ("speedup.png, .svg, .pdf", "of `compare` with several traces: the same as bars"),
    ("trace.json.gz", "the same for <https://ui.perfetto.dev> (`--timeline`)"),
];

/// The whole page.
pub fn results_md() -> String {
    let mut text = String::from(HEAD);
    for (name, what) in FILES {
        debug_assert!(is_file_name(name.split(',').next().unwrap_or(name)), "{name}");
        let _ = writeln!(text, "| `{name}` | {what} |");
    }
    let _ = write!(text, "{CSV_AND_JSON}");
    let _ = write!(text, "{RULES}");
    text.push_str("## Statistics\n\n| name | unit | kind | definition |\n|---|---|---|---|\n");
    for s in catalogue() {
        let _ = writeln!(text, "| `{}` | {} | {} | {} |", s.name, s.unit, kind(s), s.definition);
    }
    let _ = writeln!(text, "\nThis is version {SCHEMA_VERSION} of the names.");
    text
}

fn kind(statistic: &Statistic) -> &'static str {
    match statistic.kind {
        Kind::Count => "count",
        Kind::Real => "measure",
    }
}

const HEAD: &str = "\
# Results: every file, every number

<!-- Written from crates/report/src/docs.rs and the catalogue of statistics: change those, then
     run UPDATE_EXPECT=1 cargo test report:: -->

`powergs-sim replay TRACE --out DIR` writes a folder. It appears complete or not at all; a folder \
that holds a finished report is replaced only with `--force`. Same inputs give the same bytes in \
all files but `invocation.toml`, whatever the number of threads.

| file | what it is |
|---|---|
";

const CSV_AND_JSON: &str = "
The columns of `results.csv` are `row` (`frame`, or the aggregate: `mean`, `p50`, `p95`, `p99`, \
`max`), `frame` (position in the trace), `name` (of the view), `incomplete`, then the statistics \
below under their names. A name that begins like a formula (`=`, `+`, `-`, `@`) has an apostrophe \
in front, here and in the tables of sweeps, so that a spreadsheet takes it for text.

`--json` prints the same as one object; `powergs-sim arch schema --report` prints its schema. \
Names are nested by their dots: `frames[0].power_w.total`, `aggregate.frame_time_ms.mean`. Beside \
`frames` and `aggregate` it has:

| name | meaning |
|---|---|
| `schema_version` | raised when a name changes its meaning or goes away |
| `tool_version`, `model_version` | the program; the model, raised when equal inputs give other \
numbers |
| `model` | `cycle` (the simulated machine) or `paper` (published closed-form counts, no time) |
| `machine`, `trace`, `inputs` | what was run on what, with checksums |
| `fps` | the *display* rate that powers and deadlines are for; the rate that the machine achieves \
is `throughput_fps` |
| `incomplete` | true if the run ended early: fewer frames than `trace.frames` |
| `throughput_fps` | frames over the simulated time of all of them, 1/s |
| `throughput_power_w` | energy of all frames over their simulated time: power at full rate, W |
| `deadline_misses` | frames that took longer than 1 / `fps` |
| `bottleneck` | which unit leads and works, or waits for what, as shares of the frame |
| `what_if` | time and energy of some frames with each resource doubled (`--what-if`) |
| `dram_models` | `calibrated` against `banked` (`--dram-model both`) |
| `roofline` | peaks, and FLOP per byte and FLOP/s of the stages |
| `not_modelled` | effects that are left out, with the sign of the bias ([limits.md](limits.md)) |
| `assumptions_that_mattered` | those that mattered most in this run, with the reason |
| `prices` | least and greatest power by each price assumption in use, knobs at low and high |

";

const RULES: &str = "\
## Compared

`powergs-sim compare` writes `compare.csv` (columns `kind`, `name`, one per side, then ratios to \
the first side) and prints with `--json`: `sides` (what was run, its `bottleneck`), `notes` (what \
else differs: traces, energy tables, versions, display rates), `measures` (each with `values`, \
`ratios`, `differences` and which way is `better`) and `means` of every statistic, one value per \
side. Areas, energies and powers of different technology nodes or scopes have no `ratios` and no \
`differences`, here and in `compare.csv`, unless `--across-nodes` asks for them; times, rates and \
energies of different tasks none unless `--across-tasks` does; powers at the display rate none \
where a side misses that rate or has another one.

## The bottleneck

Every cycle of a frame is given to one unit that leads: in preprocessing the CCU, after it the \
busiest of QSU, BSU and VRU; where the phases overlap, the busiest of all. What that unit does \
(works, waits for a cause, has no work) adds up to the frame. A wait of a tenth of the frame or \
more for another unit is traced along VRU, BSU, QSU and CCU to where it begins (`in the end: \
...`): while a unit has nothing to work on, the one before it works or waits, for anything but \
room behind it; shares of time stand for what coincides. What works or waits there decides \
`limit` too. *Row-miss* is the share of the bursts of the stage that waits that had to open a \
row.

## Rules

- **Three powers, never confused.** `energy_pj.total` is paid once per frame. \
`power_full_rate_w.total` is that energy at the rate the machine achieves. `power_w.total` is the \
power at the display rate: energy over the longer of the frame time and the display period, so the \
work of `fps` frames a second plus leakage and DRAM background all the time. Comparisons use the \
last; so do the charts and tables unless they say otherwise.
- **Power is that of a rate that is reached.** A frame that takes longer than the display period \
is shown at its own rate, `displayed_fps`, and its `power_w` is the power there: \
`power_full_rate_w`. The slowest machine then draws least, so a miss is marked wherever the power \
is shown, and sweeps rank designs that miss behind all that do not.
- **A mean power is energy over time**: of `power_w` over the time for which the frames are shown, \
of `power_full_rate_w` over their own. All other means give each frame the same weight.
- **Not measured is not zero.** The `paper` model has no time, and a trace need not carry what \
display power needs: such values are null in JSON, empty in CSV and `not measured` in text.
- **Quantiles are nearest-rank**: p95 is the smallest value such that at least 95 % of the frames \
are at or below it. Every quantile is a value that occurred; p99 of fewer than 100 frames is the \
maximum. An aggregate exists only if every frame has the value.
- **Accounting closes** in every run: per unit busy + stalls + idle = instances x frame; energy \
parts, bytes and requests add up. A breach ends the program with exit code 4.
- **An interrupted run** says INCOMPLETE in every output, and its aggregates are over the frames \
that were finished.

## Exit codes

| code | meaning |
|--:|---|
| 0 | done |
| 1 | the goal was not met: comparison, validation, quality target |
| 2 | usage or configuration, or an output that cannot be written |
| 3 | a bad, incomplete or missing input file, or one that takes more memory than `--memory` |
| 4 | an internal invariant broke: a mistake of ours, please report it |
| 130 | interrupted with Ctrl-C or SIGTERM; what was finished is usable and marked INCOMPLETE |

";

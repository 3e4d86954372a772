//! Terminal summary, summary.md, the bottleneck sentence, numbers for people.

use expect_test::{expect, expect_file};
use powergs_chart::Format;
use powergs_core::stage::stage_id;
use powergs_report::bottleneck::sentence;
use powergs_report::charts;
use powergs_report::format::{engineering, percent, rate, shortened, significant, wrapped};
use powergs_report::page::document;
use powergs_study::findings::{Bottleneck, Limit, bottleneck};
use powergs_study::run_record::Run;

use crate::builder;

fn terminal(run: &Run) -> String {
    let next = "powergs-sim replay garden.bin --set vru.units-per-core=32";
    let ending = [("report", "reports/garden-gscore/summary.md".into()), ("next", next.to_owned())];
    let text = document(run, &[], &ending).terminal(80);
    for line in text.lines() {
        assert!(line.chars().count() <= 80, "{} columns: {line}", line.chars().count());
        assert_eq!(line, line.trim_end());
    }
    text
}

#[test]
fn terminal_summary() {
    expect![[r#"
        garden on gscore: 24 frames of 979x546 at 60 Hz, cycle model
        VRU-bound for 61 % of the frame, CCU-bound for 10 %; waiting for records of
        Gaussians 12 % (row-miss 8 %), feature loads 8 % (row-miss 41 %), sorted chunks
        from the GSU 4 %, room in the output buffer 1 %; idle 4 %.

        frame time           mean 11.0 ms, max of 24: 17.8 ms
        frame rate           90.9 FPS
        deadline             16.7 ms at 60 FPS: MISSED by 5 of 24 frames; 49.7 FPS where
                             pictures change between periods alone
        at full rate         6.98 mJ per frame x 90.9 FPS = 635 mW
        at the display rate  7.51 mJ per frame x 59.5 FPS = 447 mW; MISSES 60 FPS
        with the display     447 mW + 940 mW of the display = 1387 mW

        mW at 59.5 FPS  dram  sram  flop  leakage  background  refresh  total
        preprocessing   32.7  6.54  13.1        -           -        -   52.4
        sorting         52.4  9.82  6.54        -           -        -   68.7
        rendering       78.5  26.2   131        -           -        -    236
        standby            -     -     -     60.0        25.0     5.00   90.0
        total            164  42.5   151     60.0        25.0     5.00    447

        % of cycles  busy  records  list  spill  features  colours  input  output  bank
        ccu x4         10       12     -      -         -        -      -       1     -
        qsu x8          5        -    14      -         -        -      2      20     -
        bsu x4         22        -     2      -         -        -     11      30     -
        vru x64        61        -     -      -         8        -      4      <1     -
        pxu x1          3        -     -      -         1        -      -       1     -
        gru x4          2        -     -      -         1        -      -       2     -
        colour x4       2        -     -      -         -        -      -       -     -
        ltu x1          2        -     -      -         -        -      -       -     -

        % of cycles  idle
        ccu x4         77
        qsu x8         59
        bsu x4         35
        vru x64        27
        pxu x1         95
        gru x4         95
        colour x4      98
        ltu x1         98

        DRAM bus busy 33 % of the time: 1.70 of 51.2 GB/s, 73 % row hits, 1.32 bytes
        moved per byte asked for.
        40 % of the pixels are rendered. Of those that look up their first Gaussians
        25 % stop there.
        The second eye is made of what blends in the first one: 25 % of the entries of
        its own lists. By that <1 % of its pixels may change by a step of eight bits or
        more, <1 % because disparities are beyond stereo.lag.

        region, a frame  tiles  splats loaded  VRU cycles   energy
        R1                2040        1100000     3299999  11.0 mJ
        R2                2040         550000     1649999  5.50 mJ
        R3                2040         366666     1100000  3.67 mJ
        R4                2040         275000      824999  2.75 mJ

                               frame time      power       area          merit
        if doubled (3 frames)    ms     %   mW     %   mm²    %  FPS/mm²     %
        nothing                11.0        516        12.0          7.56
        dram.channels          8.36   -24  508  -1.5  20.0  +67     5.97   -21
        vru.units-per-core     10.1  -8.2  514  -0.3  13.9  +16     7.12  -5.7
        ... and 1 more: summary.md

        No doubled resource raises the frames per second per mm²: dram.channels saves
        most time, -24 %, for +67 % area and -1.5 % power.

        limits  35 effects left out: 27 optimistic, 3 pessimistic, 5 either way: frame
                times are rather too short; the assumptions that matter most: A4 (DRAM
                transfers reach 78 % of the peak); A26 (All units of a core work on one
                pair); numbers of PowerGS (powergs)
        report  reports/garden-gscore/summary.md
        next    powergs-sim replay garden.bin --set vru.units-per-core=32
    "#]]
    .assert_eq(&terminal(&builder::garden()));
}

#[test]
fn terminal_summary_of_the_paper_model() {
    expect![[r#"
        garden on paper: 24 frames of 979x546 at 60 Hz, paper model

        frame time           not in this model, which counts work only
        at the display rate  2.83 mJ per frame x 60 FPS = 170 mW

        mW at 60 FPS   dram  sram  flop  leakage  background  refresh  total
        preprocessing  15.6  3.12  6.24        -           -        -   25.0
        sorting        25.0  4.68  3.12        -           -        -   32.8
        rendering      37.4  12.5  62.4        -           -        -    112
        total          78.0  20.3  71.8        0           0        0    170

        report  reports/garden-gscore/summary.md
        next    powergs-sim replay garden.bin --set vru.units-per-core=32
    "#]]
    .assert_eq(&terminal(&builder::paper()));
}

#[test]
fn terminal_summary_of_an_interrupted_run_with_a_long_name() {
    let mut run = builder::run(&[0.5]);
    run.facts.trace.name = "x".repeat(200);
    run.facts.trace.frames = 1350;
    let text = terminal(&run);
    assert!(text.contains("INCOMPLETE: 1 of 1350 frames"), "{text}");
    assert!(
        text.lines()
            .next()
            .is_some_and(|l| l.ends_with("1 frame of 979x546 at 60 Hz, cycle model"))
    );
}

#[test]
fn summary_page() {
    let run = builder::garden();
    let charts = charts::all(&run);
    let text = document(&run, &charts, &[]).markdown(Format::Png);
    expect_file!["summary.md"].assert_eq(&text);
}

#[test]
fn summary_page_of_an_interrupted_run() {
    let mut run = builder::garden();
    run.frames.truncate(3);
    run.facts.trace.name = "a|b*c\n# d".into();
    let text = document(&run, &[], &[]).markdown(Format::Png);
    assert!(text.starts_with("# a\\|b\\*c?# d on gscore\n\n**INCOMPLETE: 3 of 24 frames.**"));
}

/// The bottleneck of a run of one frame whose units and DRAM are changed by `change`.
fn limited(change: impl FnOnce(&mut powergs_core::kernel::FrameTiming)) -> Option<Bottleneck> {
    let mut run = builder::run(&[8.0]);
    change(&mut builder::cycle(&mut run.frames[0]).timing);
    let found = bottleneck::of(&run.statistics()?)?;
    let parts = found.bounds.iter().map(|b| b.share).chain(found.waits.iter().map(|w| w.share));
    let sum = parts.sum::<f64>() + found.without_work;
    // Cycles are cut to integers for 64 units.
    assert!((sum - 1.0).abs() < 1e-4, "{sum}: {found:?}");
    Some(found)
}

/// All cycles of unit `i` that are not busy or of `stalls` become idle.
fn refill(t: &mut powergs_core::kernel::FrameTiming, i: usize, busy: f64, stalls: [f64; 7]) {
    let unit = &mut t.units[i];
    let all = t.frame * u64::from(unit.instances);
    unit.busy = (busy * all as f64) as u64;
    unit.stalls = builder::stalls(stalls.map(|share| (share * all as f64) as u64));
    unit.idle = all - unit.busy - unit.stalls.iter().sum::<u64>();
}

#[test]
fn bottleneck_follows_the_cycles() {
    let limit = |found: Option<Bottleneck>| found.map(|f| f.limit);
    assert_eq!(limit(limited(|_| {})), Some(Limit::Unit(stage_id("vru"))));
    let full = limited(|t| t.dram.busy_cycles = t.frame * 9 / 10);
    assert!(full.as_ref().is_some_and(|f| {
        sentence(f).starts_with("DRAM-bound: the bus moves data for 90 % of the frame")
    }));
    assert_eq!(limit(full), Some(Limit::Dram));
    let waits = [0.0, 0.05, 0.0, 0.30, 0.05, 0.0, 0.0];
    let starved = limited(|t| refill(t, 3, 0.3, waits)).expect("time");
    assert_eq!(starved.limit, Limit::Dram, "leading units wait longer than they work");
    assert_eq!(
        sentence(&starved),
        "DRAM-bound for 48 % of the frame (feature loads 30 % (row-miss 41 %), records of \
         Gaussians 12 % (row-miss 8 %), tile lists 5 % (row-miss 25 %)); VRU at work 30 %, CCU at \
         work 10 %; waiting for sorted chunks from the GSU 5 %, room in the output buffer 1 %; \
         idle 7 %."
    );
    assert_eq!(limit(limited(|t| refill(t, 2, 0.7, [0.0; 7]))), Some(Limit::Unit(stage_id("bsu"))));
    let early = limited(|t| {
        t.preprocessing_end = t.frame * 3 / 4;
        refill(t, 0, 0.6, [0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        (1..4).for_each(|i| refill(t, i, 0.2, [0.0; 7]));
    });
    assert_eq!(limit(early), Some(Limit::Unit(stage_id("ccu"))));
    let overlapped = limited(|t| refill(t, 3, 0.9, [0.0; 7])).expect("time");
    assert_eq!(overlapped.bounds.len(), 1, "where phases overlap one unit leads the whole frame");
    assert_eq!(limit(limited(|t| t.frame = 0)), None);
    assert_eq!(bottleneck::of(&builder::paper().statistics().expect("frames")), None);
}

#[test]
fn a_wait_is_traced_to_where_it_begins() {
    // Phases overlap: VRUs starve, since lists come late, since records do.
    let [input, output] = [4, 5];
    let waits = |cause: usize, share: f64| {
        let mut stalls = [0.0; 7];
        stalls[cause] = share;
        stalls
    };
    let starved = |ccu_busy: f64, records: f64| {
        limited(|t| {
            t.preprocessing_end = t.frame;
            refill(t, 0, ccu_busy, waits(0, records));
            refill(t, 1, 0.1, waits(input, 0.5));
            refill(t, 2, 0.1, [0.0, 0.0, 0.0, 0.0, 0.6, 0.2, 0.0]);
            refill(t, 3, 0.3, waits(input, 0.66));
        })
        .expect("time")
    };
    let found = starved(0.1, 0.8);
    assert_eq!(found.limit, Limit::Dram, "{found:?}");
    let text = sentence(&found);
    let dram = "DRAM-bound for 42 % of the frame (sorted chunks from the GSU 66 % (in the end: \
                records of Gaussians 42 %, QSU at work 10 %, BSU at work 9 %, others 5 %)); \
                VRU at work 30 %; idle 4 %.";
    assert_eq!(text, dram);
    // The same waits, and a CCU that has its records: more of them would help.
    let found = starved(0.28, 0.02);
    assert_eq!(found.limit, Limit::Unit(stage_id("ccu")), "{found:?}");
    let text = sentence(&found);
    assert!(text.starts_with("CCU-bound for 44 % of the frame, others wait for it"), "{text}");
    // A BSU that is stalled by the VRU is none that a VRU waits for.
    let found = limited(|t| {
        t.preprocessing_end = t.frame;
        refill(t, 2, 0.0, waits(output, 0.9));
        refill(t, 3, 0.3, waits(input, 0.3));
    });
    let found = found.expect("time");
    assert!(found.waits.iter().all(|w| w.roots.is_empty()), "{found:?}");
}

#[test]
fn without_a_device_nothing_is_said_of_rows() {
    let found = limited(|t| t.dram.commands = None).expect("time");
    let text = sentence(&found);
    assert!(!text.contains("row"), "{text}");
}

#[test]
fn numbers_for_people() {
    let numbers = [0.0, 1.234e-3, 0.9996, 12.34, 999.6, 1.5e7, 3e-13];
    let texts = numbers.map(|x| engineering(x, "W"));
    let expected = ["0 W", "1.23 mW", "1.00 W", "12.3 W", "1.00 kW", "15.0 MW", "0.300 pW"];
    assert_eq!(texts, expected);
    assert_eq!(
        [0.12345, 9.996, 99.96, 12345.6].map(significant),
        ["0.123", "10.0", "100", "12346"]
    );
    assert_eq!([0.0, 0.001, 0.006, 0.5, 1.0].map(percent), ["0", "<1", "1", "50", "100"]);
    assert_eq!([60.0, 59.94, 72.5].map(rate), ["60", "59.94", "72.5"]);
    assert_eq!(shortened("änderung\n", 6), "änder…");
    assert_eq!(wrapped("a bb  ccc dddddddddd e", 6), "a bb\nccc\ndddddddddd\ne");
}

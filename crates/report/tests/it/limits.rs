//! What is not modelled and what prices do, in sentences: each with a run of which the opposite is
//! true.

use powergs_core::flow::tile_wise::measures;
use powergs_core::kernel::FrameTiming;
use powergs_core::sim::FrameReport;
use powergs_core::stage::hardware;
use powergs_core::workload::reuse::ReuseSummary;
use powergs_report::limits::{line, prices, sum};
use powergs_report::page::document;
use powergs_report::{charts, json};
use powergs_study::findings::compare::{Across, AskedLimits, Comparison, Decision, Side};
use powergs_study::findings::limits::{Bias, Effect, Mattered, Why, not_modelled};
use powergs_study::findings::prices::{PriceBar, PriceBars};
use powergs_study::run_record::Run;

use crate::builder;

fn effects(biases: &[Bias]) -> Vec<Effect> {
    biases.iter().map(|&bias| Effect { bias, ..not_modelled()[0] }).collect()
}

#[test]
fn the_sum_says_which_way_effects_go_together() {
    use Bias::{Either, Optimistic, Pessimistic};
    assert_eq!(
        sum(&effects(&[Optimistic, Optimistic, Pessimistic, Either])),
        "4 effects left out: 2 optimistic, 1 pessimistic, 1 either way: frame times are rather too \
         short"
    );
    assert!(sum(&effects(&[Pessimistic, Either, Either])).ends_with("rather too long"));
    assert!(sum(&effects(&[Optimistic, Pessimistic])).ends_with("neither way prevails"));
    assert!(sum(&effects(&[Either])).ends_with("neither way prevails"));
    assert_eq!(sum(&[]), "0 effects left out");
}

fn bars(watts: &[(&str, f64, f64)]) -> PriceBars {
    let bar = |&(assumption, low_w, high_w): &(&str, f64, f64)| PriceBar {
        assumption: assumption.to_owned(),
        keys: vec!["energy.scale".to_owned()],
        low_w,
        high_w,
    };
    PriceBars::new(0.94, watts.iter().map(bar))
}

#[test]
fn prices_name_the_three_that_move_the_power_most() {
    let [a8, a40] = [("A8", 0.9, 1.0), ("A40", 0.61, 1.7)];
    let all = bars(&[a8, a40, ("A9", 0.93, 0.96), ("A43", 0.8, 0.99)]);
    assert_eq!(
        prices(&all).expect("bars"),
        "940 mW, one assumption at a time: 610 mW to 1700 mW by A40 (LPDDR4 currents are those of \
         a 32-bit die); 800 mW to 990 mW by A43 (LPDDR5 costs LPDDR4 at lower voltages); 900 mW to \
         1000 mW by A8 (Published power is that of one operation per cycle)"
    );
    assert_eq!(prices(&bars(&[])), None);
    assert_eq!(prices(&bars(&[("A40", 0.939, 0.941)])), None, "it moves next to nothing");
    let mut run = builder::garden();
    let text = |run: &Run| document(run, &[], &[]).terminal(80);
    assert!(!text(&run).contains("one assumption at a time"));
    assert!(json::report(&run)["prices"].is_null());
    run.experiments.prices = Some(all);
    assert!(text(&run).contains("\nprices  940 mW, one assumption at a time"), "{}", text(&run));
    assert_eq!(json::report(&run)["prices"]["bars"][0]["assumption"], "A40");
    assert_eq!(json::report(&run)["prices"]["bars"][0]["high_power_w"], 1.7);
}

/// Prices have a line of their own.
#[test]
fn the_line_of_limits_leaves_prices_to_theirs() {
    let price = Why::Price { power_w: 1.0, low_w: 0.5, high_w: 2.0 };
    let of = |assumption: &str, why| Mattered { assumption: assumption.to_owned(), why };
    let both = [of("A40", price), of("A27", Why::Bottleneck)];
    let text = line(&effects(&[Bias::Either]), &both);
    assert!(text.contains("A27") && !text.contains("A40"), "{text}");
    assert!(!line(&effects(&[Bias::Either]), &both[..1]).contains("matter most"));
}

fn with_timing(change: impl Fn(&mut FrameTiming)) -> Run {
    let mut run = builder::run(&[4.0, 6.0]);
    run.frames.iter_mut().for_each(|frame| change(&mut builder::cycle(frame).timing));
    run
}

fn buffers_chart(run: &Run) -> String {
    let chart = charts::all(run).into_iter().find(|chart| chart.name == "buffers");
    chart.expect("a chart").svg(powergs_chart::Style::default()).expect("SVG")
}

#[test]
fn buffers_that_held_more_than_they_have_are_named() {
    let full = with_timing(|t| t.buffers[1].peak = t.buffers[1].capacity);
    let over = with_timing(|t| t.buffers[1].peak = 329 << 10);
    let text = |run: &Run| document(run, &[], &[]).terminal(200);
    assert!(!text(&full).contains("Batches needed"), "{}", text(&full));
    let buffer = over.frames[0].timing().expect("a time").buffers[1].buffer;
    let name = hardware().buffer(buffer).name;
    let said = format!("Batches needed up to 329 KiB of the 32 KiB of {name}: ");
    assert!(text(&over).contains(&said), "{}", text(&over));
    assert!(text(&over).contains("the area is optimistic"));
    let beyond = "peak beyond the capacity";
    assert!(buffers_chart(&over).contains(beyond) && !buffers_chart(&full).contains(beyond));
    assert!(buffers_chart(&over).contains(">1000<"), "329 of 32 KiB are 1028 %");
}

#[test]
fn views_that_are_no_path_are_called_so() {
    let keeping = |kept: u64| {
        let mut run = builder::run(&[4.0, 6.0]);
        let reuse = ReuseSummary { kept, new: 100 - kept, ..ReuseSummary::default() };
        let taken_over = |frame: &mut FrameReport| {
            builder::cycle(frame).measured.extend(measures::measured(&reuse));
        };
        run.frames.iter_mut().skip(1).for_each(taken_over);
        document(&run, &[], &[]).terminal(200)
    };
    let text = keeping(2);
    assert!(
        text.contains("Order kept from frame to frame: 2 % of list entries; these views are no")
    );
    assert!(keeping(93).contains("93 % of list entries; views of a path"));
    assert!(keeping(60).contains("60 % of list entries; views that are further apart"));
    let sorted = document(&builder::garden(), &[], &[]).terminal(200);
    assert!(!sorted.contains("Order kept"), "a machine that sorts anew keeps nothing");
}

/// Devices whose prices rest on other assumptions.
#[test]
fn a_comparison_says_whose_dram_prices_rest_on_what() {
    let side = |model: &str, source: &str| {
        let mut run = builder::run(&[4.0]);
        run.facts.configuration = toml::from_str(&format!(
            "[machine.dram]\nmodel = \"{model}\"\n[energy.dram]\ndevice = true\n\
             row-hits.source = \"A150\"\n[energy.dram.flat.read]\nsource = \"powergs\"\n\
             [dram.energy]\nscale-source = \"A40\"\nactions.read.source = \"{source}\"\n"
        ))
        .expect("a table");
        Side::of_run(&run).expect("frames")
    };
    let text = |sides: [Side; 2]| document_of(&Comparison::new(sides.into(), Across::default()));
    let other = text([side("banked", "A43"), side("banked", "A46")]);
    let said = "price assumptions of the DRAM differ (A40 and A43, A40 and A46)";
    assert!(other.contains(said), "{other}");
    let what = "price assumptions of the DRAM";
    assert!(!text([side("banked", "A43"), side("banked", "A43")]).contains(what));
    // Where no commands are counted, bytes have the prices of the device with a share of row hits.
    let flat = [side("bandwidth", "A43"), side("bandwidth", "A46")];
    assert_eq!(flat[0].dram_prices, ["A150", "A40", "A43"]);
    assert!(text(flat).contains(what));
    assert!(text([side("bandwidth", "A43"), side("banked", "A43")]).contains(what));
}

fn document_of(comparison: &Comparison) -> String {
    let limits = AskedLimits::default();
    let decision = Decision::of(std::slice::from_ref(comparison), &limits).expect("no condition");
    let decided = powergs_report::compare::Decided { decision: &decision, limits: &limits };
    powergs_report::compare::document(comparison, decided, &[], None).terminal(300)
}

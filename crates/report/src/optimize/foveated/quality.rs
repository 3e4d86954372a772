//! Quality against total power: every method and variant, the dense model, and models that are
//! shown without foveation.

use super::{Show, colour, plain_colour};
use crate::format::watt_unit;
use powergs_chart::{
    Axis, Chart, Colour, Entry, Form, Line, Panel, Place, Points, Rule, Scale, Side, Size, Symbol,
};
use powergs_optimize::foveated::Method;
use powergs_optimize::results::{Reference, Results};
use powergs_optimize::role::{Baseline, RoleKind};

const NAME: &str = "foveated_quality";
const TITLE: &str = "Quality against total power";

/// A model on the page.
struct QualityMark {
    watts: f64,
    psnr_db: Option<f64>,
    hvsq: Option<f64>,
    /// Method of a foveated model.
    method: Option<Method>,
    colour: Colour,
    label: String,
}

pub(super) fn chart(show: &Show<'_>) -> Option<Chart> {
    let (r, marks) = (show.results, marks(show.results));
    if marks.iter().all(|m| m.method.is_none()) {
        return None;
    }
    let most = marks.iter().map(|m| m.watts).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let entries = [
        ("PowerGS", Colour::VERMILION),
        ("FR-Render", Colour::ORANGE),
        ("FR-Display", Colour::BLUE),
        ("RTGS+D22, two-stage", Colour::PURPLE),
        ("LightGaussian", Colour::GREEN),
        ("dense", Colour::INK),
    ];
    let note = "dots: foveated, joined variant by variant; squares: level 1 everywhere; RTGS+D22: \
                behind its filter";
    let dense = r.dense().map(|m| per_watt * m.total_w());
    let dense = dense.filter(|_| r.reference == Reference::Own);
    let x = format!("total power, {unit}");
    let point = |m: &QualityMark, v: f64| (per_watt * m.watts, v);
    let psnr = |m: &QualityMark| m.psnr_db.map(|v| point(m, v));
    let hvsq = |m: &QualityMark| m.hvsq.map(|v| point(m, 1e5 * v));
    let what = "PSNR: level 1 on whole test views; HVSQ: shown frames";
    Some(
        show.chart(NAME, TITLE, what)
            .legend(entries.map(|(name, colour)| Entry::new(name, Symbol::Dot(colour))))
            .legend([Entry::note(note)])
            .columns(2)
            .panel(panel(&marks, &x, "PSNR, dB", &psnr, dense))
            .panel(panel(&marks, &x, "HVSQ of the worst region, 1e-5", &hvsq, None)),
    )
}

fn marks(r: &Results) -> Vec<QualityMark> {
    let foveated = r.foveated.iter().map(|f| QualityMark {
        watts: f.total_w(),
        psnr_db: f.likeness(r).psnr_db,
        hvsq: f.worst().map(|(hvsq, _)| hvsq),
        method: Some(f.method),
        colour: colour(f.method),
        label: f.variant.clone(),
    });
    let ours: Vec<&str> =
        r.variants.iter().filter_map(|v| Some(r.ours(&v.name)?.name.as_str())).collect();
    let plain = r.models.iter().filter(|m| m.level == 1).filter_map(|m| {
        let is_dense = m.role == RoleKind::Dense;
        let is_ours = ours.contains(&m.name.as_str());
        let compared = matches!(m.role, RoleKind::Baseline | RoleKind::External);
        // Against its own renders the dense model is perfect: no place on a scale.
        let is_perfect = is_dense && r.reference == Reference::Own;
        (is_dense || is_ours || compared).then(|| QualityMark {
            watts: m.total_w(),
            psnr_db: m.test.psnr_db.filter(|_| !is_perfect),
            hvsq: None,
            method: None,
            colour: plain_colour(m.baseline, is_dense, is_ours),
            // Dots beside them say the variant.
            label: match m.baseline {
                Some(Baseline::RenderOnly | Baseline::DisplayOnly) => String::new(),
                Some(Baseline::LightGaussian(percent)) => percent.to_string(),
                Some(Baseline::TwoStage) => Baseline::TwoStage.name(),
                None if is_ours => String::new(),
                None => m.name.clone(),
            },
        })
    });
    foveated.chain(plain).collect()
}

/// Where a mark is, if it has the value.
type At<'a> = &'a dyn Fn(&QualityMark) -> Option<Place>;

fn panel(marks: &[QualityMark], x: &str, y: &str, at: At<'_>, dense: Option<f64>) -> Panel {
    let shown: Vec<(&QualityMark, Place)> =
        marks.iter().filter_map(|m| Some((m, at(m)?))).collect();
    let powers = shown.iter().map(|(_, p)| p.0).chain(dense);
    let across = Axis::new(x, Scale::around(powers, 0.1));
    let up = Axis::new(y, Scale::around(shown.iter().map(|(_, p)| p.1), 0.12));
    let top = up.scale.high();
    let mut panel = Panel::new(across, up);
    if let Some(power) = dense {
        panel = panel.dashed(Rule::X(power), Colour::INK).label(
            "dense (the reference)",
            (power, top),
            Side::BelowLeft,
        );
    }
    panel = join(panel, &shown);
    for (mark, at) in &shown {
        // Where both lie at one place, both are seen.
        let is_foveated = mark.method.is_some();
        let (form, size) =
            if is_foveated { (Form::Dot, Size::Huge) } else { (Form::Square, Size::Medium) };
        let dots = Points::dots([*at], mark.colour, size);
        panel = panel.points(Points { form, ..dots });
        if !mark.label.is_empty() {
            panel = panel.label(mark.label.as_str(), *at, Side::Free);
        }
    }
    panel
}

/// Lines through the variants of a method.
fn join(panel: Panel, shown: &[(&QualityMark, Place)]) -> Panel {
    let mut methods: Vec<Method> = shown.iter().filter_map(|(m, _)| m.method).collect();
    methods.sort_by_key(|method| method.name());
    methods.dedup();
    methods.into_iter().fold(panel, |panel, method| {
        let of = shown.iter().filter(|(m, _)| m.method == Some(method));
        panel.line(Line::thin(of.map(|(_, at)| *at).collect(), colour(method)))
    })
}

//! Quality against total power: every method and variant, the dense model, and models that are
//! shown without foveation.

use plotters::style::RGBColor;

use super::{Show, around, colour, labels, plain_colour, square};
use crate::ReportError;
use crate::charts::Chart;
use crate::format::watt_unit;
use crate::plot::{Align, Canvas, Drawn, GREY, GRID, INK, Panel, legend, palette};
use powergs_optimize::foveated::Method;
use powergs_optimize::job::RoleKind;
use powergs_optimize::results::{Reference, Results};

const NAME: &str = "foveated_quality";
const TITLE: &str = "Quality against total power";

/// A model on the page.
struct Mark {
    watts: f64,
    psnr_db: Option<f64>,
    hvsq: Option<f64>,
    /// Method of a foveated model.
    method: Option<Method>,
    colour: RGBColor,
    label: String,
}

pub(super) fn chart(show: &Show<'_>) -> Result<Option<Chart>, ReportError> {
    let marks = marks(show.results);
    if marks.iter().all(|m| m.method.is_none()) {
        return Ok(None);
    }
    let what = "PSNR: level 1 on whole test views; HVSQ: shown frames";
    let drawing = show.page(NAME, TITLE, what).draw(|canvas| draw(canvas, show.results, &marks))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn marks(r: &Results) -> Vec<Mark> {
    let foveated = r.foveated.iter().map(|f| Mark {
        watts: f.total_w(),
        psnr_db: r.model(&f.jobs[0]).and_then(|m| m.test.psnr_db),
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
        (is_dense || is_ours || compared).then(|| Mark {
            watts: m.total_w(),
            psnr_db: m.test.psnr_db.filter(|_| !is_perfect),
            hvsq: None,
            method: None,
            colour: plain_colour(m.baseline.as_deref(), is_dense, is_ours),
            // Dots beside them say the variant.
            label: match m.baseline.as_deref() {
                Some("render-only" | "display-only") => String::new(),
                Some(name) => name.strip_prefix("lightgs-").unwrap_or(name).to_owned(),
                None if is_ours => String::new(),
                None => m.name.clone(),
            },
        })
    });
    foveated.chain(plain).collect()
}

fn draw(canvas: &Canvas, r: &Results, marks: &[Mark]) -> Drawn {
    let left = Panel { left: 120.0, top: 176.0, right: 640.0, bottom: 630.0 };
    let right = Panel { left: 780.0, ..left };
    let right = Panel { right: 1240.0, ..right };
    let most = marks.iter().map(|m| m.watts).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let entries = [
        ("PowerGS", palette::VERMILION),
        ("FR-Render", palette::ORANGE),
        ("FR-Display", palette::BLUE),
        ("RTGS+D22, two-stage", palette::PURPLE),
        ("LightGaussian", palette::GREEN),
        ("dense", INK),
    ];
    legend(canvas, 40.0, 112.0, &entries)?;
    let note = "dots: foveated, joined variant by variant; squares: level 1 everywhere; PSNR of \
                RTGS+D22: before its filter";
    canvas.text(note, (40.0, 142.0), Align::Left, GREY)?;
    let dense = r.dense().map(|m| m.total_w()).filter(|_| r.reference == Reference::Own);
    let x_name = format!("total power, {unit}");
    let psnr = |m: &Mark| m.psnr_db;
    let hvsq = |m: &Mark| m.hvsq.map(|v| 1e5 * v);
    plot(canvas, left, marks, (per_watt, &x_name), (&psnr, "PSNR, dB"), dense)?;
    plot(canvas, right, marks, (per_watt, &x_name), (&hvsq, "HVSQ of the worst region, 1e-5"), None)
}

/// What is drawn of a mark.
type Value<'a> = &'a dyn Fn(&Mark) -> Option<f64>;

fn plot(
    canvas: &Canvas,
    panel: Panel,
    marks: &[Mark],
    (per_watt, x_name): (f64, &str),
    (value, y_name): (Value<'_>, &str),
    dense: Option<f64>,
) -> Drawn {
    let shown: Vec<(&Mark, f64)> = marks.iter().filter_map(|m| Some((m, value(m)?))).collect();
    let powers = shown.iter().map(|(m, _)| per_watt * m.watts);
    let powers = powers.chain(dense.map(|w| per_watt * w));
    let x = around(powers, 0.1, panel.horizontal());
    let y = around(shown.iter().map(|(_, v)| *v), 0.12, panel.vertical());
    panel.vertical_axis(canvas, &y, y_name)?;
    let ticks = x.ticks(6);
    for &tick in &ticks {
        canvas.line(&[(x.at(tick), panel.top), (x.at(tick), panel.bottom)], GRID, 1)?;
    }
    panel.horizontal_axis(canvas, &x, &ticks, x_name)?;
    if let Some(watts) = dense {
        let at = x.at(per_watt * watts);
        super::super::dashed(canvas, (at, panel.top), (at, panel.bottom), INK)?;
        let place = (at - 8.0, panel.top + 14.0);
        canvas.text("dense (the reference)", place, Align::Right, INK)?;
    }
    let place = |m: &Mark, v: f64| (x.at(per_watt * m.watts), y.at(v));
    join(canvas, &shown, &place)?;
    let (mut texts, mut taken) = (Vec::new(), Vec::new());
    for (mark, v) in &shown {
        let at = place(mark, *v);
        match mark.method {
            Some(_) => canvas.dot(at, 8, mark.colour)?,
            None => square(canvas, at, 6.0, mark.colour)?,
        }
        match mark.label.is_empty() {
            true => taken.push([at.0 - 9.0, at.1 - 9.0, at.0 + 9.0, at.1 + 9.0]),
            false => texts.push((at, mark.label.clone(), INK)),
        }
    }
    labels(canvas, &texts, (panel.left, panel.right + 30.0), taken)
}

/// Lines through the variants of a method.
fn join(
    canvas: &Canvas,
    shown: &[(&Mark, f64)],
    place: &dyn Fn(&Mark, f64) -> (f64, f64),
) -> Drawn {
    let mut methods: Vec<Method> = shown.iter().filter_map(|(m, _)| m.method).collect();
    methods.sort_by_key(|method| method.name());
    methods.dedup();
    for method in methods {
        let of = shown.iter().filter(|(m, _)| m.method == Some(method));
        let points: Vec<(f64, f64)> = of.map(|(m, v)| place(m, *v)).collect();
        if points.len() > 1 {
            canvas.line(&points, colour(method), 2)?;
        }
    }
    Ok(())
}

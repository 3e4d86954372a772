//! The foveated part of `summary.md`, and what is printed of it.

use super::super::decimals;
use super::Show;
use crate::document::{Block, Cell, Column, Document, Kind, Table, Text};
use crate::format::{engineering, watt_unit};
use powergs_chart::Chart;
use powergs_frame::fovea::{LEVELS, REGIONS};
use powergs_optimize::foveated::{LevelState, Method};
use powergs_optimize::results::{FovealRecord, ModelRecord, Results};
use powergs_optimize::role::RoleKind;

/// The part, with `charts` beside it; empty if nothing was measured.
pub fn document(show: &Show<'_>, charts: &[Chart]) -> Document {
    let (r, mut page) = (show.results, Document::new());
    if r.foveated.is_empty() {
        return page;
    }
    page.title("Foveated");
    methods(&mut page, r);
    regions(&mut page, r);
    plain(&mut page, r);
    levels(&mut page, r);
    for chart in charts {
        page.heading(chart.title.clone());
        page.add(Block::Chart(chart.clone()));
    }
    page
}

/// HVSQ in units of 1e-5.
fn e5(value: Option<f64>) -> Cell {
    value.map(|v| 1e5 * v).into()
}

/// What the foveated model saves, in a line; `None` without one.
pub fn saving(r: &Results) -> Option<String> {
    let variant = r.variants.first()?;
    let own = r.foveal(Method::PowerGs, &variant.name)?;
    let result = variant.foveated_result.and_then(|m| r.foveal(m, &variant.name)).unwrap_or(own);
    let dense = r.dense()?.total_w();
    let (from, to) = (engineering(dense, "W"), engineering(result.total_w(), "W"));
    let saved = 100.0 * (1.0 - result.total_w() / dense);
    let mut line = format!("{from} -> {to}: {saved:.1} % saved, foveated, in model.fov");
    if result.method != own.method {
        let more = 100.0 * (own.total_w() / result.total_w() - 1.0);
        let (name, ours) = (result.label(), own.label());
        line += &format!("\n(that is {name}; the search missed it, {ours} takes {more:.1} % more)");
    }
    Some(line)
}

/// For a terminal: a row a method; empty if nothing was measured.
pub fn headline(r: &Results) -> Table {
    let watts = || Kind::Real(|w| engineering(w, "W"));
    let hvsq = |region: &str| Column::fixed(region, 2).group("HVSQ, 1e-5");
    let mut columns = vec![
        Column::text("foveated"),
        Column::new("total", watts()),
        Column::new("accelerator", watts()),
        Column::new("display", watts()),
        Column::fixed("FPS", 0).group("machine"),
    ];
    columns.extend(REGIONS.map(hvsq));
    let row = |f: &FovealRecord| {
        let mut cells: Vec<Cell> = vec![f.label().into()];
        cells.extend([f.total_w(), f.render_w, f.display_w].map(Cell::Real));
        cells.push(f.fps.into());
        cells.extend(f.hvsq.iter().map(|v| e5(*v)));
        cells
    };
    Table::new(columns).rows(r.foveated.iter().map(row))
}

/// Table 1 in kind.
fn methods(page: &mut Document, r: &Results) {
    let most = r.foveated.iter().map(FovealRecord::total_w).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let speed = r.dense_fps.map_or(String::new(), |fps| {
        format!(" The dense model, not foveated, runs at {fps:.0} FPS.")
    });
    let note = r.regions_note().unwrap_or_default();
    page.heading("Methods");
    page.paragraph(format!(
        "FPS: the accelerator's speed at full rate, not a GPU's.{speed} Power: at {} FPS, over the \
         gaze cycle. HVSQ of R1 to R4: of the shown frames. {note} HVSQ of L1 to L4: of the \
         level's model over whole test views, as published. PSNR, SSIM, FLIP and LPIPS: of the \
         model of level 1 on whole test views, for RTGS+D22 behind its filter, whose quality is \
         held to no target.",
        r.fps
    ));
    let watts = |what: &str| Column::fixed(format!("{what}, {unit}"), decimals(per_watt));
    let mut columns = vec![Column::text("method"), Column::fixed("FPS", 0)];
    columns.extend(["total", "display", "accelerator", "of that filter"].map(watts));
    columns.extend(REGIONS.map(|region| Column::fixed(region, 2).group("HVSQ, 1e-5")));
    columns.extend([
        Column::text("HVSQ of L1 to L4, 1e-5"),
        Column::text("Gaussians of L1 to L4"),
        Column::text("levels"),
        Column::fixed("PSNR, dB", 2),
        Column::fixed("SSIM", 4),
        Column::fixed("FLIP", 4),
        Column::fixed("LPIPS", 4),
    ]);
    let row = |f: &FovealRecord| {
        let like = f.likeness(r);
        let or_none = |v: &Option<f64>| v.map_or("none".into(), |v| format!("{:.2}", 1e5 * v));
        let whole: Vec<String> = f.level_hvsq(r).iter().map(or_none).collect();
        let counts: Vec<String> = f.gaussians.iter().map(u64::to_string).collect();
        let states: Vec<String> = f.shown_states().into_iter().map(state).collect();
        let mut cells: Vec<Cell> = vec![f.label().into(), f.fps.into()];
        let watts = [f.total_w(), f.display_w, f.render_w, f.filter_w];
        cells.extend(watts.map(|w| Cell::Real(per_watt * w)));
        cells.extend(f.hvsq.iter().map(|v| e5(*v)));
        cells.extend([whole, counts, states].map(|all| Cell::from(all.join(", "))));
        cells.extend([like.psnr_db, like.ssim, like.flip, like.lpips].map(Cell::from));
        cells
    };
    page.table(Table::new(columns).rows(r.foveated.iter().map(row)));
    for f in r.foveated.iter().filter(|f| f.method != Method::RtgsD22) {
        if let Some(text) = unpruned(r, f) {
            page.paragraph(Text::marked(&text));
        }
    }
}

/// The state of a level in words.
fn state(state: Option<LevelState>) -> String {
    state.map_or_else(|| "held to none".into(), |state| state.name().replace('_', " "))
}

/// What to know of levels whose search found nothing to prune, though they pass.
fn unpruned(r: &Results, f: &FovealRecord) -> Option<String> {
    let levels = f.unpruned();
    let first = *levels.first()?;
    let other = match f.method {
        Method::PowerGs => Method::FrRender,
        Method::FrRender | Method::FrDisplay | Method::RtgsD22 => Method::PowerGs,
    };
    let pruned = r.foveal(other, &f.variant).filter(|other| {
        levels.iter().any(|level| other.gaussians[level - 1] < f.gaussians[level - 1])
    });
    let pruned = pruned.map_or(String::new(), |other| {
        let counts = levels.iter().map(|level| other.gaussians[level - 1].to_string());
        let counts = counts.collect::<Vec<_>>().join(" and ");
        format!("; {} reaches {counts}", other.label())
    });
    let named = levels.iter().map(usize::to_string).collect::<Vec<_>>().join(" and ");
    let keep = if levels.len() == 1 { "keeps" } else { "keep" };
    let s = if levels.len() == 1 { "" } else { "s" };
    let count = f.gaussians[first - 1];
    Some(format!(
        "{}: level{s} {named} {keep} all {count} Gaussians of the level before, because pruning \
         got nowhere within the target{pruned}. More iterations (`--iterations`, \
         `--level-effort`) may get further.",
        f.label()
    ))
}

fn regions(page: &mut Document, r: &Results) {
    let watts = |f: &FovealRecord, i: usize| f.region_j[i] * r.fps;
    let most = r.foveated.iter().flat_map(|f| (0..LEVELS).map(move |i| watts(f, i)));
    let (per_watt, unit) = watt_unit(most.fold(0.0, f64::max));
    page.heading("Regions");
    page.paragraph(format!(
        "Tiles, and sorting and rendering of them on the machine, {unit}; preprocessing, static \
         power and the filter belong to no region."
    ));
    let mut columns = vec![Column::text("method")];
    for region in REGIONS {
        columns.push(Column::fixed("tiles", 1).group(region));
        columns.push(Column::fixed(unit.clone(), 2).group(region));
    }
    let row = |f: &FovealRecord| {
        let pair = |i: usize| [f.tiles[i], per_watt * watts(f, i)].map(Cell::Real);
        [Cell::from(f.label())].into_iter().chain((0..LEVELS).flat_map(pair)).collect::<Vec<_>>()
    };
    page.table(Table::new(columns).rows(r.foveated.iter().map(row)));
}

/// Table 2 in kind: level 1 everywhere.
fn plain(page: &mut Document, r: &Results) {
    let variant = &r.variants[0].name;
    let ours = r.ours(variant).map(|m| m.name.clone());
    let is_shown = |m: &&ModelRecord| {
        let compared = matches!(m.role, RoleKind::Dense | RoleKind::External);
        let is_own = m.role == RoleKind::Baseline && m.variant == *variant;
        m.level == 1 && (compared || is_own || Some(&m.name) == ours.as_ref())
    };
    let mut shown: Vec<&ModelRecord> = r.models.iter().filter(is_shown).collect();
    shown.sort_by(|a, b| b.total_w().total_cmp(&a.total_w()));
    let (per_watt, unit) = watt_unit(shown.first().map_or(0.0, |m| m.total_w()));
    page.heading("Without foveation");
    let columns = [
        Column::text("model"),
        Column::fixed("PSNR, dB", 2),
        Column::fixed("SSIM", 4),
        Column::fixed("FLIP", 4),
        Column::fixed("LPIPS", 4),
        Column::fixed(format!("total, {unit}"), decimals(per_watt)),
    ];
    let row = |m: &ModelRecord| {
        let name = match Some(&m.name) == ours.as_ref() {
            true => format!("PowerGS-{variant} ({})", m.name),
            false => m.name.clone(),
        };
        let quality = [m.test.psnr_db, m.test.ssim, m.flip_test, m.lpips_test];
        let total = Some(per_watt * m.total_w());
        let numbers = quality.into_iter().chain([total]).map(Cell::from);
        [Cell::from(name)].into_iter().chain(numbers).collect::<Vec<_>>()
    };
    page.table(Table::new(columns).rows(shown.into_iter().map(row)));
}

/// The models that are not in the table of level 1.
fn levels(page: &mut Document, r: &Results) {
    let first = &r.variants[0].name;
    let rest: Vec<&ModelRecord> =
        r.models.iter().filter(|m| m.level > 1 || m.variant != *first).collect();
    if rest.is_empty() {
        return;
    }
    let (per_watt, unit) = watt_unit(rest.iter().map(|m| m.total_w()).fold(0.0, f64::max));
    page.heading("Levels and variants");
    page.paragraph(
        "Pruned: of the level before. HVSQ at the pooling of the level, over whole views; power of \
         the level shown everywhere.",
    );
    let watts = |what: &str| Column::fixed(format!("{what}, {unit}"), decimals(per_watt));
    let mut columns = vec![
        Column::text("variant"),
        Column::count("level"),
        Column::text("model"),
        Column::fixed("pruned, %", 1),
        Column::count("Gaussians"),
    ];
    columns.extend(["target", "gate", "test"].map(|of| Column::fixed(of, 2).group("HVSQ, 1e-5")));
    columns.extend([Column::fixed("PSNR, dB", 2), Column::fixed("SSIM", 4)]);
    columns.extend(["display", "accelerator", "total"].map(watts));
    columns.push(Column::text("passed"));
    let row = |m: &ModelRecord| {
        let mut cells: Vec<Cell> = vec![
            m.variant.as_str().into(),
            u32::from(m.level).into(),
            m.name.as_str().into(),
            (100.0 * m.rho).into(),
            m.gaussians.into(),
        ];
        cells.extend([m.target_hvsq, m.gate.hvsq, m.test.hvsq].map(e5));
        cells.extend([m.test.psnr_db, m.test.ssim].map(Cell::from));
        cells.extend([m.display_w, m.render_w, m.total_w()].map(|w| Cell::Real(per_watt * w)));
        cells.push(m.passed.into());
        cells
    };
    page.table(Table::new(columns).rows(rest.into_iter().map(row)));
}

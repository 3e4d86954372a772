//! Tables: the five pairs for people, every pair and every model as CSV.

use std::collections::BTreeSet;

use super::words;
use crate::document::{Cell, Column, Shown, Table};
use crate::format::watt_unit;
use powergs_codesign::Finished;
use powergs_codesign::compare::Comparison;
use powergs_codesign::export::Exported;
use powergs_codesign::pricing::{Fate, MachinePoint, Price};

/// What each of the five ways finds.
pub fn ways(finished: &Finished) -> Table {
    let most = finished.comparisons.iter().filter_map(Comparison::watts).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let watts = |name: &str| Column::fixed(name, 2);
    let columns = [
        Column::text("way"),
        Column::text("how it is chosen").on(Shown::Page),
        Column::text("pair").at_most(34),
        watts(&format!("total, {unit}")),
        watts("display"),
        watts("rendering").on(Shown::Page),
        watts("standby"),
        Column::fixed("area mm²", 2),
        Column::fixed("slowest frame, ms", 3).on(Shown::Page),
        Column::fixed("calibrated total", 2).on(Shown::Page),
    ];
    let row = |comparison: &Comparison| -> Vec<Cell> {
        let way = format!("({})", comparison.way.letter());
        let how = comparison.way.words();
        let Ok(found) = &comparison.found else {
            let words = [way.into(), how.into(), "none keeps the budget".into()];
            return words.into_iter().chain((0..7).map(|_| Cell::Missing)).collect();
        };
        let Price { total_w, display_w, stages_w, area_mm2, frame_ms, .. } = found.confirmed;
        let [preprocessing, sorting, rendering, standby] = stages_w;
        vec![
            way.into(),
            how.into(),
            words::pair(finished, found.pair).into(),
            (per_watt * total_w).into(),
            (per_watt * display_w).into(),
            (per_watt * (preprocessing + sorting + rendering)).into(),
            (per_watt * standby).into(),
            area_mm2.into(),
            frame_ms.into(),
            (per_watt * found.calibrated.total_w).into(),
        ]
    };
    Table::new(columns).rows(finished.comparisons.iter().map(row))
}

/// The machines that the five ways find.
pub fn found(finished: &Finished) -> BTreeSet<MachinePoint> {
    let found = finished.comparisons.iter().filter_map(|c| c.found.as_ref().ok());
    found.map(|found| found.pair.1).collect()
}

/// The machines that the five ways find with what they have on the axes, for terminals.
pub fn found_machines(finished: &Finished) -> Table {
    machines(finished, &found(finished))
}

/// Machines by their numbers, with what they have on the axes.
pub fn machines(finished: &Finished, points: &BTreeSet<MachinePoint>) -> Table {
    let axes = words::axes(finished);
    let mut columns = vec![
        Column::text("machine"),
        Column::text("chosen by"),
        Column::text("settings").on(Shown::Terminal).wraps(),
    ];
    columns.extend(axes.iter().map(|(_, key)| Column::count(*key).on(Shown::Page)));
    let row = |point: &MachinePoint| -> Vec<Cell> {
        let is_theirs = |c: &&Comparison| c.found.as_ref().is_ok_and(|f| f.pair.1 == *point);
        let ways = finished.comparisons.iter().filter(is_theirs).map(|c| c.way.letter());
        let settings = words::settings(finished, *point);
        let value = |(i, _): &(usize, &str)| {
            let value = settings.map(|s| s[*i].as_str()).filter(|value| !value.is_empty());
            Cell::from(value)
        };
        let mut cells: Vec<Cell> = vec![
            words::machine(finished, *point).into(),
            words::letters(ways).into(),
            words::name(finished, *point).into(),
        ];
        cells.extend(axes.iter().map(value));
        cells
    };
    Table::new(columns).rows(points.iter().map(row))
}

/// `pairs.csv`: every pair with its price under the first energy table, with the calibrated model
/// of the DRAM, and its watts under the others.
pub fn pairs_csv(finished: &Finished) -> Vec<u8> {
    let columns = finished.rows.first().map_or(&[][..], |row| &row.columns);
    let text = |name: &str| Column::text(name);
    let mut all: Vec<Column> = ["model", "rho", "sh_degree", "formats", "machine"].map(text).into();
    all.extend(columns.iter().map(|name| text(name)));
    let facts = ["status", "reason", "is_within_budget", "is_on_front"];
    all.extend(facts.map(text));
    let numbers = [
        "total_w",
        "display_power_w",
        "power_w.preprocessing",
        "power_w.sorting",
        "power_w.rendering",
        "power_w.standby",
        "area_mm2",
        "frame_time_ms.max",
        "dram_bytes",
    ];
    all.extend(numbers.map(text));
    all.extend(finished.tables.iter().skip(1).map(|label| text(&format!("total_w ({label})"))));
    let mut table = Table::new(all);
    for (place, (model, row)) in finished.models.iter().zip(&finished.rows).enumerate() {
        for (point, fate) in &row.pairs {
            let mut cells: Vec<Cell> = vec![
                model.point.name().into(),
                model.point.rho.into(),
                u64::from(model.point.sh_degree).into(),
                model.point.format.as_str().into(),
                point.map_or(Cell::Empty, Cell::Count),
            ];
            match row.settings.get(point) {
                Some(settings) => cells.extend(settings.iter().map(|s| Cell::from(s.as_str()))),
                None => cells.extend(columns.iter().map(|_| Cell::Empty)),
            }
            let rest = numbers.len() + finished.tables.len() - 1;
            match fate {
                Fate::Refused(reason) => {
                    cells.extend(["refused".into(), reason.as_str().into()]);
                    cells.extend((0..2 + rest).map(|_| Cell::Empty));
                }
                Fate::Priced(prices) => {
                    let price = &prices[0][0];
                    let is_within = finished.budget.limit(price).is_none();
                    let is_on_front = finished.front.contains(&(place, *point));
                    cells.extend(["priced".into(), Cell::Empty]);
                    cells.extend([is_within.into(), is_on_front.into()]);
                    cells.extend(exact(price));
                    cells.extend(prices.iter().skip(1).map(|p| Cell::from(p[0].total_w)));
                }
            }
            table.row(cells);
        }
    }
    table.csv()
}

fn exact(price: &Price) -> impl Iterator<Item = Cell> {
    let Price { total_w, display_w, stages_w: [a, b, c, d], area_mm2, frame_ms, dram_bytes } =
        *price;
    let numbers = [Some(total_w), Some(display_w), Some(a), Some(b), Some(c), Some(d)];
    let rest = [area_mm2, Some(frame_ms), Some(dram_bytes)];
    numbers.into_iter().chain(rest).map(Cell::from)
}

/// The models for people: what they are, their quality, their best pair.
pub fn models(finished: &Finished) -> Table {
    let columns = [
        Column::text("model"),
        Column::count("Gaussians"),
        Column::fixed("gate, dB", 2),
        Column::fixed("test, dB", 2),
        Column::text("target"),
        Column::fixed("display, W", 4),
        Column::count("iterations"),
    ];
    let row = |model: &powergs_codesign::fit::Fitted| -> Vec<Cell> {
        let facts = &model.facts;
        let db = |db: f64| Some(db).filter(|db| db.is_finite());
        let verdict = match (model.point.is_dense, facts.passed) {
            (true, _) => "reference",
            (_, true) => "reached",
            (_, false) => "missed",
        };
        vec![
            model.point.name().into(),
            facts.points.into(),
            db(facts.gate.quality.psnr_db).into(),
            db(facts.test.quality.psnr_db).into(),
            verdict.into(),
            facts.gate.display_w.into(),
            facts.iterations.into(),
        ]
    };
    Table::new(columns).rows(finished.models.iter().map(row))
}

/// The joint model in compressed formats.
pub fn exports(finished: &Finished) -> Table {
    let columns = [
        Column::text("format"),
        Column::count("bytes"),
        Column::fixed("gate, dB", 2),
        Column::fixed("SSIM", 4),
        Column::text("target"),
    ];
    let row = |export: &Exported| -> Vec<Cell> {
        let verdict = match &export.file {
            Ok(_) if export.passed => "reached",
            Ok(_) => "missed",
            Err(why) => why,
        };
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let quality = export.gate.map(|gate| gate.quality);
        vec![
            export.target.name().into(),
            export.bytes().into(),
            quality.and_then(|q| finite(q.psnr_db)).into(),
            quality.and_then(|q| finite(q.ssim)).into(),
            verdict.into(),
        ]
    };
    Table::new(columns).rows(finished.exports.iter().map(row))
}

/// `models.csv`: every model with its quality on both splits.
pub fn models_csv(finished: &Finished) -> Vec<u8> {
    let keys = "model rho sh_degree formats codebook gaussians iterations lambda_per_w \
                gate_psnr_db gate_ssim gate_display_w passed test_psnr_db test_ssim";
    let row = |model: &powergs_codesign::fit::Fitted| -> Vec<Cell> {
        let (point, facts) = (&model.point, &model.facts);
        let finite = |x: f64| Cell::from(Some(x).filter(|x| x.is_finite()));
        vec![
            point.name().into(),
            point.rho.into(),
            u64::from(point.sh_degree).into(),
            point.format.as_str().into(),
            point.formats.codebook.map_or(0, |entries| entries.get()).into(),
            facts.points.into(),
            facts.iterations.into(),
            facts.lambda.into(),
            finite(facts.gate.quality.psnr_db),
            facts.gate.quality.ssim.into(),
            facts.gate.display_w.into(),
            facts.passed.into(),
            finite(facts.test.quality.psnr_db),
            facts.test.quality.ssim.into(),
        ]
    };
    Table::record(keys).rows(finished.models.iter().map(row)).csv()
}

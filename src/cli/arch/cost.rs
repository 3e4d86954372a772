//! Area and peak power of a machine by block, as `arch check` and `arch show --cost` print them.

use serde_json::{Map, Value, json};

use powergs_core::accel::Machine;
use powergs_core::energy::{Area, Prices};
use powergs_core::sim::cost::peak_w;
use powergs_report::document::{Column, Document, Table};

/// What a machine takes in silicon and, at most, in power.
#[derive(Debug, Clone)]
pub struct Cost {
    area: Option<Area>,
    peak_w: Vec<(&'static str, f64)>,
}

impl Cost {
    /// Of a machine.
    pub fn new(machine: &Machine, prices: &Prices) -> Cost {
        Cost { area: prices.area, peak_w: peak_w(machine, prices) }
    }

    fn total_w(&self) -> f64 {
        self.peak_w.iter().map(|(_, watts)| watts).sum()
    }

    /// For people; blocks that take nothing are left out.
    pub fn document(&self) -> Document {
        let columns = [Column::text("block"), Column::real("area mm2"), Column::real("peak mW")];
        let mut table = Table::new(columns);
        let mut row = |name: &str, area: Option<f64>, watts: Option<f64>| {
            if area.unwrap_or(0.0) != 0.0 || watts.unwrap_or(0.0) != 0.0 {
                table.row([name.into(), area.into(), watts.map(|w| w * 1e3).into()]);
            }
        };
        for (i, (name, _)) in Area::default().blocks().into_iter().enumerate() {
            let area = self.area.map(|a| a.blocks()[i].1.0);
            let watts = self.peak_w.iter().find(|(block, _)| *block == name).map(|(_, w)| *w);
            row(name, area, watts);
        }
        row("total", self.area.map(|a| a.total().0), Some(self.total_w()));
        let mut page = Document::new();
        page.table(table);
        page
    }

    /// As JSON.
    pub fn json(&self) -> Value {
        let area = self.area.map(|a| {
            let blocks = a.blocks().into_iter().map(|(name, x)| (name.to_owned(), json!(x.0)));
            let total = ("total".to_owned(), json!(a.total().0));
            std::iter::once(total).chain(blocks).collect::<Map<_, _>>()
        });
        let blocks = self.peak_w.iter().map(|(name, watts)| ((*name).to_owned(), json!(watts)));
        let total = ("total".to_owned(), json!(self.total_w()));
        let peak: Map<_, _> = std::iter::once(total).chain(blocks).collect();
        json!({ "area_mm2": area, "peak_power_w": peak })
    }
}

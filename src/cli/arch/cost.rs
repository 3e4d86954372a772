//! Area and peak power of a machine by block, as `arch check` and `arch show --cost` print them.

use serde_json::{Map, Value, json};

use powergs_base::quantity::Hertz;
use powergs_core::machine::Machine;
use powergs_core::sim::cost::{peak_w, untimed};
use powergs_core::stage::{EnergyTable, hardware};
use powergs_energy::table::NodeStep;
use powergs_energy::{Area, Block, Prices, Supply};
use powergs_report::document::{Column, Document, Table};

/// What a machine takes in silicon and, at most, in power.
#[derive(Debug, Clone)]
pub struct Cost {
    area: Option<Area>,
    peak_w: Vec<(&'static str, f64)>,
    phy_standby_w: f64,
    supply: Option<Supply>,
    /// The clock of prices that are as given at any.
    fixed_clock: Option<Hertz>,
    step: Option<NodeStep>,
    clock: Hertz,
    channels: f64,
    dram_standby_w: [f64; 2],
}

impl Cost {
    /// Of a machine with the prices of a table.
    pub fn new(machine: &Machine, table: &EnergyTable, prices: &Prices) -> Cost {
        Cost {
            area: prices.area.clone(),
            peak_w: peak_w(machine, prices),
            phy_standby_w: prices.phy_standby_w,
            supply: prices.supply,
            fixed_clock: table.fixed_clock(),
            step: table.node_step(),
            clock: machine.clock,
            channels: untimed(machine)[1],
            dram_standby_w: prices.dram.standby_w().map(|watts| watts * prices.standby_share),
        }
    }

    fn total_w(&self) -> f64 {
        self.peak_w.iter().map(|(_, watts)| watts).sum()
    }

    /// For people; blocks that take nothing are left out.
    pub fn document(&self) -> Document {
        let columns = [Column::text("block"), Column::real("area mm²"), Column::real("peak mW")];
        let mut table = Table::new(columns);
        let mut row = |name: &str, area: Option<f64>, watts: Option<f64>| {
            if area.unwrap_or(0.0) != 0.0 || watts.unwrap_or(0.0) != 0.0 {
                table.row([name.into(), area.into(), watts.map(|w| w * 1e3).into()]);
            }
        };
        for (i, Block { name, .. }) in Area::blocks(hardware()).into_iter().enumerate() {
            let area = self.area.as_ref().map(|a| a.areas()[i].0);
            let watts = self.peak_w.iter().find(|(block, _)| *block == name).map(|(_, w)| *w);
            row(name, area, watts);
        }
        row("core", self.area.as_ref().map(|a| a.core().0), Some(self.total_w()));
        row("die", self.area.as_ref().map(|a| a.total().0), None);
        let mut page = Document::new();
        page.table(table);
        page.facts(self.beside());
        page
    }

    /// What is no block of the chip: its supply, and the memory.
    fn beside(&self) -> Vec<(&'static str, String)> {
        let mut facts = Vec::new();
        facts.push(match self.supply {
            Some(s) => (
                "supply",
                format!(
                    "{:.3} V at {}; energy x {:.3}, leakage x {:.3}; at most {:.2} GHz",
                    s.voltage,
                    self.clock,
                    s.energy,
                    s.leakage,
                    (s.highest_clock * 1e-7).floor() * 1e-2
                ),
            ),
            None => {
                let own =
                    self.fixed_clock.map_or(String::new(), |own| format!(", those for {own}"));
                let text = format!("no voltage-frequency curve: prices as given at any clock{own}");
                ("supply", text)
            }
        });
        if let Some(step) = &self.step {
            let of = |(name, factor): &(&str, f64)| format!("{factor} ({name})");
            let all = step.others.iter().map(of).collect::<Vec<_>>().join(", ");
            let (from, to, energy) = (step.from, step.to, step.energy);
            let text = format!("energy x {energy} from {from} to {to}; published steps: {all}");
            facts.push(("node", text));
        }
        let [background, refresh] = self.dram_standby_w.map(|w| w * 1e3);
        let channels = format!("{} channels", (self.channels * 100.0).round() / 100.0);
        let text = format!(
            "{background:.1} mW background, {refresh:.1} mW refresh, {:.1} mW of the PHY, of \
             {channels}",
            self.phy_standby_w * 1e3
        );
        facts.push(("memory standby", text));
        facts
    }

    /// As JSON.
    pub fn json(&self) -> Value {
        let area = self.area.as_ref().map(|a| {
            let names = Area::blocks(hardware()).into_iter().map(|block| block.name.to_owned());
            let blocks = names.zip(a.areas()).map(|(name, x)| (name, json!(x.0)));
            let total = ("total".to_owned(), json!(a.total().0));
            let core = ("core".to_owned(), json!(a.core().0));
            [total, core].into_iter().chain(blocks).collect::<Map<_, _>>()
        });
        let blocks = self.peak_w.iter().map(|(name, watts)| ((*name).to_owned(), json!(watts)));
        let total = ("total".to_owned(), json!(self.total_w()));
        let peak: Map<_, _> = std::iter::once(total).chain(blocks).collect();
        let supply = self.supply.map(|s| {
            json!({
                "voltage_v": s.voltage,
                "energy_factor": s.energy,
                "leakage_factor": s.leakage,
                "highest_clock_hz": s.highest_clock,
            })
        });
        let [background, refresh] = self.dram_standby_w;
        let step = self.step.as_ref().map(|step| {
            let others = step.others.iter().map(|(name, x)| ((*name).to_owned(), json!(x)));
            json!({
                "from": step.from.to_string(),
                "to": step.to.to_string(),
                "energy_factor": step.energy,
                "published": others.collect::<Map<_, _>>(),
            })
        });
        json!({
            "area_mm2": area,
            "peak_power_w": peak,
            "phy_standby_w": self.phy_standby_w,
            "channels": self.channels,
            "dram_background_w": background,
            "dram_refresh_w": refresh,
            "supply": supply,
            "node": step,
        })
    }
}

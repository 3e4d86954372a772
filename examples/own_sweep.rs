//! A sweep of one's own without a sweep file: nine designs on a trace, and which of them to keep.
//!
//! ```console
//! $ cargo run --release --example own_sweep -- traces/demo.bin
//! ```

use std::error::Error;
use std::path::Path;

use powergs_sim::run::{MemoryStore, System, TraceFile};
use powergs_sim::study::analysis::{Analysis, Question, Table};
use powergs_sim::study::sweep::file::Objectives;
use powergs_sim::study::sweep::run::Sweep;

fn main() -> Result<(), Box<dyn Error>> {
    let trace = std::env::args().nth(1).unwrap_or_else(|| "traces/demo.bin".to_owned());
    let mut trace = TraceFile::open(Path::new(&trace))?;
    // With `FileStore::new("some/folder")` a run that was stopped continues where it was.
    let store = MemoryStore::new();
    let results = Sweep::over(System::named("gscore")?)
        .axis("vru.cores", [2, 4, 8])
        .axis("ccu.units", [2, 4, 8])
        .constraint("vru.cores * ccu.units <= 32")
        .run(&mut trace, &store, &())?;
    println!("{:>10} {:>10} {:>9} {:>9} {:>9}", "VRU cores", "CCU units", "FPS", "uJ/frame", "mm2");
    for row in results.means() {
        let number = |column: &str| results.number(row, column).unwrap_or(f64::NAN);
        println!(
            "{:>10} {:>10} {:>9.0} {:>9.1} {:>9.3}",
            number("vru.cores"),
            number("ccu.units"),
            number("fps.mean"),
            number("energy_pj.mean") * 1e-6,
            number("area_mm2"),
        );
    }
    let question = Question::of(Objectives::default().all());
    let table = Table::of(&results, &question)?;
    let analysis = Analysis::of(&table, &question)?;
    println!("\nNothing is faster, smaller and thriftier than any of these:");
    for &row in &analysis.front {
        let settings: Vec<String> =
            table.settings(row).iter().map(|(key, value)| format!("{key} = {value}")).collect();
        let knee = if row == analysis.knee { "  <- knee" } else { "" };
        println!("{:>9}  {}{knee}", table.label(row), settings.join(", "));
    }
    Ok(())
}

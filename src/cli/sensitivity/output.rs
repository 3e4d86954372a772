//! The report folder of an experiment, and what is printed.

use serde_json::Value;

use super::{SensitivityArgs, SensitivityResults};
use crate::cli::run_folder::RunFolder;
use crate::cli::{Exit, Failure, OrExit};
use powergs_core::run::{Input, System, TraceFile};
use powergs_core::sim::made_by;
use powergs_report::Drawing;
use powergs_report::document::Document;
use powergs_report::sensitivity::{self, interactions, keys};
use powergs_study::sensitivity::KeyResults;

/// Writes tables, charts and summary; returns the main table.
///
/// # Errors
/// Exit code 2 for a folder that cannot be written, 4 for a defect.
pub fn write(
    folder: &RunFolder,
    found: &SensitivityResults,
    drawing: &Drawing,
) -> Result<Vec<u8>, Failure> {
    match found {
        SensitivityResults::Assumptions(all) => {
            let table = sensitivity::csv(all);
            folder.write("sensitivity.csv", &table)?;
            let charts = sensitivity::charts(all);
            let page = sensitivity::document(all, &charts, None);
            folder.write_pages(&page, drawing)?;
            folder.write_charts(&charts, drawing)?;
            Ok(table)
        }
        SensitivityResults::Keys(KeyResults { keys: all, interactions: together }) => {
            folder.write("sensitivity.csv", &keys::csv(all))?;
            let mut table = keys::elasticities_csv(all);
            folder.write("elasticity.csv", &table)?;
            let charts = keys::charts(all);
            let mut page = keys::document(all, &charts, None);
            folder.write_charts(&charts, drawing)?;
            if let Some(together) = together {
                table = interactions::csv(together);
                folder.write("interactions.csv", &table)?;
                folder.write("designs.csv", &interactions::designs_csv(together))?;
                let charts = interactions::charts(together);
                page.extend(interactions::document(together, &charts, None));
                folder.write_charts(&charts, drawing)?;
            }
            folder.write_pages(&page, drawing)?;
            Ok(table)
        }
    }
}

/// What is printed for programs.
pub fn json(found: &SensitivityResults) -> Value {
    match found {
        SensitivityResults::Assumptions(all) => sensitivity::json(all),
        SensitivityResults::Keys(KeyResults { keys: all, interactions: together }) => {
            let mut value = keys::json(all);
            value["interactions"] = together.as_ref().map_or(Value::Null, interactions::json);
            value
        }
    }
}

/// What is printed for people.
pub fn document(found: &SensitivityResults, folder: &str) -> Document {
    match found {
        SensitivityResults::Assumptions(all) => sensitivity::document(all, &[], Some(folder)),
        SensitivityResults::Keys(KeyResults { keys: all, interactions: None }) => {
            keys::document(all, &[], Some(folder))
        }
        SensitivityResults::Keys(KeyResults { keys: all, interactions: Some(together) }) => {
            let mut page = keys::document(all, &[], None);
            page.extend(interactions::document(together, &[], Some(folder)));
            page
        }
    }
}

/// `run.toml`: versions, inputs, what was asked for, configuration.
///
/// # Errors
/// Exit code 4: a defect.
pub fn record(
    args: &SensitivityArgs,
    system: &System,
    sources: &[TraceFile],
) -> Result<String, Failure> {
    let mut inputs = system.inputs();
    inputs.extend(sources.iter().map(|s| s.input().clone()));
    let input = |i: &Input| {
        let mut table = toml::Table::new();
        table.insert("role".into(), i.role.into());
        table.insert("name".into(), i.name.clone().into());
        table.insert("bytes".into(), (i.bytes as i64).into());
        table.insert("xxh3".into(), format!("{:032x}", i.xxh3).into());
        toml::Value::Table(table)
    };
    let mut table = toml::Table::new();
    made_by(&mut table);
    table.insert("inputs".into(), inputs.iter().map(input).collect::<Vec<_>>().into());
    table.insert("experiment".into(), experiment(args).into());
    let machine: toml::Table =
        system.machine_toml().parse().or_exit(Exit::Internal, &system.machine().name)?;
    table.insert("machine".into(), machine.into());
    Ok(table.to_string())
}

/// What decides the numbers besides the inputs.
fn experiment(args: &SensitivityArgs) -> toml::Table {
    let mut table = toml::Table::new();
    table.insert("display-fps".into(), args.shown.fps.into());
    if args.assumptions {
        table.insert("varied".into(), "assumptions".into());
        return table;
    }
    table.insert("varied".into(), "keys".into());
    table.insert("step".into(), args.step.into());
    let keys: Vec<String> = args.keys.iter().map(|(text, _)| text.clone()).collect();
    table.insert("keys".into(), keys.into());
    if let Some(method) = args.interactions {
        table.insert("interactions".into(), format!("{method:?}").to_lowercase().into());
        if let Some(n) = args.samples {
            table.insert("samples".into(), i64::from(n).into());
        }
        // TOML has no larger integers.
        table.insert("seed".into(), args.seed.to_string().into());
    }
    table
}

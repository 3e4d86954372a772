//! The commands of the laboratory on the pages and in its help: flags and names that exist. They
//! run in `.ci/lab`.

use std::path::Path;

use clap::{CommandFactory, Parser};
use powergs_lab::Cli;
use powergs_testkit::docs::{blocks, commands, pages, words};

const PROGRAM: &str = "powergs-lab";

fn mistake(command: &str) -> Option<String> {
    let error = Cli::try_parse_from(words(command)).err()?;
    error.use_stderr().then(|| format!("{command}\n{error}"))
}

#[test]
fn commands_of_the_pages_have_flags_that_exist() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let (mut seen, mut wrong) = (0, Vec::new());
    for page in pages(root, &["README.md", "rtl/README.md", "lab/README.md"]) {
        for block in blocks(root, &page, PROGRAM) {
            for command in block.commands.iter().filter(|c| c.starts_with(PROGRAM)) {
                seen += 1;
                wrong.extend(mistake(command).map(|mistake| format!("{}: {mistake}", block.place)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen > 10, "{seen}");
}

#[test]
fn examples_of_the_help_have_flags_that_exist_and_fit() {
    Cli::command().debug_assert();
    for command in Cli::command().get_subcommands() {
        let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        let examples: Vec<&str> = help.lines().filter_map(|l| l.strip_prefix("  ")).collect();
        let examples = commands(&examples.join("\n"), PROGRAM);
        assert!(!examples.is_empty(), "{}", command.get_name());
        assert!(help.lines().all(|line| line.chars().count() <= 80), "{}", command.get_name());
        for example in examples.iter().filter(|c| c.starts_with(PROGRAM)) {
            assert_eq!(mistake(example), None);
        }
    }
}

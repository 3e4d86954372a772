//! The gates of a unit: those that come with the program, or the user's own.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use powergs_gates::committed;
use powergs_gates::liberty::library::Library;
use powergs_gates::liberty::unpack;
use powergs_gates::netlist::Netlist;
use powergs_gates::price::{Conditions, price};
use powergs_gates::yosys::Mapped;
use powergs_sim::cli::{Exit, Failure, OrExit};

/// Bytes of a file that are read at most.
const FILE_MAX: u64 = 1 << 30;

/// Which gates are simulated.
#[derive(Debug, clap::Args)]
pub struct Gates {
    /// The library that the unit is mapped to
    #[arg(long, value_enum, value_name = "LIB")]
    #[arg(required_unless_present = "netlist", conflicts_with = "netlist")]
    library: Option<Node>,
    /// Your own mapping of the unit: UNIT.json of rtl/synth/synthesise.py, with its report.json
    /// beside it and --liberty, or a .gates file with its prices
    #[arg(long, value_name = "FILE")]
    netlist: Option<PathBuf>,
    /// Liberty file of the cells in --netlist, plain or gzip; repeat it where there are several
    #[arg(long, value_name = "FILE", requires = "netlist", conflicts_with = "library")]
    liberty: Vec<PathBuf>,
}

/// Libraries of the committed netlists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Node {
    /// Nangate45, 1.1 V
    #[value(name = "45nm")]
    Nm45,
    /// ASAP7, 0.7 V
    #[value(name = "7nm")]
    Nm7,
}

impl Gates {
    /// The user's file, for messages; `None` where the gates come with the program.
    pub fn file(&self) -> Option<&Path> {
        self.netlist.as_deref()
    }

    /// The gates of a unit, with the price of each toggle.
    ///
    /// # Errors
    /// Exit code 2: there is no committed netlist of it. Exit code 3: a file cannot be read, or is
    /// not what it should be.
    pub fn of(&self, unit: &str) -> Result<Netlist, Failure> {
        let Some(path) = &self.netlist else {
            let node = if self.library == Some(Node::Nm7) { "7nm" } else { "45nm" };
            let missing = || {
                let what = format!("{unit}: no netlist for {node}; give your own with --netlist");
                Failure::new(Exit::Usage, what)
            };
            return committed::netlist(unit, node).ok_or_else(missing);
        };
        let (name, bytes) = read(path)?;
        if self.liberty.is_empty() {
            if bytes.trim_ascii_start().starts_with(b"{") {
                let what = format!("{name}: it has no prices; give its library with --liberty");
                return Err(Failure::new(Exit::Usage, what));
            }
            return Netlist::from_bytes(&name, &bytes).or_exit(Exit::BadInput, "--netlist");
        }
        let mapped =
            Mapped::parse(&name, &text(&name, bytes)?).or_exit(Exit::BadInput, "--netlist")?;
        let (report, bytes) = read(&path.with_file_name("report.json"))?;
        let conditions = Conditions::parse(&report, &text(&report, bytes)?);
        let conditions = conditions.or_exit(Exit::BadInput, "--netlist")?;
        let mut texts = Vec::new();
        for path in &self.liberty {
            let (name, bytes) = read(path)?;
            let text = unpack(&name, &bytes).or_exit(Exit::BadInput, "--liberty")?;
            texts.push((name, text));
        }
        let texts: Vec<_> =
            texts.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
        let library = Library::parse(&texts).or_exit(Exit::BadInput, "--liberty")?;
        let priced = price(&mapped, &library, &conditions).or_exit(Exit::BadInput, &name)?;
        Ok(priced.netlist)
    }
}

/// The name of a file, and its bytes.
fn read(path: &Path) -> Result<(String, Vec<u8>), Failure> {
    let name = path.display().to_string();
    let file = File::open(path).or_exit(Exit::BadInput, &name)?;
    let mut bytes = Vec::new();
    file.take(FILE_MAX + 1).read_to_end(&mut bytes).or_exit(Exit::BadInput, &name)?;
    if bytes.len() as u64 > FILE_MAX {
        return Err(Failure::new(Exit::BadInput, format!("{name}: larger than 1 GiB")));
    }
    Ok((name, bytes))
}

fn text(name: &str, bytes: Vec<u8>) -> Result<String, Failure> {
    let what = format!("{name}: not UTF-8 text; a netlist of synthesise.py is JSON");
    String::from_utf8(bytes).map_err(|_| Failure::new(Exit::BadInput, what))
}

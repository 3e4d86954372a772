//! `invocation.toml`: what was typed, where and when. Kept apart from everything else, so that the
//! rest of a report does not depend on it.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use powergs_base::build::Build;
use powergs_core::sim::MODEL_VERSION;
use powergs_frame::trace::VERSION;
use toml::Table;

/// What was typed, where it is not what this process was started with.
static TYPED: OnceLock<Vec<OsString>> = OnceLock::new();

/// Says what was typed, once: the program lives in a process that was started with something else.
pub fn typed(words: Vec<OsString>) {
    let _ = TYPED.set(words);
}

/// The words of the command, the program first.
pub fn words() -> Vec<OsString> {
    TYPED.get().cloned().unwrap_or_else(|| std::env::args_os().collect())
}

/// The words of the command as people read them.
pub fn shown_words() -> Vec<String> {
    words().iter().map(|word| word.to_string_lossy().into_owned()).collect()
}

/// The file that starts this program.
///
/// # Errors
/// What the system says.
pub fn program() -> std::io::Result<PathBuf> {
    match TYPED.get().and_then(|words| words.first()) {
        Some(program) => std::path::absolute(program),
        None => std::env::current_exe(),
    }
}

/// When a command began.
#[derive(Debug, Clone, Copy)]
pub struct Started(SystemTime);

impl Started {
    /// Now.
    pub fn now() -> Self {
        Self(SystemTime::now())
    }

    /// The file, at the end of the command.
    pub fn invocation_toml(self) -> String {
        let mut table = Table::new();
        table.insert("command".into(), shown_words().into());
        let folder = std::env::current_dir().unwrap_or_default();
        table.insert("working-folder".into(), folder.to_string_lossy().into_owned().into());
        table.insert("started".into(), utc(self.0).into());
        let wall = self.0.elapsed().unwrap_or_default();
        table.insert("wall-s".into(), ((wall.as_secs_f64() * 1e3).round() / 1e3).into());
        table.insert("platform".into(), platform().into());
        table.to_string()
    }
}

/// The commit that the program was built from, or `unknown`.
const COMMIT: &str = env!("POWERGS_COMMIT");

/// What it is made of.
pub const BUILD: Build =
    Build { commit: COMMIT, models: MODEL_VERSION, traces: [VERSION.0, VERSION.1] };

/// What `--version` says behind the name: versions of the program, of the models and of the traces
/// that it writes, and the commit.
pub fn built() -> String {
    let (major, minor) = VERSION;
    let version = env!("CARGO_PKG_VERSION");
    let models = format!("models    version {MODEL_VERSION}");
    format!("{version}\n{models}\ntraces    version {major}.{minor}\ncommit    {COMMIT}")
}

fn platform() -> String {
    format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS)
}

/// RFC 3339 in UTC, to the second.
fn utc(time: SystemTime) -> String {
    format_utc(time.duration_since(UNIX_EPOCH).unwrap_or_default())
}

/// RFC 3339 of a time since 1970, in UTC, to the second.
pub fn format_utc(since_1970: Duration) -> String {
    let seconds = since_1970.as_secs();
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    // Civil date from days (Hinnant): years begin in March, so that the leap day is the last.
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    let (h, m, s) = (rest / 3_600, rest / 60 % 60, rest % 60);
    format!("{year:04}-{month:02}-{day:02}T{h:02}:{m:02}:{s:02}Z")
}

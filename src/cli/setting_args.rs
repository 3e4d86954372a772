//! The settings of the optimiser as flags, made from their declaration.

use std::ffi::OsString;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, ArgGroup, ArgMatches, Command, value_parser};

use super::slurm::flag;
use powergs_codesign::run::FIT_SETTINGS;
use powergs_optimize::invalid::Invalid;
use powergs_optimize::settings::{Kind, Mark, SETTINGS, Setting, Settings, Value};

/// The settings of a command, with their defaults where nothing else was typed.
#[derive(Debug)]
pub struct SettingArgs<const WHOLE: bool>(Vec<(&'static Setting, Value)>);

/// All settings.
pub type SearchSettings = SettingArgs<true>;

/// Those of a fine-tune, but for its iterations.
pub type FitSettings = SettingArgs<false>;

impl<const WHOLE: bool> SettingArgs<WHOLE> {
    /// What was typed, checked.
    ///
    /// # Errors
    /// [`Invalid::Range`].
    pub fn settings(&self) -> Result<Settings, Invalid> {
        Settings::with(&self.0)
    }

    /// The same as words of a command line.
    pub fn words(&self) -> impl Iterator<Item = OsString> {
        self.0.iter().map(|(setting, value)| flag(setting.flag, value.to_string()))
    }

    fn offered() -> impl Iterator<Item = &'static Setting> {
        let is_of_fit = |key: &str| key != "iterations" && FIT_SETTINGS.contains(&key);
        SETTINGS.iter().filter(move |setting| WHOLE || is_of_fit(setting.key))
    }
}

impl<const WHOLE: bool> clap::FromArgMatches for SettingArgs<WHOLE> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = Self::offered().filter_map(|setting| Some((setting, typed(setting, matches)?)));
        Ok(SettingArgs(given.collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<const WHOLE: bool> clap::Args for SettingArgs<WHOLE> {
    fn group_id() -> Option<clap::Id> {
        Some("SettingArgs".into())
    }

    fn augment_args(command: Command) -> Command {
        let mut settings: Vec<&Setting> = Self::offered().collect();
        settings.sort_by_key(|setting| !setting.is(Mark::First));
        let keys = settings.iter().map(|setting| setting.key);
        let group = ArgGroup::new("SettingArgs").multiple(true).args(keys);
        command.group(group).args(settings.into_iter().map(arg))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

fn arg(setting: &Setting) -> Arg {
    let arg = Arg::new(setting.key)
        .long(setting.flag)
        .value_name(setting.value_name)
        .help(setting.help())
        .help_heading(setting.part)
        .hide_short_help(!setting.is(Mark::Common));
    let arg = match setting.kind {
        Kind::Count(_, high) if high <= u32::MAX.into() => {
            arg.value_parser(value_parser!(u32).map(u64::from))
        }
        Kind::Count(..) => arg.value_parser(value_parser!(u64)),
        Kind::Real(..) => arg.value_parser(value_parser!(f64)),
        Kind::Name(names) => {
            let names = names().into_iter().map(|(name, what)| PossibleValue::new(name).help(what));
            arg.value_parser(PossibleValuesParser::new(names))
        }
    };
    match setting.is(Mark::Follows) {
        true => arg,
        false => arg.default_value(setting.of(&Settings::DEFAULT).to_string()),
    }
}

/// Nothing where the setting has no default and was not typed.
fn typed(setting: &Setting, matches: &ArgMatches) -> Option<Value> {
    let key = setting.key;
    match setting.kind {
        Kind::Count(..) => matches.get_one::<u64>(key).map(|n| Value::Count(*n)),
        Kind::Real(..) => matches.get_one::<f64>(key).map(|x| Value::Real(*x)),
        Kind::Name(_) => setting.named(matches.get_one::<String>(key)?).ok(),
    }
}

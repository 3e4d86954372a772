//! A co-design as an array job of Slurm.

use std::ffi::OsString;
use std::path::Path;

use clap::ValueEnum;

use super::super::power_views::PowerViewArgs;
use super::super::slurm::{SlurmParts, flag};
use super::super::training_args::{LikenessArgs, TrainingViewArgs};
use super::super::{Exit, Failure};
use super::folder::Existing;
use super::{CodesignArgs, LevelArg, QualityArgs, Run, SearchArgs, ViewArgs};

/// The parts of a co-design, each some of its models.
pub struct CodesignParts<'a> {
    /// What was typed.
    pub args: &'a CodesignArgs,
    /// The co-design, checked, and its folder.
    pub run: Run<'a>,
}

impl SlurmParts for CodesignParts<'_> {
    const COMMAND: &'static str = "codesign";

    fn arguments(&self) -> Vec<OsString> {
        let CodesignArgs { dense, demo, space, views, power, quality, search, .. } = self.args;
        let mut words: Vec<OsString> = dense.model.iter().map(OsString::from).collect();
        words.extend(demo.then(|| "--demo".into()));
        words.extend(dense.detail.map(|n| flag("detail", n.to_string())));
        words.extend(dense.axes.map(|axes| flag("axes", axes.to_string())));
        words.extend(space.as_ref().map(|path| flag("space", path)));
        words.extend(of_views(views));
        words.extend(of_power(power));
        words.extend(of_quality(quality));
        words.extend(of_search(search));
        words.push(flag("memory", self.run.context.global.memory.to_string()));
        words
    }

    fn finish(&self, out: &Path) -> Vec<OsString> {
        let mut words = vec![Self::COMMAND.into()];
        words.extend(self.arguments());
        words.push(flag("rounds", self.args.search.rounds.to_string()));
        words.extend([flag("out", out), "--resume".into()]);
        words
    }

    fn begin(&self, _: &Path) -> Result<(), Failure> {
        self.run.folder.begin_parts(self.args.run.existing(), &self.run.about()?)
    }

    fn end(self, _: &Path) -> Result<Exit, Failure> {
        self.run.whole(Existing::Resume)
    }
}

fn of_power(power: &PowerViewArgs) -> Vec<OsString> {
    let PowerViewArgs { power_size, power_cameras, power_stereo } = power;
    let words = [
        power_size.map(|(width, height)| flag("power-size", format!("{width}x{height}"))),
        power_cameras.as_ref().map(|path| flag("power-cameras", path)),
        power_stereo.map(|distance| flag("power-stereo", distance.to_string())),
    ];
    words.into_iter().flatten().collect()
}

fn of_views(views: &ViewArgs) -> Vec<OsString> {
    let ViewArgs { seen, size } = views;
    let TrainingViewArgs { cameras, orbit, every, background, validation } = seen;
    let words = [
        cameras.as_ref().map(|path| flag("cameras", path)),
        orbit.map(|n| flag("orbit", n.to_string())),
        every.map(|k| flag("every", k.to_string())),
        size.map(|(width, height)| flag("size", format!("{width}x{height}"))),
        background.map(|colour| flag("background", colour.to_string())),
        validation.map(|k| flag("validation", k.to_string())),
    ];
    words.into_iter().flatten().collect()
}

fn of_quality(quality: &QualityArgs) -> Vec<OsString> {
    let QualityArgs { quality, likeness } = quality;
    let LikenessArgs { quality_db, quality_ssim } = likeness;
    let level = |level: LevelArg| Some(flag("quality", level.to_possible_value()?.get_name()));
    let words = [
        quality.and_then(level),
        quality_db.map(|db| flag("quality-db", db.to_string())),
        quality_ssim.map(|ssim| flag("quality-ssim", ssim.to_string())),
    ];
    words.into_iter().flatten().collect()
}

/// Without the rounds: a part has none.
fn of_search(search: &SearchArgs) -> Vec<OsString> {
    let SearchArgs { iterations, rounds: _, halving: _, settings } = search;
    let iterations = iterations.map(|n| flag("iterations", n.to_string()));
    iterations.into_iter().chain(settings.words()).collect()
}

//! An optimisation of one's own: a synthetic scene, its quality against its own renders, and the
//! fewest watts at that quality, in memory.
//!
//! ```console
//! $ cargo run --release --example own_campaign
//! ```

use std::error::Error;

use powergs_sim::model::scene::Camera;
use powergs_sim::model::scene::camera::edit::resized;
use powergs_sim::model::scene::synth::{Preset, cameras, generate};
use powergs_sim::run::Display;
use powergs_sim::run::files::{EmbeddedFiles, Files};
use powergs_sim::run::{FileKind, MemoryStore, Watch};
use powergs_sim::study::optimize::campaign::{Campaign, Finished};
use powergs_sim::study::optimize::oracle::PaperOracle;
use powergs_sim::study::optimize::outcome::Outcome;
use powergs_sim::study::optimize::request::{Goal, Goals, Request};
use powergs_sim::study::optimize::role::Baseline;
use powergs_sim::study::optimize::schedule::Schedule;
use powergs_sim::study::optimize::settings::Settings;
use powergs_sim::study::optimize::watch::CampaignWatch;

/// Says what becomes of each model; `is_cancelled` would stop the campaign after an iteration.
struct Talks;

impl Watch for Talks {}

impl CampaignWatch for Talks {
    fn outcome(&self, model: &Outcome) {
        let (quality, watts) = (model.gate.quality, model.watts);
        println!(
            "{:12} {:5} Gaussians {:6.2} dB {:6.2} mW rendering + {:5.2} mW display",
            model.name,
            model.points,
            quality.psnr_db,
            1e3 * watts.render_w,
            1e3 * watts.display_w
        );
    }
}

/// The fewest watts at 30 dB.
///
/// # Errors
/// Everything that [`Campaign`] refuses.
pub fn optimise() -> Result<Finished, Box<dyn Error>> {
    let preset = Preset::named("demo").ok_or("no such preset")?;
    let views: Vec<Camera> =
        cameras(preset).into_iter().step_by(3).map(|view| resized(&view, 64, 48)).collect();
    let file = EmbeddedFiles.read(FileKind::Display, "oled-powergs", None)?;
    let display = Display::parse(&file.text)?;
    // `CycleOracle` asks a simulated machine in its place.
    let oracle = PaperOracle::published(60.0)?;
    let request = Request {
        display_ratio: Some(2.0),
        goals: Goals {
            goal: Some(Goal::Absolute { psnr_db: 30.0, ssim: 0.0 }),
            schedule: Schedule::listed(&[0.0, 0.2, 0.4])?,
            baselines: vec![Baseline::RenderOnly],
            ..Goals::default()
        },
        settings: Settings { iterations: 40, final_iterations: 60, ..Settings::DEFAULT },
        ..Request::new("demo", generate(preset, 600, 3), views, oracle, display)
    };
    // With `FileStore::new("some/folder")` a run that was stopped continues where it was.
    let finished = Campaign::open(request, &Talks)?.run(&MemoryStore::new(), &Talks)?;
    Ok(finished.ok_or("cancelled")?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let finished = optimise()?;
    match &finished.model {
        Some(model) => println!("the final model has {} Gaussians", model.len()),
        None => println!("no model reached the target"),
    }
    println!("{} iterations in all", finished.history.len());
    Ok(())
}

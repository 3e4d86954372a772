//! A tiny scene, its views and everything that a run needs.

use powergs_base::config::embedded::{DISPLAYS, find};
use powergs_core::sim::paper::UnitPrices;
use powergs_frame::display::Display;
use powergs_optimize::oracle::PaperOracle;
use powergs_optimize::references::Reference;
use powergs_optimize::renderer::Processor;
use powergs_optimize::settings::Settings;
use powergs_optimize::setup::Setup;
use powergs_optimize::views::{ViewSplit, split};
use powergs_raster::{Detail, Options, render};
use powergs_scene::camera::edit::resized;
use powergs_scene::synth::{Preset, cameras, generate};
use powergs_scene::{Camera, Gaussians};

/// Everything that [`Setup`] borrows.
pub struct Tiny {
    pub dense: Gaussians,
    pub cameras: Vec<Camera>,
    pub references: Vec<Reference>,
    pub split: ViewSplit,
    pub display: Display,
    pub oracle: PaperOracle,
    pub settings: Settings,
}

/// `points` Gaussians of the demonstration scene, every `every`-th view, `size` pixels.
pub fn tiny(points: usize, every: usize, size: (u32, u32)) -> Tiny {
    // Rounder than trained ones: of so few, long ones would be in every tile.
    let preset = &Preset { elongation: 0.6, ..Preset::named("demo").unwrap().clone() };
    let dense = generate(preset, points, 3);
    let views = cameras(preset).into_iter().step_by(every);
    let cameras: Vec<Camera> = views.map(|c| resized(&c, size.0, size.1)).collect();
    let options = Options::reference(Detail::Image);
    let references =
        cameras.iter().map(|c| Reference::new(&render(&dense, c, &options).picture)).collect();
    Tiny {
        split: split(&cameras, 0),
        dense,
        cameras,
        references,
        display: Display::parse(find(DISPLAYS, "oled-powergs").unwrap()).unwrap(),
        oracle: PaperOracle { prices: UnitPrices::PUBLISHED, fps: 60.0 },
        settings: Settings {
            iterations: 12,
            first_effort: 1.0,
            final_iterations: 16,
            interval: 3,
            ..Settings::DEFAULT
        },
    }
}

impl Tiny {
    pub fn setup(&self) -> Setup<'_> {
        Setup {
            dense: &self.dense,
            cameras: &self.cameras,
            references: &self.references,
            split: &self.split,
            power_views: &self.cameras,
            background: [0.0; 3],
            display: &self.display,
            renderer: &Processor,
            oracle: &self.oracle,
            screens: None,
            lpips: None,
            settings: &self.settings,
        }
    }
}

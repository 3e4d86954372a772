//! Training touches the renderer in three places, and in these alone.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use powergs_base::picture::Picture;
use powergs_core::run::MemoryStore;
use powergs_optimize::adam::BadGradient;
use powergs_optimize::prune::Score;
use powergs_optimize::renderer::{LossOf, Processor, Renderer, RendererStep, Stepper};
use powergs_optimize::request::Request;
use powergs_optimize::tune::Model;
use powergs_scene::{Camera, Gaussians};

use super::campaign::{open, request};

/// Steps, looks and scores so far.
type Counts = Arc<[AtomicU32; 3]>;

/// The processor under another name, counting.
struct Counting(Counts);

impl Renderer for Counting {
    fn id(&self) -> String {
        "counting".into()
    }

    fn stepper(&self) -> Box<dyn Stepper + '_> {
        Box::new(CountingStepper(Processor.stepper(), self.0.clone()))
    }

    fn look(&self, scene: &Gaussians, camera: &Camera, background: [f32; 3]) -> Picture {
        self.0[1].fetch_add(1, Ordering::Relaxed);
        Processor.look(scene, camera, background)
    }

    fn score(&self, score: Score, scene: &Gaussians, views: &[Camera]) -> Vec<f64> {
        self.0[2].fetch_add(1, Ordering::Relaxed);
        Processor.score(score, scene, views)
    }
}

struct CountingStepper<'a>(Box<dyn Stepper + 'a>, Counts);

impl Stepper for CountingStepper<'_> {
    fn step(
        &mut self,
        model: &mut Model,
        step: &RendererStep<'_>,
        loss: &mut LossOf<'_>,
    ) -> Result<(), BadGradient> {
        self.1[0].fetch_add(1, Ordering::Relaxed);
        self.0.step(model, step, loss)
    }
}

#[test]
fn a_campaign_steps_looks_and_scores_through_its_renderer() {
    let counts = Counts::default();
    let asked = || Request { renderer: Box::new(Counting(counts.clone())), ..request() };
    let campaign = open(asked());
    assert_ne!(campaign.fingerprint(), open(request()).fingerprint());
    let finished = campaign.run(&MemoryStore::new(), &()).unwrap().unwrap();
    let plain = open(request()).run(&MemoryStore::new(), &()).unwrap().unwrap();
    assert_eq!(finished.model, plain.model);
    let [steps, looks, scores] = counts.each_ref().map(|n| n.load(Ordering::Relaxed) as usize);
    // Cold moments have steps before the first iteration.
    assert!(steps > finished.history.len(), "{steps} steps");
    let views = campaign.split.test.len() + campaign.gate_views();
    assert!(looks > finished.outcomes.len() * views, "{looks} looks");
    assert!(scores > 0);
}

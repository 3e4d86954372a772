//! `optimize --train-on`: what the training of a run would take on a machine that trains.

use std::sync::Arc;

use serde_json::{Value, json};

use super::super::inputs::system;
use super::super::{Exit, Failure};
use powergs_core::run::{Session, System};
use powergs_optimize::campaign::{Campaign, Finished};
use powergs_report::format::{engineering, wrapped};
use powergs_views::rendered;

/// Views that steps are simulated of, evenly spaced.
const VIEWS: usize = 8;

/// What a run takes on a machine.
pub struct TrainingCost {
    machine: String,
    /// A step on the final model, mean over views: seconds and joules.
    step_s: f64,
    step_j: f64,
    /// Steps of the search, and of the model that it ends with.
    steps: [u64; 2],
}

/// The machine of `--train-on`. A GPU that was not told how adds gradients up warp by warp.
///
/// # Errors
/// Exit code 2: no machine, or one that does not train.
pub fn trainer(arch: &str) -> Result<System, Failure> {
    let plain = system(arch, &[], None)?;
    let task = |system: &System| system.machine().flow().task(system.machine());
    let trains = |system: &System| !task(system).is_shown();
    if trains(&plain) && !task(&plain).updates_models() {
        let what = format!(
            "--train-on {arch}: it finds gradients and updates no model (`training.update`, \
             `pixels.impl`); take a GPU (orin-nx), `vorion-train` or `gsarch`"
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    if trains(&plain) {
        return Ok(plain);
    }
    let by_warp = ["training.sum=warp".to_owned()];
    let machine = match plain.machine().flow().key() {
        "gpu" => system(arch, &by_warp, None)?,
        _ => plain,
    };
    if trains(&machine) {
        return Ok(machine);
    }
    let what = format!(
        "--train-on {arch}: it renders and does not train; take a GPU (orin-nx), `vorion-train`, \
         `gsarch`, or a machine with `training.interval`"
    );
    Err(Failure::new(Exit::Usage, what))
}

impl TrainingCost {
    /// Of a finished run; `None` where no model reached the target.
    ///
    /// # Errors
    /// A machine that cannot run the frames.
    pub fn of(
        trainer: &System,
        campaign: &Campaign,
        finished: &Finished,
    ) -> Result<Option<TrainingCost>, Failure> {
        let Some(model) = &finished.model else { return Ok(None) };
        // Views that gate may have more pixels than a step works on.
        let cameras = &campaign.cameras[..campaign.given.count];
        let every = cameras.len().div_ceil(VIEWS).max(1);
        let cameras = cameras.iter().step_by(every).cloned().collect();
        let mut frames = rendered(&campaign.name, Arc::new(model.clone()), cameras);
        let reports =
            Session::new(&mut *frames, &()).reports(std::slice::from_ref(trainer))?.remove(0);
        let mean = |of: &dyn Fn(&powergs_core::sim::FrameReport) -> f64| {
            reports.iter().map(of).sum::<f64>() / reports.len().max(1) as f64
        };
        let seconds = |frame: &powergs_core::sim::FrameReport| {
            frame.cycle().map_or(0.0, powergs_core::sim::CycleReport::frame_time_s)
        };
        let all = finished.outcomes.iter().map(|outcome| u64::from(outcome.iterations)).sum();
        let own = finished.outcomes.iter().find(|o| Some(&o.name) == finished.result.as_ref());
        Ok(Some(TrainingCost {
            machine: trainer.machine().name.clone(),
            step_s: mean(&seconds),
            step_j: mean(&|frame| frame.energy.total().0 * 1e-12),
            steps: [all, own.map_or(0, |outcome| u64::from(outcome.iterations))],
        }))
    }

    /// In words.
    pub fn sentence(&self) -> String {
        let of = |steps: u64| {
            let (seconds, joules) = (steps as f64 * self.step_s, steps as f64 * self.step_j);
            format!("{} and {}", engineering(joules, "J"), engineering(seconds, "s"))
        };
        let [all, own] = self.steps;
        wrapped(
            &format!(
                "On {}, a step of training on the final model takes {} and {}: {all} steps of the \
                 search are {}, the {own} of the final model alone {}.",
                self.machine,
                engineering(self.step_j, "J"),
                engineering(self.step_s, "s"),
                of(all),
                of(own)
            ),
            80,
        )
    }

    /// As JSON.
    pub fn json(&self) -> Value {
        let [all, own] = self.steps;
        json!({
            "machine": self.machine,
            "step_s": self.step_s,
            "step_j": self.step_j,
            "steps": all,
            "steps_of_result": own,
            "joules": all as f64 * self.step_j,
            "joules_of_result": own as f64 * self.step_j,
            "seconds": all as f64 * self.step_s,
            "seconds_of_result": own as f64 * self.step_s,
        })
    }
}

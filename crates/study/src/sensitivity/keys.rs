//! Every key of a machine's files perturbed by itself, and then, where it is asked for, several
//! keys together.

use powergs_base::config::knob;
use powergs_core::run::{Frames, RunError, System, Watch};

use super::interactions::InteractionStudy;
use super::key::{self, Key};
use super::levels::{self, KeySelection};
use super::measure::MeasuredMachines;
use crate::findings::sensitivity::interactions::Interactions;
use crate::findings::sensitivity::keys::{KeyRow, Keys, Perturbation, Reach};

/// Every key of a machine, of its energy table and of its DRAM device, perturbed one at a time: by
/// a step down and up (elasticity), to half and to double, to other names.
#[derive(Debug, Clone, Copy)]
pub struct KeyStudy<'a> {
    /// The machine.
    pub system: &'a System,
    /// The keys; empty: all.
    pub keys: &'a [KeySelection],
    /// Relative step of elasticities, 0.1 for ten per cent; where that is no machine, the next
    /// larger one is taken.
    pub step: f64,
    /// Display rate of the powers, frames per second.
    pub display_fps: f64,
    /// Several keys together; `None`: one at a time only.
    pub interactions: Option<InteractionStudy>,
}

/// What came out.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyResults {
    /// One key at a time, the largest effect first.
    pub keys: Keys,
    /// Several keys together; `None` if that was not asked for, or cancelled.
    pub interactions: Option<Interactions>,
}

/// A perturbation, with the place of its machine.
struct PlacedKey {
    reach: Reach,
    value: String,
    ratio: Option<f64>,
    machine: Result<usize, String>,
}

impl KeyStudy<'_> {
    /// Takes the frames through all machines of the experiment. `None` if it was cancelled before
    /// the first frame was done.
    ///
    /// # Errors
    /// [`RunError::Request`]: a key that the machine does not have, values that are no machine, too
    /// many machines; otherwise as [`Session::fold`](powergs_core::run::Session::fold).
    pub fn run<F: Frames>(
        &self,
        lists: &mut [F],
        watch: &dyn Watch,
    ) -> Result<Option<KeyResults>, RunError> {
        let (all, mut not_tried) = key::all(self.system);
        let all = levels::selected(all, self.keys, self.system.machine())?;
        if !self.keys.is_empty() {
            not_tried.clear();
        }
        let mut machines = MeasuredMachines::new(self.system);
        let placed = self.perturbed(&all, &mut machines);
        let measured = machines.measure(lists, self.display_fps, watch)?;
        let Some(measured) = measured else { return Ok(None) };
        let perturbation = |placed: PlacedKey| Perturbation {
            reach: placed.reach,
            value: placed.value,
            ratio: placed.ratio,
            outcomes: placed.machine.map(|place| measured.outcomes(place)),
        };
        let row = |(key, placed): (&Key, Vec<PlacedKey>)| KeyRow {
            file: key.file.name(),
            key: key.path.clone(),
            value: knob::shown(&key.value),
            base: measured.outcomes(0),
            perturbations: placed.into_iter().map(perturbation).collect(),
            reason: key.reason(),
        };
        let keys = Keys {
            machine: self.system.label(),
            display_fps: self.display_fps,
            step: self.step,
            traces: measured.traced(),
            rows: all.iter().zip(placed).map(row).collect(),
            not_tried,
        };
        let keys = keys.sorted();
        let interactions = match &self.interactions {
            Some(study) if !watch.is_cancelled() => {
                let factors = levels::factors(&all, self.keys, &keys, self.system)?;
                study.run(self.system, self.display_fps, &factors, lists, watch)?
            }
            _ => None,
        };
        Ok(Some(KeyResults { keys, interactions }))
    }

    /// The perturbations of all keys, in the order of the files.
    fn perturbed(&self, keys: &[Key], machines: &mut MeasuredMachines) -> Vec<Vec<PlacedKey>> {
        let mut place = |candidate: key::KeyCandidate| PlacedKey {
            reach: candidate.reach,
            value: knob::shown(&candidate.value),
            ratio: candidate.ratio,
            machine: candidate.system.map(|system| machines.add(system)),
        };
        let all = key::candidates(keys, self.system, self.step).into_iter();
        all.map(|of_key| of_key.into_iter().map(&mut place).collect()).collect()
    }
}

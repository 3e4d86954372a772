//! HVSQ at a pooling against the references of a run, whose statistics are kept.

use powergs_base::picture::Picture;
use powergs_quality::HvsqError;
use powergs_quality::hvsq::{Hvsq, Measures, Reference};

use super::setup::Setup;

/// Most memory for statistics of reference pictures, bytes; those of further views are computed
/// again each time.
const ROOM: usize = 64 << 20;

/// HVSQ at one pooling, for views of all sizes. A reference is analysed once, where there is room.
pub struct Pooled {
    pooling: f64,
    measures: Measures,
    /// Statistics of reference pictures, by view.
    statistics: Vec<Option<Reference>>,
    /// Room that they take, bytes.
    taken: usize,
    reference: Picture,
}

impl Pooled {
    /// At a pooling, pixels.
    pub fn new(pooling: f64) -> Pooled {
        Pooled {
            pooling,
            measures: Measures::default(),
            statistics: Vec::new(),
            taken: 0,
            reference: Picture::default(),
        }
    }

    /// HVSQ of `picture`, which shows `view`.
    ///
    /// # Errors
    /// A picture that it is not defined for.
    pub fn value(
        &mut self,
        setup: &Setup<'_>,
        view: usize,
        picture: &Picture,
    ) -> Result<f64, HvsqError> {
        self.compared(setup, view, picture, |measure, reference| {
            measure.values(picture, reference)[0]
        })
    }

    /// The same; `gradient` gets its derivatives, times `weight`.
    ///
    /// # Errors
    /// As [`Pooled::value`].
    pub fn gradient(
        &mut self,
        setup: &Setup<'_>,
        view: usize,
        picture: &Picture,
        weight: f64,
        gradient: &mut [[f32; 3]],
    ) -> Result<f64, HvsqError> {
        self.compared(setup, view, picture, |measure, reference| {
            measure.evaluate(picture, reference, &[weight], gradient)[0]
        })
    }

    fn compared(
        &mut self,
        setup: &Setup<'_>,
        view: usize,
        picture: &Picture,
        compare: impl FnOnce(&mut Hvsq, &Reference) -> f64,
    ) -> Result<f64, HvsqError> {
        let measure = self.measures.of(picture, &[self.pooling])?;
        if self.statistics.len() < setup.cameras.len() {
            self.statistics.resize_with(setup.cameras.len(), || None);
        }
        if let Some(reference) = &self.statistics[view] {
            return Ok(compare(measure, reference));
        }
        setup.references.write_to(view, &mut self.reference);
        let reference = measure.reference(&self.reference);
        let value = compare(measure, &reference);
        let bytes = reference.bytes();
        if self.taken + bytes <= ROOM {
            self.taken += bytes;
            self.statistics[view] = Some(reference);
        }
        Ok(value)
    }
}

//! Measures for pictures of several sizes.

use super::{Hvsq, HvsqError};
use powergs_base::picture::Picture;

/// Measures that were needed so far: one per size and poolings, each with its work space.
#[derive(Debug, Default)]
pub struct Measures {
    kept: Vec<((u32, u32), Vec<f64>, Hvsq)>,
}

impl Measures {
    /// The measure for pictures of the size of `picture` at these poolings.
    ///
    /// # Errors
    /// As [`Hvsq::new`].
    pub fn of(&mut self, picture: &Picture, poolings: &[f64]) -> Result<&mut Hvsq, HvsqError> {
        let size = (picture.width, picture.height);
        let is_it = |(s, p, _): &(_, Vec<f64>, _)| *s == size && p == poolings;
        let at = match self.kept.iter().position(is_it) {
            Some(at) => at,
            None => {
                let measure = Hvsq::new(size.0, size.1, poolings)?;
                self.kept.push((size, poolings.to_vec(), measure));
                self.kept.len() - 1
            }
        };
        Ok(&mut self.kept[at].2)
    }
}

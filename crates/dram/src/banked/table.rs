//! Tables that need no check of an index.

/// The most banks of a channel, and the most channels.
pub(super) const MOST: usize = 64;

/// Up to 64 values, by number.
#[derive(Debug, Clone)]
pub(super) struct Table<T>([T; MOST]);

impl<T: Copy> Table<T> {
    /// A table of one value.
    pub(super) fn new(value: T) -> Self {
        Table([value; MOST])
    }
}

impl<T> Table<T> {
    /// The value at a number below 64.
    #[inline]
    pub(super) fn at(&self, number: impl Into<usize>) -> &T {
        &self.0[number.into() % MOST]
    }

    /// The same, to change it.
    #[inline]
    pub(super) fn at_mut(&mut self, number: impl Into<usize>) -> &mut T {
        &mut self.0[number.into() % MOST]
    }
}

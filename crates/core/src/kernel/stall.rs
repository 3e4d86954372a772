//! Why units wait, as accounts know it: by number.

/// Why a unit that had work could not proceed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Stall(u8);

impl Stall {
    /// The unit before it has not finished.
    pub const INPUT: Stall = Stall(0);
    /// The buffer behind it is full.
    pub const OUTPUT: Stall = Stall(1);
    /// Banks of its buffers are taken by other accesses.
    pub const BANK: Stall = Stall(2);
    /// How many causes every unit may have: those above.
    pub const COMMON: usize = 3;
    /// The most causes that accounts have room for.
    pub const MOST: usize = 16;

    /// The cause at a position in accounts; those behind the common ones are what stages declare.
    ///
    /// # Panics
    /// At [`Stall::MOST`] and beyond.
    pub const fn at(position: usize) -> Stall {
        assert!(position < Stall::MOST, "accounts have no room for so many causes");
        Stall(position as u8)
    }

    /// Its position in accounts.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

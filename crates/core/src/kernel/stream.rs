//! The streams of requests that the units of a machine make: what is read or written, and why.

use powergs_energy::action::Phase;

/// A kind of request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// The first read of a batch: something of all records.
    Records,
    /// Its second read: something of the survivors.
    Survivors,
    /// Its third read: colours of splats.
    Colours,
    /// What a CCU reads of lists and pointers before it writes.
    ReadBack,
    /// Splats and list entries that a CCU writes.
    Results,
    /// Lists of tiles.
    Lists,
    /// Sorted lists that are kept for the next frame.
    KeptLists,
    /// Keys that do not fit the sorting buffer, on their way out.
    SpillOut,
    /// The same on their way back.
    SpillIn,
    /// Features and colours of a chunk.
    Features,
    /// Pixels of a tile.
    Pixels,
}

impl Stream {
    /// All streams.
    pub const ALL: [Stream; 11] = [
        Stream::Records,
        Stream::Survivors,
        Stream::Colours,
        Stream::ReadBack,
        Stream::Results,
        Stream::Lists,
        Stream::KeptLists,
        Stream::SpillOut,
        Stream::SpillIn,
        Stream::Features,
        Stream::Pixels,
    ];

    /// Number of streams.
    pub const COUNT: usize = Stream::ALL.len();

    /// The stream of a read of a batch, counted from 0.
    pub const fn of_read(read: usize) -> Stream {
        match read {
            0 => Stream::Records,
            1 => Stream::Survivors,
            _ => Stream::Colours,
        }
    }

    /// The stage that its bytes are charged to.
    pub const fn stage(self) -> Phase {
        match self {
            Stream::Records
            | Stream::Survivors
            | Stream::Colours
            | Stream::ReadBack
            | Stream::Results => Phase::Preprocessing,
            Stream::Lists | Stream::KeptLists | Stream::SpillOut | Stream::SpillIn => {
                Phase::Sorting
            }
            Stream::Features | Stream::Pixels => Phase::Rendering,
        }
    }

    /// Whether it writes.
    pub const fn is_write(self) -> bool {
        match self {
            Stream::Results | Stream::KeptLists | Stream::SpillOut | Stream::Pixels => true,
            Stream::Records
            | Stream::Survivors
            | Stream::Colours
            | Stream::ReadBack
            | Stream::Lists
            | Stream::SpillIn
            | Stream::Features => false,
        }
    }

    /// Whether a request of it is one range of bytes, whose ends may share a burst with others; the
    /// others touch many places.
    pub(super) const fn is_contiguous(self) -> bool {
        match self {
            Stream::Survivors | Stream::Colours | Stream::ReadBack | Stream::Features => false,
            Stream::Records
            | Stream::Results
            | Stream::Lists
            | Stream::KeptLists
            | Stream::SpillOut
            | Stream::SpillIn
            | Stream::Pixels => true,
        }
    }

    /// The stream, and others that touch the memory alike, the most similar first.
    pub(super) const fn and_similar(self) -> [Stream; 3] {
        match self {
            Stream::Records => [self, Stream::Survivors, Stream::Colours],
            Stream::Survivors => [self, Stream::Colours, Stream::Records],
            Stream::Colours => [self, Stream::Survivors, Stream::Records],
            Stream::ReadBack => [self, Stream::Features, Stream::Survivors],
            Stream::Results => [self, Stream::Pixels, Stream::KeptLists],
            Stream::Lists => [self, Stream::SpillIn, Stream::Records],
            Stream::KeptLists => [self, Stream::SpillOut, Stream::Pixels],
            Stream::SpillOut => [self, Stream::KeptLists, Stream::Pixels],
            Stream::SpillIn => [self, Stream::Lists, Stream::Records],
            Stream::Features => [self, Stream::Colours, Stream::Survivors],
            Stream::Pixels => [self, Stream::SpillOut, Stream::Results],
        }
    }
}

//! The streams of requests that the stages of a dataflow make: what is read or written, and why.

use powergs_energy::action::Phase;

/// Requests of one kind, as the stage that makes them declares it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamDecl {
    /// Its key.
    pub key: &'static str,
    /// What is read or written.
    pub means: &'static str,
    /// Whether it writes.
    pub is_write: bool,
    /// Whether a request of it is one range of bytes, whose ends may share a burst with others; the
    /// others touch many places.
    pub is_contiguous: bool,
    /// Streams that touch the memory alike, the most similar first: what one costs that a run did
    /// not have.
    pub like: [&'static str; 2],
    /// The phase that its bytes are charged to, where it is not that of its stage.
    pub phase: Option<Phase>,
    /// The streams that wrote what it reads; none where it was there before the frame.
    pub written_by: &'static [&'static str],
}

/// A stream that reads.
pub const fn reads(
    key: &'static str,
    means: &'static str,
    written_by: &'static [&'static str],
    like: [&'static str; 2],
) -> StreamDecl {
    StreamDecl { key, means, is_write: false, is_contiguous: true, like, phase: None, written_by }
}

/// A stream that writes.
pub const fn writes(key: &'static str, means: &'static str, like: [&'static str; 2]) -> StreamDecl {
    StreamDecl {
        key,
        means,
        is_write: true,
        is_contiguous: true,
        like,
        phase: None,
        written_by: &[],
    }
}

impl StreamDecl {
    /// The same in many places.
    pub const fn scattered(self) -> StreamDecl {
        StreamDecl { is_contiguous: false, ..self }
    }

    /// The same for another phase than that of its stage.
    pub const fn of(self, phase: Phase) -> StreamDecl {
        StreamDecl { phase: Some(phase), ..self }
    }
}

/// The number of a stream in its dataflow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamId(u8);

impl StreamId {
    /// Its place in lists by stream.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// What the memory has to know of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct StreamFacts {
    key: &'static str,
    phase: Phase,
    is_write: bool,
    is_contiguous: bool,
    like: [&'static str; 2],
}

/// The streams of a dataflow, in the order of its stages.
#[derive(Debug, PartialEq, Eq)]
pub struct Streams {
    facts: [StreamFacts; Streams::MOST],
    count: usize,
}

impl Streams {
    /// Most streams of a dataflow: the counters of a device tell these apart, and other
    /// masters.
    pub const MOST: usize = powergs_dram::stats::CLASSES - super::masters::MASTERS.len();

    /// None.
    pub const NONE: Streams = {
        let nothing = StreamFacts {
            key: "",
            phase: Phase::Preprocessing,
            is_write: false,
            is_contiguous: true,
            like: [""; 2],
        };
        Streams { facts: [nothing; Streams::MOST], count: 0 }
    };

    /// These, and those of a stage that works in this phase.
    ///
    /// # Panics
    /// When there are more than [`Streams::MOST`].
    pub const fn with(mut self, phase: Phase, more: &[StreamDecl]) -> Streams {
        let mut i = 0;
        while i < more.len() {
            assert!(self.count < Streams::MOST, "more streams than devices tell apart");
            let StreamDecl { key, is_write, is_contiguous, like, phase: own, .. } = more[i];
            let phase = match own {
                Some(own) => own,
                None => phase,
            };
            self.facts[self.count] = StreamFacts { key, phase, is_write, is_contiguous, like };
            (self.count, i) = (self.count + 1, i + 1);
        }
        self
    }

    /// The same, where each is like others that there are.
    ///
    /// # Panics
    /// When one is like one that does not exist.
    pub const fn checked(self) -> Streams {
        let mut i = 0;
        while i < self.count {
            let [first, second] = self.facts[i].like;
            let _ = (self.id(first), self.id(second));
            i += 1;
        }
        self
    }

    /// The number of a stream.
    ///
    /// # Panics
    /// On a key that no stage declares.
    pub const fn id(&self, key: &str) -> StreamId {
        let mut i = 0;
        while i < self.count {
            if same(self.facts[i].key, key) {
                return StreamId(i as u8);
            }
            i += 1;
        }
        panic!("no stage declares this stream")
    }

    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = StreamId> + use<> {
        (0..self.count as u8).map(StreamId)
    }

    /// The key of a stream.
    pub const fn key(&self, stream: StreamId) -> &'static str {
        self.facts[stream.index()].key
    }

    /// The phase that its bytes are charged to.
    #[inline]
    pub const fn phase(&self, stream: StreamId) -> Phase {
        self.facts[stream.index()].phase
    }

    /// Whether it writes.
    #[inline]
    pub const fn is_write(&self, stream: StreamId) -> bool {
        self.facts[stream.index()].is_write
    }

    /// Whether a request of it is one range of bytes.
    pub(super) const fn is_contiguous(&self, stream: StreamId) -> bool {
        self.facts[stream.index()].is_contiguous
    }

    /// The stream, and others that touch the memory alike, the most similar first.
    pub(super) fn and_similar(&self, stream: StreamId) -> [StreamId; 3] {
        let [first, second] = self.facts[stream.index()].like;
        [stream, self.id(first), self.id(second)]
    }
}

/// Whether two keys are the same, before the program runs.
pub(crate) const fn same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}

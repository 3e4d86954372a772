//! Reads all of a trace and reports every damage with its position.

use std::io::Read;
use std::ops::ControlFlow;

use powergs_base::budget::Budget;

use super::encoded::EncodedFrame;
use super::error::TraceError;
use super::head::TraceHeader;
use super::scan::{Item, Scan};

/// Damage beyond this many places is counted, not listed.
const LISTED: usize = 100;

/// What [`verify`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct VerifyReport {
    /// The version of the file: major, minor.
    pub version: (u16, u16),
    /// The trace header.
    pub header: TraceHeader,
    /// Bytes read.
    pub bytes: u64,
    /// Frames that the list at the end counts; `None` if there is none.
    pub listed: Option<u64>,
    /// Frames whose every byte and value is right.
    pub intact: u64,
    /// Whether the file ends with a valid list of frames.
    pub complete: bool,
    /// What is wrong, in file order; at most 100 places.
    pub damage: Vec<Damage>,
    /// Places that are wrong.
    pub damaged_places: u64,
}

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damage {
    /// Position in the file.
    pub offset: u64,
    /// What is wrong, in words.
    pub what: String,
}

impl VerifyReport {
    /// Whether nothing is wrong.
    pub fn is_good(&self) -> bool {
        self.complete && self.damaged_places == 0
    }

    fn new<R: Read>(scan: &Scan<R>) -> VerifyReport {
        VerifyReport {
            version: scan.version(),
            header: scan.header().clone(),
            bytes: 0,
            listed: None,
            intact: 0,
            complete: false,
            damage: Vec::new(),
            damaged_places: 0,
        }
    }

    /// Decodes a frame, the `due`-th, and returns whether it is intact.
    fn takes(&mut self, frame: &EncodedFrame, due: u64, budget: Budget) -> bool {
        let (number, start) = (frame.head().number, frame.start());
        if number != due && self.damaged_places == 0 {
            self.add(start, format!("frame {number} where {due} is due"));
        }
        if let Err(over) = budget.check(frame.decoding_bytes()) {
            self.add(start, format!("frame {number} {over}"));
            return false;
        }
        let facts = frame.head().check(&self.header);
        let decoded = facts
            .map_err(|fault| TraceError::Frame { frame: number, fault })
            .and_then(|()| frame.decode());
        match &decoded {
            Ok(_) => self.intact += 1,
            Err(error) => self.add(error.offset().unwrap_or(start), error.what()),
        }
        decoded.is_ok()
    }

    fn add(&mut self, offset: u64, what: String) {
        self.damaged_places += 1;
        if self.damage.len() < LISTED {
            self.damage.push(Damage { offset, what });
        }
    }
}

/// Reads a trace from front to back and decodes every frame; goes on after damage where the next
/// frame can be found. Memory: one frame, within [`Budget::DEFAULT`].
///
/// # Errors
/// Only where there is no trace header to go by ([`TraceError::NotATrace`],
/// [`TraceError::Version`], a bad header), or reading fails ([`TraceError::Io`]).
pub fn verify(input: impl Read) -> Result<VerifyReport, TraceError> {
    visit_intact(input, Budget::DEFAULT, |_, _| Ok(ControlFlow::Continue(())))
}

/// As [`verify`], with frames that take up to `budget`; a larger one counts as damaged. `visit`
/// gets each frame that is intact, so that it can be kept. Where it breaks off, the report covers
/// the frames so far and is not complete.
///
/// # Errors
/// Those of [`verify`], and those of `visit`.
pub fn visit_intact(
    input: impl Read,
    budget: Budget,
    mut visit: impl FnMut(&TraceHeader, EncodedFrame) -> Result<ControlFlow<()>, TraceError>,
) -> Result<VerifyReport, TraceError> {
    let mut scan = Scan::new(input)?;
    let mut report = VerifyReport::new(&scan);
    let mut places = Vec::new();
    loop {
        let start = scan.offset();
        match scan.next_item() {
            Ok(Item::Frame(frame)) => {
                let due = places.len() as u64;
                places.push([frame.start(), frame.bytes()]);
                if report.takes(&frame, due, budget) && visit(scan.header(), *frame)?.is_break() {
                    break;
                }
            }
            Ok(Item::Footer(list)) => {
                report.complete = true;
                report.listed = Some(list.len() as u64);
                if list != places && report.damaged_places == 0 {
                    let what = "the list of frames at the end disagrees with the frames";
                    report.add(start, what.into());
                }
                break;
            }
            Err(error @ TraceError::Io { .. }) => return Err(error),
            Err(error) => {
                report.add(error.offset().unwrap_or(start), error.what());
                if matches!(error, TraceError::Incomplete { .. }) || !scan.resume()? {
                    break;
                }
            }
        }
    }
    report.bytes = scan.offset();
    Ok(report)
}

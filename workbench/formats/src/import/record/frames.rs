//! Finds the frames of a recorded line, whatever lies between them.
//!
//! A line is recorded as it arrives: starting in the middle, with bytes lost and flipped, and across resets
//! of its sender, which cut the frame being sent. So each stretch between zeros is decoded on its own, and
//! the order of the frames is judged here: the decoder of a whole stream would refuse everything after a lost
//! header.

use flight_record::{Decoder, FORMAT_VERSION, Frame, FrameError, Header, Kind, MAGIC, Summary, TickRecord};
use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use survival::RestartReport;

/// Bytes of a stuffed header frame before its magic: kind 1 and the number 0, whose zeros are replaced, and
/// the code of the bytes that follow.
const BEFORE_MAGIC: usize = 6;

/// The content of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A stream begins: the first, or after a reset of its sender.
    Header(Header),
    /// A stream begins whose header was lost: frames are numbered from the beginning again.
    HeaderLost,
    /// Input and output of a tick.
    Tick(Box<TickRecord>),
    /// Input of a tick, in a stream of inputs.
    Input(Box<TickInput>),
    /// The calibration, after the tick that latched it.
    Latch(Box<LatchRecord>),
    /// What the flight computer found at its start.
    Restart(Box<RestartReport>),
    /// A fault of a chip, in a stream of inputs.
    ChipFault,
    /// The end of a stream of inputs, and the number of inputs that it gives.
    End(u32),
    /// The end of a stream of results.
    Summary(Box<Summary>),
}

/// The parts of a line that are not events.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Frames that were read.
    pub frames: usize,
    /// Stretches between two zeros that are not a frame: cut, damaged, or of something else.
    pub damaged: usize,
    /// Bytes in those stretches.
    pub damaged_bytes: usize,
    /// Frames whose CRC is right, but whose content does not match their kind.
    pub undecodable: usize,
    /// Frames of a kind unknown to this version.
    pub unknown: usize,
    /// Frames that came twice.
    pub repeated: usize,
    /// Frames that are missing between those received, by their numbers.
    pub missing: u64,
    /// Whether the first frame is not the first of its stream.
    pub begins_in_the_middle: bool,
    /// Whether the last bytes are the beginning of a frame.
    pub is_cut: bool,
}

/// A header of a version that this program cannot read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OtherVersion(pub u16);

/// Whether there is a frame with a right CRC.
pub fn has_frame(log: &[u8]) -> bool {
    stretches(log).any(|stretch| with_frame(stretch, |_| ()).is_ok())
}

/// Passes on every event of a line.
///
/// # Errors
/// [`OtherVersion`].
pub fn read(log: &[u8], on_event: &mut dyn FnMut(Event)) -> Result<Losses, OtherVersion> {
    let mut reader = Reader { losses: Losses::default(), next: None, version: None, on_event };
    for stretch in stretches(log) {
        reader.take(stretch);
    }
    reader.losses.is_cut = log.last().is_some_and(|last| *last != 0);
    reader.version.map_or(Ok(reader.losses), |version| Err(OtherVersion(version)))
}

/// The non-empty stretches between zeros.
fn stretches(log: &[u8]) -> impl Iterator<Item = &[u8]> {
    log.split_inclusive(|byte| *byte == 0).filter(|stretch| *stretch != [0])
}

/// Calls `take` with the frame in a stretch. Each stretch has its own decoder, so that it does not depend on
/// what came before.
fn with_frame<T>(stretch: &[u8], take: impl FnOnce(&Frame<'_>) -> T) -> Result<T, FrameError> {
    let mut decoder = Decoder::new();
    let (last, bytes) = stretch.split_last().ok_or(FrameError::TooShort)?;
    for byte in bytes {
        decoder.push(*byte)?;
    }
    decoder.push(*last)?.map(|frame| take(&frame)).ok_or(FrameError::TooShort)
}

/// A frame's number and content.
type Numbered = (u32, Content);

enum Content {
    Event(Event),
    OtherVersion(u16),
    Undecodable,
}

fn content(frame: &Frame<'_>) -> Content {
    let event = match frame.kind {
        Kind::Header => match frame.format_version() {
            Some(FORMAT_VERSION) => frame.payload().map(Event::Header),
            Some(version) => return Content::OtherVersion(version),
            None => return Content::Undecodable,
        },
        Kind::Tick => frame.payload().map(|tick| Event::Tick(Box::new(tick))),
        Kind::Input => frame.payload().map(|input| Event::Input(Box::new(input))),
        Kind::Latch => frame.payload().map(|latch| Event::Latch(Box::new(latch))),
        Kind::Restart => frame.payload().map(|report| Event::Restart(Box::new(report))),
        Kind::Summary => frame.payload().map(|summary| Event::Summary(Box::new(summary))),
        Kind::End => frame.payload().map(|end: flight_record::End| Event::End(end.inputs)),
        Kind::ChipFault => Ok(Event::ChipFault),
    };
    event.map_or(Content::Undecodable, Content::Event)
}

struct Reader<'a> {
    losses: Losses,
    /// The number of the next frame.
    next: Option<u32>,
    /// Version in the first header of another version.
    version: Option<u16>,
    on_event: &'a mut dyn FnMut(Event),
}

impl Reader<'_> {
    fn take(&mut self, stretch: &[u8]) {
        match with_frame(stretch, |frame| (frame.sequence, content(frame))) {
            Ok(numbered) => self.take_frame(numbered),
            Err(FrameError::Kind(_)) => self.losses.unknown += 1,
            Err(_) => {
                // If a sender was reset while sending, its header directly follows the frame that was cut.
                let header = memchr::memmem::rfind(stretch, &MAGIC)
                    .and_then(|magic| magic.checked_sub(BEFORE_MAGIC))
                    .and_then(|start| stretch.split_at_checked(start))
                    .filter(|(torn, _)| !torn.is_empty())
                    .and_then(|(torn, rest)| {
                        let numbered = with_frame(rest, |frame| (frame.sequence, content(frame))).ok()?;
                        Some((torn.len(), numbered))
                    });
                self.losses.damaged += 1;
                self.losses.damaged_bytes += header.as_ref().map_or(stretch.len(), |(torn, _)| *torn);
                if let Some((_, numbered)) = header {
                    self.take_frame(numbered);
                }
            }
        }
    }

    fn take_frame(&mut self, (sequence, content): Numbered) {
        self.losses.frames += 1;
        let starts_anew = matches!(content, Content::Event(Event::Header(_))) && sequence == 0;
        match self.next {
            _ if starts_anew => {}
            None => self.losses.begins_in_the_middle = true,
            Some(next) if sequence >= next => self.losses.missing += u64::from(sequence - next),
            Some(next) if sequence + 1 == next => {
                self.losses.repeated += 1;
                return;
            }
            Some(_) => {
                self.losses.missing += u64::from(sequence);
                (self.on_event)(Event::HeaderLost);
            }
        }
        self.next = sequence.checked_add(1);
        match content {
            Content::Event(event) => (self.on_event)(event),
            Content::OtherVersion(version) => {
                self.version.get_or_insert(version);
            }
            Content::Undecodable => self.losses.undecodable += 1,
        }
    }
}

//! The queue of frames between the tick and the UART, and counts of frames that did not fit into it.

use heapless::spsc::{Producer, Queue};
use mavlink::MessageData;

use crate::frame::Frame;

/// Capacity of the queue, frames; one slot stays empty.
pub const FRAMES: usize = 32;

/// Share of a filling queue that a message may use. A saturated link loses samples first, and never the
/// reports of the loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Priority {
    /// Samples and fixes: the next ones come in a few ticks.
    Sample,
    /// Messages sent in turn, one a tick.
    Turn,
    /// The phase, the status and messages that are sent once.
    Status,
}

impl Priority {
    /// Number of slots left to messages of higher priority.
    const fn left_to_others(self) -> usize {
        match self {
            Self::Sample => 8,
            Self::Turn => 4,
            Self::Status => 0,
        }
    }
}

/// The queue; the tick has one end, the UART the other.
pub type FrameQueue = Queue<Frame, FRAMES>;

/// The messages that are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum MessageKind {
    /// HEARTBEAT.
    Heartbeat = 0,
    /// SYS_STATUS.
    SysStatus = 1,
    /// GPS_RAW_INT.
    GpsRawInt = 2,
    /// ATTITUDE.
    Attitude = 3,
    /// HIGHRES_IMU.
    HighresImu = 4,
    /// ALTITUDE.
    Altitude = 5,
    /// NAMED_VALUE_FLOAT.
    NamedValueFloat = 6,
    /// STATUSTEXT.
    StatusText = 7,
}

impl MessageKind {
    /// Number of messages.
    pub const COUNT: usize = 8;
    /// Every message, in the order of its counters.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Heartbeat,
        Self::SysStatus,
        Self::GpsRawInt,
        Self::Attitude,
        Self::HighresImu,
        Self::Altitude,
        Self::NamedValueFloat,
        Self::StatusText,
    ];
}

/// Frames by message, in the order of [`MessageKind`]; all saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounts {
    /// Frames that were queued.
    pub queued: [u32; MessageKind::COUNT],
    /// Frames that found the queue full. A text is lost before the queue, where it waits: its count is of the
    /// texts that found no room to wait.
    pub dropped: [u32; MessageKind::COUNT],
}

impl LinkCounts {
    /// Queued frames of all messages.
    #[must_use]
    pub fn all_queued(&self) -> u32 {
        self.queued.iter().fold(0, |sum, count| sum.saturating_add(*count))
    }

    /// Dropped frames of all messages.
    #[must_use]
    pub fn all_dropped(&self) -> u32 {
        self.dropped.iter().fold(0, |sum, count| sum.saturating_add(*count))
    }
}

/// The tick's end of the link. Nothing here waits.
pub struct Link<'a> {
    frames: Producer<'a, Frame>,
    sequence: u8,
    counts: LinkCounts,
}

impl<'a> Link<'a> {
    /// A link with that end of a queue.
    #[must_use]
    pub const fn new(frames: Producer<'a, Frame>) -> Self {
        let counts = LinkCounts { queued: [0; MessageKind::COUNT], dropped: [0; MessageKind::COUNT] };
        Self { frames, sequence: 0, counts }
    }

    /// The counts.
    #[must_use]
    pub const fn counts(&self) -> &LinkCounts {
        &self.counts
    }

    /// Sends a message that will be repeated, or drops and counts it. In both cases it uses up a sequence
    /// number.
    #[inline(never)]
    pub fn send<M: MessageData>(&mut self, kind: MessageKind, priority: Priority, message: &M) {
        let room = self.room() > priority.left_to_others() && self.enqueue(message);
        self.sequence = self.sequence.wrapping_add(1);
        count(if room { &mut self.counts.queued } else { &mut self.counts.dropped }, kind);
    }

    /// Sends a message that is sent once, if the queue has any room; otherwise the caller keeps it. Returns
    /// whether it was sent.
    #[inline(never)]
    pub fn offer<M: MessageData>(&mut self, kind: MessageKind, message: &M) -> bool {
        let went = self.enqueue(message);
        if went {
            self.sequence = self.sequence.wrapping_add(1);
            count(&mut self.counts.queued, kind);
        }
        went
    }

    /// Counts a message that was lost before it could be offered.
    pub fn count_lost(&mut self, kind: MessageKind) {
        count(&mut self.counts.dropped, kind);
    }

    fn room(&self) -> usize {
        self.frames.capacity().saturating_sub(self.frames.len())
    }

    #[inline(never)]
    fn enqueue<M: MessageData>(&mut self, message: &M) -> bool {
        self.frames.ready() && self.frames.enqueue(Frame::new(message, self.sequence)).is_ok()
    }
}

fn count(counters: &mut [u32; MessageKind::COUNT], kind: MessageKind) {
    if let Some(counter) = counters.get_mut(kind as usize) {
        *counter = counter.saturating_add(1);
    }
}

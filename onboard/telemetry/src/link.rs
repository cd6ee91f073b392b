//! The queue of frames between the tick and the UART, and what did not fit into it.

use heapless::spsc::{Producer, Queue};
use mavlink::MessageData;

use crate::frame::Frame;

/// Frames that wait for the line at most, one slot of which stays empty.
pub const FRAMES: usize = 32;

/// What a message may take of a queue that fills up: a saturated link loses samples first, and never the
/// telling that it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Priority {
    /// Samples and fixes: there will be another in a few ticks.
    Sample,
    /// What is sent in turn, one a tick.
    Turn,
    /// The phase, the status and what is said once.
    Status,
}

impl Priority {
    /// Slots that are left to the more important.
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
    /// How many there are.
    pub const COUNT: usize = 8;
    /// Every one, in the order of its counters.
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
    /// Frames that went into the queue.
    pub queued: [u32; MessageKind::COUNT],
    /// Frames that found it full. A text is not lost in the queue but before it, where it waits: those
    /// count the texts that found no place to wait.
    pub dropped: [u32; MessageKind::COUNT],
}

impl LinkCounts {
    /// Frames of every message that went into the queue.
    #[must_use]
    pub fn all_queued(&self) -> u32 {
        self.queued.iter().fold(0, |sum, count| sum.saturating_add(*count))
    }

    /// Frames of every message that were dropped.
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
    /// A link on that end of a queue.
    #[must_use]
    pub const fn new(frames: Producer<'a, Frame>) -> Self {
        let counts = LinkCounts { queued: [0; MessageKind::COUNT], dropped: [0; MessageKind::COUNT] };
        Self { frames, sequence: 0, counts }
    }

    /// What was counted.
    #[must_use]
    pub const fn counts(&self) -> &LinkCounts {
        &self.counts
    }

    /// Sends a message of which there will be another, or drops and counts it. Dropped or not, it uses
    /// up a sequence number.
    #[inline(never)]
    pub fn send<M: MessageData>(&mut self, kind: MessageKind, priority: Priority, message: &M) {
        let room = self.room() > priority.left_to_others() && self.enqueue(message);
        self.sequence = self.sequence.wrapping_add(1);
        count(if room { &mut self.counts.queued } else { &mut self.counts.dropped }, kind);
    }

    /// Sends a message that is said once, if the queue has any room; otherwise the caller keeps it. Says
    /// whether it went.
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

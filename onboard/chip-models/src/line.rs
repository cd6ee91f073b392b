//! A serial line from a device to the flight computer, and what can be wrong with it.

use heapless::Deque;

/// What waits in the UART's buffer of the flight computer.
const BUFFER_BYTES: usize = 512;
/// What waits in the device: room for what a receiver says at one epoch.
const DEVICE_BYTES: usize = 1_024;

/// What is wrong with a line at present.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineFaults {
    /// Nothing passes, either way.
    pub unplugged: bool,
    /// Bytes to lose, counted down: the next ones that the device sends.
    pub lose_bytes: u32,
    /// A byte to damage: after so many more, these bits.
    pub flip_bits: Option<(u32, u8)>,
    /// Nothing that is sent passes, and noise arrives, as many bytes as the line carries: its random numbers'
    /// state.
    pub noise: Option<u32>,
}

/// The line.
#[derive(Clone, Debug)]
pub struct Line {
    /// What is wrong at present.
    pub faults: LineFaults,
    /// Bytes that the flight computer was too slow to take.
    pub overrun_bytes: u32,
    /// Bytes that the device had no room for.
    pub unsent_bytes: u32,
    baud: u32,
    free_ns: u64,
    outgoing: Deque<u8, DEVICE_BYTES>,
    arrived: Deque<u8, BUFFER_BYTES>,
}

impl Line {
    /// A line of that speed in baud: a start bit, 8 bits, a stop bit.
    pub const fn new(baud: u32) -> Self {
        Self {
            faults: LineFaults { unplugged: false, lose_bytes: 0, flip_bits: None, noise: None },
            overrun_bytes: 0,
            unsent_bytes: 0,
            baud,
            free_ns: 0,
            outgoing: Deque::new(),
            arrived: Deque::new(),
        }
    }

    /// Gives the device a byte to send. One whose buffer is full drops what it cannot send, and that is
    /// counted.
    pub fn send(&mut self, byte: u8) {
        if self.outgoing.push_back(byte).is_err() {
            self.unsent_bytes = self.unsent_bytes.saturating_add(1);
        }
    }

    /// Whether the device has room for a message; one that has not drops it as a whole, and that is counted.
    pub fn has_room(&mut self, bytes: usize) -> bool {
        let has_room = self.outgoing.len() + bytes <= DEVICE_BYTES;
        if !has_room {
            let bytes = u32::try_from(bytes).unwrap_or(u32::MAX);
            self.unsent_bytes = self.unsent_bytes.saturating_add(bytes);
        }
        has_room
    }

    /// From now on it carries at another speed, in baud; what is on it is gone.
    pub fn set_baud(&mut self, baud: u32) {
        self.baud = baud;
        self.cut();
    }

    /// Its speed, baud.
    pub const fn baud(&self) -> u32 {
        self.baud
    }

    /// Lets time pass, microseconds, never backward.
    pub fn carry_until(&mut self, now_us: u64) {
        let now_ns = now_us.saturating_mul(1_000);
        // A start bit, 8 bits, a stop bit.
        let byte_time_ns = 10_000_000_000 / u64::from(self.baud.max(1));
        if self.faults.noise.is_some() {
            // Of a long time only what finds room is of interest.
            let room_ns = (BUFFER_BYTES as u64).saturating_mul(byte_time_ns);
            self.free_ns = self.free_ns.max(now_ns.saturating_sub(room_ns));
        }
        while self.free_ns.saturating_add(byte_time_ns) <= now_ns {
            let sent = self.outgoing.pop_front();
            let noise = self.faults.noise.as_mut().map(|state| {
                *state = noise_after(*state);
                (*state >> 24) as u8
            });
            match noise.or(sent) {
                Some(byte) => {
                    self.free_ns += byte_time_ns;
                    self.arrive(byte);
                }
                None => {
                    self.free_ns = now_ns;
                    return;
                }
            }
        }
    }

    /// The device has lost its power: what it was about to send is gone.
    pub fn cut(&mut self) {
        self.outgoing.clear();
    }

    /// Takes what has arrived, as far as there is room; says how many bytes.
    pub fn read(&mut self, buffer: &mut [u8]) -> usize {
        let mut count = 0;
        for slot in buffer {
            let Some(byte) = self.arrived.pop_front() else { break };
            *slot = byte;
            count += 1;
        }
        count
    }

    /// Whether anything has.
    pub fn has_arrived(&self) -> bool {
        !self.arrived.is_empty()
    }

    /// Lets time pass in which nothing is carried: the line was not there.
    pub fn skip_until(&mut self, now_us: u64) {
        self.free_ns = self.free_ns.max(now_us.saturating_mul(1_000));
    }

    fn arrive(&mut self, byte: u8) {
        if self.faults.unplugged {
            return;
        }
        if self.faults.lose_bytes > 0 {
            self.faults.lose_bytes -= 1;
            return;
        }
        let byte = match &mut self.faults.flip_bits {
            Some((0, mask)) => {
                let flipped = byte ^ *mask;
                self.faults.flip_bits = None;
                flipped
            }
            Some((after, _)) => {
                *after -= 1;
                byte
            }
            None => byte,
        };
        if self.arrived.push_back(byte).is_err() {
            self.overrun_bytes = self.overrun_bytes.saturating_add(1);
        }
    }
}

/// The next of a sequence of random numbers: Numerical Recipes' "quick" generator, whose high bits do for
/// noise.
pub(crate) const fn noise_after(state: u32) -> u32 {
    state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223)
}

//! A serial line from a device to the flight computer, and its faults.

use heapless::Deque;

/// Size of the UART's buffer in the flight computer.
const BUFFER_BYTES: usize = 512;
/// Size of the device's send buffer: room for a receiver's output of one epoch.
const DEVICE_BYTES: usize = 1_024;

/// Present faults of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineFaults {
    /// Nothing passes in either direction.
    pub unplugged: bool,
    /// Number of bytes still to lose, beginning with the next that the device sends.
    pub lose_bytes: u32,
    /// A byte to corrupt: the number of bytes before it, and the bits to flip.
    pub flip_bits: Option<(u32, u8)>,
    /// Noise replaces everything that is sent, with as many bytes as the line carries. The value is the state
    /// of its random numbers.
    pub noise: Option<u32>,
}

/// The line.
#[derive(Clone, Debug)]
pub struct Line {
    /// Present faults.
    pub faults: LineFaults,
    /// Bytes lost because the flight computer read too slowly.
    pub overrun_bytes: u32,
    /// Bytes lost because the device's buffer was full.
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

    /// Gives the device a byte to send. If the buffer is full, the byte is dropped and counted.
    pub fn send(&mut self, byte: u8) {
        if self.outgoing.push_back(byte).is_err() {
            self.unsent_bytes = self.unsent_bytes.saturating_add(1);
        }
    }

    /// Whether the device has room for a message. If not, the whole message counts as dropped.
    pub fn has_room(&mut self, bytes: usize) -> bool {
        let has_room = self.outgoing.len() + bytes <= DEVICE_BYTES;
        if !has_room {
            let bytes = u32::try_from(bytes).unwrap_or(u32::MAX);
            self.unsent_bytes = self.unsent_bytes.saturating_add(bytes);
        }
        has_room
    }

    /// Changes the speed, in baud. Bytes not yet sent are lost.
    pub fn set_baud(&mut self, baud: u32) {
        self.baud = baud;
        self.cut();
    }

    /// Its speed, baud.
    pub const fn baud(&self) -> u32 {
        self.baud
    }

    /// Lets time pass up to `now_us`, microseconds, which never goes backward.
    pub fn carry_until(&mut self, now_us: u64) {
        let now_ns = now_us.saturating_mul(1_000);
        // A start bit, 8 bits, a stop bit.
        let byte_time_ns = 10_000_000_000 / u64::from(self.baud.max(1));
        if self.faults.noise.is_some() {
            // After a long time, only as much as fits in the buffer matters.
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

    /// The device has lost its power: bytes not yet sent are lost.
    pub fn cut(&mut self) {
        self.outgoing.clear();
    }

    /// Takes the bytes that have arrived, as far as there is room. Returns their number.
    pub fn read(&mut self, buffer: &mut [u8]) -> usize {
        let mut count = 0;
        for slot in buffer {
            let Some(byte) = self.arrived.pop_front() else { break };
            *slot = byte;
            count += 1;
        }
        count
    }

    /// Whether any byte has arrived.
    pub fn has_arrived(&self) -> bool {
        !self.arrived.is_empty()
    }

    /// Lets time pass in which nothing is carried, because the line did not exist.
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

/// The next random number of a sequence: Numerical Recipes' "quick" generator, whose high bits suffice for
/// noise.
pub(crate) const fn noise_after(state: u32) -> u32 {
    state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223)
}

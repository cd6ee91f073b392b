//! A serial line from a device to the flight computer, and what can be wrong with it.

use heapless::Deque;

/// What waits in the device, and in the UART's buffer of the flight computer.
const BUFFER_BYTES: usize = 512;

/// What is wrong with a line at present.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineFaults {
    /// Nothing passes, either way.
    pub unplugged: bool,
    /// Bytes to lose, counted down: the next ones that the device sends.
    pub lose_bytes: u32,
    /// A byte to damage: after so many more, these bits.
    pub flip_bits: Option<(u32, u8)>,
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
    byte_time_ns: u64,
    free_ns: u64,
    outgoing: Deque<u8, BUFFER_BYTES>,
    arrived: Deque<u8, BUFFER_BYTES>,
}

impl Line {
    /// A line of that speed in baud: a start bit, 8 bits, a stop bit.
    pub const fn new(baud: u32) -> Self {
        Self {
            faults: LineFaults { unplugged: false, lose_bytes: 0, flip_bits: None },
            overrun_bytes: 0,
            unsent_bytes: 0,
            byte_time_ns: 10_000_000_000 / (if baud == 0 { 1 } else { baud }) as u64,
            free_ns: 0,
            outgoing: Deque::new(),
            arrived: Deque::new(),
        }
    }

    /// Gives the device a byte to send. One whose buffer is full drops what it can not send, and that is counted.
    pub fn send(&mut self, byte: u8) {
        if self.outgoing.push_back(byte).is_err() {
            self.unsent_bytes = self.unsent_bytes.saturating_add(1);
        }
    }

    /// Lets time pass, microseconds, never backward.
    pub fn carry_until(&mut self, now_us: u64) {
        let now_ns = now_us.saturating_mul(1_000);
        while self.free_ns.saturating_add(self.byte_time_ns) <= now_ns {
            match self.outgoing.pop_front() {
                Some(byte) => {
                    self.free_ns += self.byte_time_ns;
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

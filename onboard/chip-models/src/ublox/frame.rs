//! UBX frames (interface description UBX-22008968, section 3.2) from the receiver's side.

/// Longest payload that the modelled receiver accepts.
const PAYLOAD_BYTES: usize = 128;

/// The two checksum bytes over class, identity, length and payload (section 3.4).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fletcher {
    a: u8,
    b: u8,
}

impl Fletcher {
    pub(super) const fn add(&mut self, byte: u8) {
        self.a = self.a.wrapping_add(byte);
        self.b = self.b.wrapping_add(self.a);
    }

    pub(super) const fn bytes(self) -> [u8; 2] {
        [self.a, self.b]
    }
}

/// The part of a frame that has arrived so far.
#[derive(Clone, Debug)]
pub(super) struct Incoming {
    place: usize,
    class: u8,
    id: u8,
    length: usize,
    payload: [u8; PAYLOAD_BYTES],
    sum: Fletcher,
    intact: bool,
}

/// A frame that has arrived completely.
pub(super) struct Arrived {
    pub(super) class: u8,
    pub(super) id: u8,
    length: usize,
    payload: [u8; PAYLOAD_BYTES],
}

impl Arrived {
    pub(super) fn payload(&self) -> &[u8] {
        self.payload.get(..self.length).unwrap_or_default()
    }
}

impl Incoming {
    pub(super) const fn new() -> Self {
        Self {
            place: 0,
            class: 0,
            id: 0,
            length: 0,
            payload: [0; PAYLOAD_BYTES],
            sum: Fletcher { a: 0, b: 0 },
            intact: true,
        }
    }

    /// Takes one byte. Returns the frame that it completes; a frame with a wrong checksum is ignored, as a
    /// receiver does.
    pub(super) fn take(&mut self, byte: u8) -> Option<Arrived> {
        let place = self.place;
        self.place += 1;
        if (2..6 + self.length).contains(&place) {
            self.sum.add(byte);
        }
        match place {
            0 => *self = if byte == 0xB5 { Self { place: 1, ..Self::new() } } else { Self::new() },
            1 if byte != 0x62 => *self = Self::new(),
            1 => {}
            2 => self.class = byte,
            3 => self.id = byte,
            4 => self.length = usize::from(byte),
            5 => {
                self.length |= usize::from(byte) << 8;
                if self.length > PAYLOAD_BYTES {
                    *self = Self::new();
                }
            }
            _ if place < 6 + self.length => {
                if let Some(slot) = self.payload.get_mut(place - 6) {
                    *slot = byte;
                }
            }
            _ if place == 6 + self.length => self.intact = byte == self.sum.bytes()[0],
            _ => {
                let whole = self.intact && byte == self.sum.bytes()[1];
                let arrived =
                    Arrived { class: self.class, id: self.id, length: self.length, payload: self.payload };
                *self = Self::new();
                return whole.then_some(arrived);
            }
        }
        None
    }
}

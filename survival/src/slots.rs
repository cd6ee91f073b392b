//! Two copies of what is kept, written in turn.

use serde::{Deserialize, Serialize};

use crate::check::of_words_and_bytes;

/// Bytes that one copy can hold.
pub const PAYLOAD_BYTES: usize = 1_920;

/// First word of a copy that holds something.
const MAGIC: u32 = 0x4b45_5054;
/// Words before the payload: magic, sequence number, the model's fingerprint (low, high), length, check.
const HEAD_WORDS: usize = 6;

/// One copy.
#[derive(Clone, Debug, PartialEq, Eq)]
#[repr(C, align(4))]
struct Copy {
    head: [u32; HEAD_WORDS],
    payload: [u8; PAYLOAD_BYTES],
}

/// Why a copy is not believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// It was never written: all zeros, as a clean start leaves it.
    Empty,
    /// Its check is wrong: it was changed, or a reset came while it was written.
    Corrupt,
    /// It is another model's.
    OtherModel,
    /// Its check is right and its content is not what it should be: another version of it, or of the
    /// program.
    NotUnderstood,
    /// It is what was held at a suspicion of a launch that came to nothing.
    OtherLaunch,
}

impl Refusal {
    /// The name used in logs and telemetry: what the copy is.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Empty => "empty",
            Self::Corrupt => "corrupt",
            Self::OtherModel => "another model's",
            Self::NotUnderstood => "another version's",
            Self::OtherLaunch => "another launch's",
        }
    }
}

/// A payload is too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlotError;

/// The two copies.
#[derive(Clone, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Slots {
    copies: [Copy; 2],
}

/// What the two copies are worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recovered<'a> {
    /// Payloads of the copies whose check and model are right, the newest first.
    pub payloads: [Option<&'a [u8]>; 2],
    /// Which copy each of them is.
    pub places: [usize; 2],
    /// Why a copy is not among them, by copy.
    pub refused: [Option<Refusal>; 2],
}

impl Slots {
    /// Two empty copies.
    pub const EMPTY: Self =
        Self { copies: [const { Copy { head: [0; HEAD_WORDS], payload: [0; PAYLOAD_BYTES] } }; 2] };

    /// Keeps what `write` puts into the buffer that it is given and returns the length of, in the place of
    /// the older copy or of one that is not sound; the other stays as it is.
    ///
    /// # Errors
    /// [`SlotError`] if `write` has none, or it is longer than the buffer. The older copy is then gone.
    pub fn keep(
        &mut self,
        model: u64,
        write: impl FnOnce(&mut [u8; PAYLOAD_BYTES]) -> Option<usize>,
    ) -> Result<(), SlotError> {
        let newest = self.recover(model);
        let place = match newest.payloads {
            [Some(_), _] => 1 - newest.places[0].min(1),
            [None, _] => 0,
        };
        let sequence = self.sequence(newest.places[0]).filter(|_| newest.payloads[0].is_some());
        let Some(copy) = self.copies.get_mut(place) else { return Err(SlotError) };
        // First of all it must not pass for what it was.
        copy.head = [0; HEAD_WORDS];
        let length = write(&mut copy.payload).ok_or(SlotError)?;
        let payload = copy.payload.get(..length).ok_or(SlotError)?;
        let head =
            [MAGIC, sequence.unwrap_or(0).wrapping_add(1), model as u32, (model >> 32) as u32, length as u32];
        let check = of_words_and_bytes(&head, payload);
        let [magic, sequence, low, high, length] = head;
        copy.head = [magic, sequence, low, high, length, check];
        Ok(())
    }

    /// What can be had of the copies for this model.
    #[must_use]
    pub fn recover(&self, model: u64) -> Recovered<'_> {
        let [first, second] = &self.copies;
        let (first, second) = (first.read(model), second.read(model));
        let refused = [first.err(), second.err()];
        match (first.ok(), second.ok()) {
            (Some((one, first)), Some((other, second))) => {
                // Later by half the circle of sequence numbers at most.
                if other.wrapping_sub(one) < u32::MAX / 2 {
                    Recovered { payloads: [Some(second), Some(first)], places: [1, 0], refused }
                } else {
                    Recovered { payloads: [Some(first), Some(second)], places: [0, 1], refused }
                }
            }
            (Some((_, first)), None) => Recovered { payloads: [Some(first), None], places: [0, 1], refused },
            (None, second) => {
                Recovered { payloads: [second.map(|(_, payload)| payload), None], places: [1, 0], refused }
            }
        }
    }

    fn sequence(&self, place: usize) -> Option<u32> {
        self.copies.get(place).map(|copy| copy.head[1])
    }

    /// Empties both.
    pub fn clear(&mut self) {
        for copy in &mut self.copies {
            copy.head = [0; HEAD_WORDS];
        }
    }
}

impl Copy {
    fn read(&self, model: u64) -> Result<(u32, &[u8]), Refusal> {
        let [magic, sequence, low, high, length, check] = self.head;
        if self.head == [0; HEAD_WORDS] {
            return Err(Refusal::Empty);
        }
        let payload = self.payload.get(..length as usize).ok_or(Refusal::Corrupt)?;
        if magic != MAGIC || of_words_and_bytes(&[magic, sequence, low, high, length], payload) != check {
            return Err(Refusal::Corrupt);
        }
        if model != u64::from(low) | u64::from(high) << 32 {
            return Err(Refusal::OtherModel);
        }
        Ok((sequence, payload))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MODEL: u64 = 0x0123_4567_89ab_cdef;

    fn keep(slots: &mut Slots, bytes: &[u8]) {
        slots
            .keep(MODEL, |buffer| {
                buffer[..bytes.len()].copy_from_slice(bytes);
                Some(bytes.len())
            })
            .unwrap();
    }

    #[test]
    fn the_newest_comes_first_and_the_one_before_it_stays() {
        let mut slots = Slots::EMPTY;
        assert_eq!(slots.recover(MODEL).refused, [Some(Refusal::Empty); 2]);
        for k in 1..=9_u8 {
            keep(&mut slots, &[k; 700]);
            let recovered = slots.recover(MODEL);
            assert_eq!(recovered.payloads[0], Some(&[k; 700][..]));
            assert_eq!(recovered.payloads[1], (k > 1).then_some(&[k - 1; 700][..]));
        }
        slots.clear();
        assert_eq!(slots.recover(MODEL).payloads, [None, None]);
    }

    #[test]
    fn a_corrupt_copy_is_refused_replaced_next_and_the_other_is_what_there_is() {
        let mut slots = Slots::EMPTY;
        keep(&mut slots, b"one");
        keep(&mut slots, b"two");
        slots.copies[1].payload[1] ^= 4;
        let recovered = slots.recover(MODEL);
        assert_eq!(recovered.payloads, [Some(&b"one"[..]), None]);
        assert_eq!(recovered.refused, [None, Some(Refusal::Corrupt)]);
        keep(&mut slots, b"three");
        assert_eq!(slots.recover(MODEL).payloads, [Some(&b"three"[..]), Some(&b"one"[..])]);
    }

    #[test]
    fn another_models_copies_are_refused_as_such() {
        let mut slots = Slots::EMPTY;
        keep(&mut slots, b"one");
        let recovered = slots.recover(MODEL + 1);
        assert_eq!((recovered.payloads, recovered.refused[0]), ([None; 2], Some(Refusal::OtherModel)));
    }

    #[test]
    fn what_does_not_fit_costs_the_older_copy_only() {
        let mut slots = Slots::EMPTY;
        keep(&mut slots, b"one");
        keep(&mut slots, b"two");
        assert_eq!(slots.keep(MODEL, |_| None), Err(SlotError));
        assert_eq!(slots.keep(MODEL, |_| Some(PAYLOAD_BYTES + 1)), Err(SlotError));
        assert_eq!(slots.recover(MODEL).payloads, [Some(&b"two"[..]), None]);
    }

    #[test]
    fn sequence_numbers_wrap() {
        let mut slots = Slots::EMPTY;
        keep(&mut slots, b"one");
        let head = [MAGIC, u32::MAX, MODEL as u32, (MODEL >> 32) as u32, 3];
        let check = of_words_and_bytes(&head, b"one");
        slots.copies[0].head = [head[0], head[1], head[2], head[3], head[4], check];
        keep(&mut slots, b"two");
        assert_eq!(slots.recover(MODEL).payloads, [Some(&b"two"[..]), Some(&b"one"[..])]);
    }

    proptest! {
        #[test]
        fn any_changed_bit_is_noticed(bit in 0_usize..(24 + 300) * 8) {
            let mut slots = Slots::EMPTY;
            keep(&mut slots, &[0x5a; 300]);
            let byte = bit / 8;
            if byte < 24 {
                slots.copies[0].head[byte / 4] ^= 1 << (bit % 32);
            } else {
                slots.copies[0].payload[byte - 24] ^= 1 << (bit % 8);
            }
            prop_assert_eq!(slots.recover(MODEL).refused[0], Some(Refusal::Corrupt));
        }

        #[test]
        fn garbage_is_no_copy(head in any::<[u32; HEAD_WORDS]>(), fill in any::<u8>()) {
            let garbage = Copy { head, payload: [fill; PAYLOAD_BYTES] };
            let slots = Slots { copies: [garbage.clone(), garbage] };
            prop_assert_eq!(slots.recover(MODEL).payloads, [None, None]);
        }
    }
}

//! Two copies of the kept state, written in turn.

use serde::{Deserialize, Serialize};

use crate::check::of_words_and_bytes;
use crate::memory::{SLOTS, WordMemory};

/// Capacity of one copy, bytes.
pub const PAYLOAD_BYTES: usize = 1_920;

/// First word of a copy that is not empty.
const MAGIC: u32 = 0x4b45_5054;
/// Words before the payload: magic, sequence number, the model's fingerprint (low, high), length, check.
const HEAD_WORDS: usize = 6;
const SLOT_WORDS: usize = HEAD_WORDS + PAYLOAD_BYTES / 4;
pub(crate) const SLOTS_WORDS: usize = 2 * SLOT_WORDS;

/// Why a copy is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// It was never written: all zeros, as a clean start leaves it.
    Empty,
    /// Its check is wrong: it was changed, or a reset came while it was being written.
    Corrupt,
    /// It belongs to another model.
    OtherModel,
    /// Its check is right but its content cannot be decoded: another version of the format, or of the
    /// program.
    NotUnderstood,
    /// It was held for a suspicion of a launch that was withdrawn.
    OtherLaunch,
}

impl Refusal {
    /// The name used in logs and telemetry: a description of the copy.
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

/// Contents of a copy, in ordinary memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot<'a> {
    /// Its number among all copies written, wrapping.
    pub sequence: u32,
    /// Its payload.
    pub payload: &'a [u8],
}

/// Copies the copy at `place`, 0 or 1, into ordinary memory and checks it there.
///
/// # Errors
/// [`Refusal`]: why it is refused.
#[inline(never)]
pub fn read_slot<'a>(
    memory: &impl WordMemory,
    place: usize,
    model: u64,
    buffer: &'a mut [u8; PAYLOAD_BYTES],
) -> Result<Slot<'a>, Refusal> {
    let start = SLOTS + place * SLOT_WORDS;
    let head: [u32; HEAD_WORDS] = core::array::from_fn(|word| memory.read(start + word));
    if head == [0; HEAD_WORDS] {
        return Err(Refusal::Empty);
    }
    let [magic, sequence, low, high, length, check] = head;
    let payload = buffer.get_mut(..length as usize).ok_or(Refusal::Corrupt)?;
    for (word, bytes) in payload.chunks_mut(4).enumerate() {
        let word = memory.read(start + HEAD_WORDS + word).to_le_bytes();
        for (byte, kept) in bytes.iter_mut().zip(word) {
            *byte = kept;
        }
    }
    if magic != MAGIC || of_words_and_bytes(&[magic, sequence, low, high, length], payload) != check {
        return Err(Refusal::Corrupt);
    }
    if model != u64::from(low) | u64::from(high) << 32 {
        return Err(Refusal::OtherModel);
    }
    Ok(Slot { sequence, payload })
}

/// Empties both copies.
pub fn clear_slots(memory: &mut impl WordMemory) {
    for place in 0..2 {
        (0..HEAD_WORDS).for_each(|word| memory.write(SLOTS + place * SLOT_WORDS + word, 0));
    }
}

/// Place of the newest copy, and the sequence number of the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlotOrder {
    /// Place of the newest valid copy, and that of the other; 1 and 0 if there is none.
    pub newest_first: [usize; 2],
    /// Why a copy is refused, by place.
    pub refused: [Option<Refusal>; 2],
    sequence: u32,
}

impl SlotOrder {
    /// The order of two empty copies.
    pub const EMPTY: Self = Self { newest_first: [1, 0], refused: [Some(Refusal::Empty); 2], sequence: 0 };

    /// Reads and checks both copies.
    #[must_use]
    pub fn find(memory: &impl WordMemory, model: u64, buffer: &mut [u8; PAYLOAD_BYTES]) -> Self {
        let found = [0, 1].map(|place| read_slot(memory, place, model, buffer).map(|slot| slot.sequence));
        // A later copy is ahead by at most half the circle of sequence numbers.
        let is_first_newest = match found {
            [Ok(first), Ok(second)] => second.wrapping_sub(first) >= u32::MAX / 2,
            [first, _] => first.is_ok(),
        };
        let newest_first = if is_first_newest { [0, 1] } else { [1, 0] };
        let [first, second] = found;
        let sequence = if is_first_newest { first } else { second };
        Self { newest_first, refused: [first.err(), second.err()], sequence: sequence.unwrap_or(0) }
    }

    /// Keeps a payload in the place of the older copy or of an invalid one. The other copy stays unchanged
    /// until this one is complete.
    ///
    /// # Errors
    /// [`SlotError`] if it is longer than [`PAYLOAD_BYTES`]; nothing is written.
    #[inline(never)]
    pub fn keep(
        &mut self,
        memory: &mut impl WordMemory,
        model: u64,
        payload: &[u8],
    ) -> Result<(), SlotError> {
        if payload.len() > PAYLOAD_BYTES {
            return Err(SlotError);
        }
        let [newest, older] = self.newest_first;
        let start = SLOTS + older * SLOT_WORDS;
        let sequence = self.sequence.wrapping_add(1);
        let head = [MAGIC, sequence, model as u32, (model >> 32) as u32, payload.len() as u32];
        let check = of_words_and_bytes(&head, payload);
        // First the old copy is invalidated; the new one is complete with its last word, the magic one.
        memory.write(start, 0);
        for (word, bytes) in payload.chunks(4).enumerate() {
            let value = bytes.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte));
            memory.write(start + HEAD_WORDS + word, value);
        }
        let [magic, sequence_word, low, high, length] = head;
        for (word, value) in [sequence_word, low, high, length, check].into_iter().enumerate() {
            memory.write(start + 1 + word, value);
        }
        memory.write(start, magic);
        (self.newest_first, self.sequence) = ([older, newest], sequence);
        Ok(())
    }

    /// Records that the mission continues from copy `place`, whatever the checks found for the other: the
    /// next copy goes to the other place.
    pub const fn use_copy(&mut self, place: usize) {
        let place = if place == 0 { 0 } else { 1 };
        self.newest_first = [place, 1 - place];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RetainedImage;
    use proptest::prelude::*;

    const MODEL: u64 = 0x0123_4567_89ab_cdef;

    /// The retained memory, and the flight computer's order of its copies.
    struct Kept {
        memory: RetainedImage,
        order: SlotOrder,
    }

    impl Kept {
        fn new() -> Self {
            let memory = RetainedImage::default();
            let order = SlotOrder::find(&memory, MODEL, &mut [0; PAYLOAD_BYTES]);
            Self { memory, order }
        }

        fn keep(&mut self, bytes: &[u8]) {
            self.order.keep(&mut self.memory, MODEL, bytes).unwrap();
        }

        fn found(&self, model: u64) -> SlotOrder {
            SlotOrder::find(&self.memory, model, &mut [0; PAYLOAD_BYTES])
        }

        /// Payloads that a restart finds, the newest first.
        fn payloads(&self) -> Vec<Vec<u8>> {
            let mut buffer = [0; PAYLOAD_BYTES];
            let places = self.found(MODEL).newest_first.into_iter();
            places
                .filter_map(|place| {
                    read_slot(&self.memory, place, MODEL, &mut buffer).ok().map(|slot| slot.payload.to_vec())
                })
                .collect()
        }
    }

    #[test]
    fn the_newest_comes_first_and_the_one_before_it_stays() {
        let mut kept = Kept::new();
        assert_eq!(kept.found(MODEL).refused, [Some(Refusal::Empty); 2]);
        for k in 1..=9_u8 {
            kept.keep(&[k; 701]);
            let expected: Vec<Vec<u8>> =
                [k, k - 1].into_iter().filter(|k| *k > 0).map(|k| vec![k; 701]).collect();
            assert_eq!(kept.payloads(), expected);
            assert_eq!(kept.found(MODEL).newest_first, kept.order.newest_first);
        }
        clear_slots(&mut kept.memory);
        assert_eq!(kept.found(MODEL).refused, [Some(Refusal::Empty); 2]);
    }

    #[test]
    fn a_corrupt_copy_is_refused_replaced_next_and_the_other_is_what_there_is() {
        let mut kept = Kept::new();
        kept.keep(b"one");
        kept.keep(b"two");
        let newest = kept.order.newest_first[0];
        kept.memory.words_mut()[SLOTS + newest * SLOT_WORDS + HEAD_WORDS] ^= 0x400;
        assert_eq!(kept.payloads(), [b"one"]);
        assert_eq!(kept.found(MODEL).refused[newest], Some(Refusal::Corrupt));
        kept.order = kept.found(MODEL);
        kept.keep(b"three");
        assert_eq!(kept.payloads(), [&b"three"[..], b"one"]);
    }

    #[test]
    fn another_models_copies_are_refused_as_such() {
        let mut kept = Kept::new();
        kept.keep(b"one");
        assert!(kept.found(MODEL + 1).refused.contains(&Some(Refusal::OtherModel)));
    }

    #[test]
    fn what_does_not_fit_is_refused_and_costs_nothing() {
        let mut kept = Kept::new();
        kept.keep(&[1; PAYLOAD_BYTES]);
        kept.keep(b"two");
        let before = kept.memory.clone();
        assert_eq!(kept.order.keep(&mut kept.memory, MODEL, &[0; PAYLOAD_BYTES + 1]), Err(SlotError));
        assert_eq!(kept.memory, before);
    }

    #[test]
    fn sequence_numbers_wrap() {
        let mut kept = Kept::new();
        kept.order.sequence = u32::MAX - 1;
        for text in [&b"one"[..], b"two", b"three"] {
            kept.keep(text);
            assert_eq!(kept.payloads()[0], text);
        }
    }

    #[test]
    fn a_write_cut_at_any_word_leaves_the_copy_before_it_or_is_whole() {
        let payload = [7; 41];
        let writes = (1 + 11 + 5 + 1) as u32;
        for cut in 0..=writes {
            let mut kept = Kept::new();
            kept.keep(b"one");
            kept.keep(b"two");
            kept.memory.cut_after(cut);
            kept.keep(&payload);
            let newest = kept.payloads().remove(0);
            assert_eq!(newest, if cut == writes { &payload[..] } else { b"two" }, "{cut}");
            // The next start overwrites the torn copy.
            kept.memory.restore_supply();
            kept.order = kept.found(MODEL);
            kept.keep(b"three");
            assert_eq!(kept.payloads(), [b"three", newest.as_slice()]);
        }
    }

    proptest! {
        #[test]
        fn any_changed_bit_is_noticed(bit in 0_usize..(24 + 300) * 8) {
            let mut kept = Kept::new();
            kept.keep(&[0x5a; 300]);
            let place = kept.order.newest_first[0];
            kept.memory.words_mut()[SLOTS + place * SLOT_WORDS + bit / 32] ^= 1 << (bit % 32);
            prop_assert_eq!(kept.found(MODEL).refused[place], Some(Refusal::Corrupt));
        }

        #[test]
        fn garbage_is_no_copy(seed in any::<u32>()) {
            let mut kept = Kept::new();
            let mut word = seed;
            for kept in kept.memory.words_mut() {
                word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *kept = word;
            }
            prop_assert!(kept.payloads().is_empty());
        }
    }
}

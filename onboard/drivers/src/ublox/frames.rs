//! Finds frames in the bytes of a line: sync characters, class, identity, length, payload, checksum
//! (UBX-22008968, section 3.2).
//!
//! The checksum is summed as the bytes arrive, so that the tick with a frame's last byte does not bear all of
//! it. After a false frame the search continues right behind its sync characters: a lost byte costs its own
//! frame and not the next one.

/// Longest expected payload: NAV-PVT's.
const LONGEST_PAYLOAD: usize = 92;
const SYNC: [u8; 2] = [0xB5, 0x62];
/// Sync characters, class, identity, length.
const HEADER: usize = 6;
const CHECKSUM: usize = 2;
const LONGEST: usize = HEADER + LONGEST_PAYLOAD + CHECKSUM;

/// A frame whose checksum is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Frame<'a> {
    pub class: u8,
    pub id: u8,
    pub payload: &'a [u8],
}

/// Why an apparent frame was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FrameError {
    /// Its checksum is wrong.
    Checksum,
    /// It is longer than any expected frame.
    Oversized,
}

/// The part of the next frame that has arrived.
#[derive(Clone, Debug)]
pub(super) struct Frames {
    /// The first `length` bytes have arrived. They begin with the sync characters.
    bytes: [u8; LONGEST],
    length: usize,
    /// Length of the frame at the front that was already returned.
    done: usize,
    /// Number of bytes that are in the checksum or before it.
    summed: usize,
    sums: [u8; CHECKSUM],
}

impl Frames {
    pub(super) const fn new() -> Self {
        Self { bytes: [0; LONGEST], length: 0, done: 0, summed: 0, sums: [0; CHECKSUM] }
    }

    /// Takes bytes off `arrived` up to the end of the next frame or false frame; `None` once all are taken.
    #[inline]
    pub(super) fn next(&mut self, arrived: &mut &[u8]) -> Option<Result<Frame<'_>, FrameError>> {
        if self.done > 0 {
            self.search_from(self.done);
        }
        while self.length < HEADER {
            self.take_header(arrived)?;
        }
        let [_, _, class, id, low, high, ..] = self.bytes;
        let payload_end = HEADER + usize::from(u16::from_le_bytes([low, high]));
        let end = payload_end + CHECKSUM;
        if end > LONGEST {
            self.search_from(SYNC.len());
            return Some(Err(FrameError::Oversized));
        }
        self.take(arrived, end);
        self.sum_up(payload_end.min(self.length));
        if self.length < end {
            return None;
        }
        if self.bytes.get(payload_end..end)? != self.sums {
            self.search_from(SYNC.len());
            return Some(Err(FrameError::Checksum));
        }
        self.done = end;
        Some(Ok(Frame { class, id, payload: self.bytes.get(HEADER..payload_end)? }))
    }

    /// Takes the sync characters, or the rest of the header; `None` if that is not complete.
    #[inline]
    fn take_header(&mut self, arrived: &mut &[u8]) -> Option<()> {
        if self.length == 0 {
            let start = arrived.iter().position(|byte| *byte == SYNC[0]).unwrap_or(arrived.len());
            *arrived = arrived.get(start..)?;
        }
        let wanted = if self.length < SYNC.len() { SYNC.len() } else { HEADER };
        self.take(arrived, wanted);
        if self.length < wanted {
            return None;
        }
        if !self.bytes.starts_with(&SYNC) {
            self.search_from(1);
        }
        Some(())
    }

    /// Takes arrived bytes until there are `wanted`.
    #[inline]
    fn take(&mut self, arrived: &mut &[u8], wanted: usize) {
        let count = wanted.saturating_sub(self.length).min(arrived.len());
        let Some((taken, rest)) = arrived.split_at_checked(count) else { return };
        if let Some(place) = self.bytes.get_mut(self.length..self.length + count) {
            place.copy_from_slice(taken);
            self.length += count;
        }
        *arrived = rest;
    }

    /// Fletcher's checksum over class, identity, length and payload, up to byte `to`.
    #[inline]
    fn sum_up(&mut self, to: usize) {
        let from = self.summed.max(SYNC.len());
        let [mut first, mut second] = self.sums;
        for byte in self.bytes.get(from..to).unwrap_or_default() {
            first = first.wrapping_add(*byte);
            second = second.wrapping_add(first);
        }
        self.sums = [first, second];
        self.summed = from.max(to);
    }

    /// Drops the first `dropped` bytes, and those after them that cannot begin a frame.
    #[inline(never)]
    fn search_from(&mut self, dropped: usize) {
        let come = self.bytes.get(..self.length).unwrap_or_default();
        let begins = |start: usize| {
            let rest = come.get(start..).unwrap_or_default();
            let seen = rest.len().min(SYNC.len());
            rest.get(..seen) == SYNC.get(..seen)
        };
        let start = (dropped..self.length).find(|start| begins(*start)).unwrap_or(self.length);
        for place in start..self.length {
            if let (Some(byte), Some(slot)) =
                (self.bytes.get(place).copied(), self.bytes.get_mut(place - start))
            {
                *slot = byte;
            }
        }
        self.length -= start;
        self.done = 0;
        self.summed = 0;
        self.sums = [0; CHECKSUM];
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn sealed(class: u8, id: u8, payload: &[u8]) -> Vec<u8> {
        let length = u16::try_from(payload.len()).unwrap().to_le_bytes();
        let mut frame = [&SYNC[..], &[class, id], &length, payload].concat();
        let sums = frame[2..].iter().fold([0_u8; 2], |[first, second], byte| {
            let first = first.wrapping_add(*byte);
            [first, second.wrapping_add(first)]
        });
        frame.extend(sums);
        frame
    }

    type Found = Vec<Result<(u8, u8, Vec<u8>), FrameError>>;

    /// Frames and errors found in bytes that arrive in pieces of these lengths, repeated in turn.
    fn found(bytes: &[u8], pieces: &[usize]) -> Found {
        let mut frames = Frames::new();
        let mut found = Vec::new();
        let mut rest = bytes;
        for piece in pieces.iter().cycle() {
            let (mut arrived, later) = rest.split_at((*piece).min(rest.len()));
            while let Some(frame) = frames.next(&mut arrived) {
                found.push(frame.map(|frame| (frame.class, frame.id, frame.payload.to_vec())));
            }
            assert!(arrived.is_empty());
            rest = later;
            if rest.is_empty() {
                return found;
            }
        }
        found
    }

    /// The example of the interface description's checksum: UBX-ACK-ACK of UBX-CFG-MSG, as receivers send it.
    #[test]
    fn a_real_acknowledgement_is_a_frame() {
        let bytes = [0xB5, 0x62, 0x05, 0x01, 0x02, 0x00, 0x06, 0x01, 0x0F, 0x38];
        assert_eq!(found(&bytes, &[3]), [Ok((5, 1, vec![6, 1]))]);
    }

    #[test]
    fn after_a_lost_byte_the_next_frame_is_whole() {
        let frame = sealed(1, 7, &[0xB5; 92]);
        for lost in 0..frame.len() {
            let cut = [&frame[..lost], &frame[lost + 1..]].concat();
            let all = found(&[cut, frame.clone()].concat(), &[1, 60]);
            assert_eq!(all.last(), Some(&Ok((1, 7, vec![0xB5; 92]))), "{lost}");
        }
    }

    #[test]
    fn what_is_longer_than_what_is_asked_for_is_said_and_passed_over() {
        let bytes = [sealed(2, 0x15, &[1; 93]), sealed(5, 1, &[6, 1])].concat();
        assert_eq!(found(&bytes, &[1]), [Err(FrameError::Oversized), Ok((5, 1, vec![6, 1]))]);
    }

    proptest! {
        /// Every frame is found whatever is between them, unless it looks like a frame itself, and however
        /// the bytes are split.
        #[test]
        fn every_frame_is_found_in_order(
            parts in prop::collection::vec(
                (prop::collection::vec(any::<u8>().prop_filter("no sync", |byte| *byte != 0xB5), 0..40),
                 any::<u8>(), any::<u8>(), prop::collection::vec(any::<u8>(), 0..=92)),
                1..8,
            ),
            pieces in prop::collection::vec(1_usize..200, 1..5),
        ) {
            let mut bytes = Vec::new();
            for (noise, class, id, payload) in &parts {
                bytes.extend(noise);
                bytes.extend(sealed(*class, *id, payload));
            }
            let expected: Found =
                parts.into_iter().map(|(_, class, id, payload)| Ok((class, id, payload))).collect();
            prop_assert_eq!(found(&bytes, &pieces), expected);
        }

        /// In arbitrary bytes the same is found however they are split, and every frame found is a real one.
        #[test]
        fn pieces_do_not_matter_and_no_frame_is_invented(
            parts in prop::collection::vec(
                prop_oneof![
                    Just(SYNC.to_vec()),
                    prop::collection::vec(any::<u8>(), 1..20),
                    (any::<u8>(), prop::collection::vec(any::<u8>(), 0..=92))
                        .prop_map(|(id, payload)| sealed(1, id, &payload)),
                ],
                1..20,
            ),
            (at, flipped) in (any::<prop::sample::Index>(), any::<u8>()),
            pieces in prop::collection::vec(1_usize..200, 1..5),
        ) {
            let mut bytes = parts.concat();
            let at = at.index(bytes.len());
            bytes[at] ^= flipped;
            let whole = found(&bytes, &[bytes.len()]);
            prop_assert_eq!(&found(&bytes, &pieces), &whole);
            for (class, id, payload) in whole.into_iter().flatten() {
                let frame = sealed(class, id, &payload);
                prop_assert!(bytes.windows(frame.len()).any(|window| window == frame));
            }
        }
    }
}

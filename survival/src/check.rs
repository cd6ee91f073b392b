//! The check that everything kept carries.

use crc::{CRC_32_ISO_HDLC, Crc};

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// CRC-32/ISO-HDLC of words, least significant byte first. Of nothing but zeros it is not zero.
pub(crate) fn of_words(words: &[u32]) -> u32 {
    let mut digest = CRC.digest();
    for word in words {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

/// As [`of_words`], of words and the bytes after them.
pub(crate) fn of_words_and_bytes(words: &[u32], bytes: &[u8]) -> u32 {
    let mut digest = CRC.digest();
    for word in words {
        digest.update(&word.to_le_bytes());
    }
    digest.update(bytes);
    digest.finalize()
}

/// Words with their check after them.
pub(crate) fn sealed<const N: usize, const SEALED: usize>(words: [u32; N]) -> [u32; SEALED] {
    const { assert!(SEALED == N + 1) };
    let check = of_words(&words);
    let mut all = words.into_iter().chain([check]);
    core::array::from_fn(|_| all.next().unwrap_or(0))
}

/// The words, if their check is right.
pub(crate) fn opened<const N: usize, const SEALED: usize>(sealed: &[u32; SEALED]) -> Option<[u32; N]> {
    const { assert!(SEALED == N + 1) };
    let (words, check) = sealed.split_last_chunk::<1>()?;
    if of_words(words) != check[0] {
        return None;
    }
    words.try_into().ok()
}

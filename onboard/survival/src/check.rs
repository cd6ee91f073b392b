//! The check of everything that is kept.

use crc::{CRC_32_ISO_HDLC, Crc};

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// CRC-32/ISO-HDLC of words, least significant byte first. It is not zero if all words are zero.
pub(crate) fn of_words(words: &[u32]) -> u32 {
    of_words_and_bytes(words, &[])
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

//! Checks the sizes in a column's pages before the `parquet` crate allocates memory for them.

use super::error::ChunkError;
use super::footer::{Chunk, Leaf};
use super::thrift::Reader;

/// Supported compressions, by the format's numbers: for these the crate allocates no more memory than the
/// page declares.
const CODECS: [(i64, &str); 4] = [(0, "none"), (1, "snappy"), (6, "zstd"), (7, "lz4")];
/// All compressions of the format, for messages.
const CODEC_NAMES: [&str; 8] = ["none", "snappy", "gzip", "lzo", "brotli", "lz4 (old)", "zstd", "lz4"];
/// Supported encodings, by the format's numbers: plain, dictionaries (old and new), runs, differences of
/// whole numbers, split bytes. Encodings of texts by common prefixes can grow without a bound.
const ENCODINGS: [i64; 6] = [0, 2, 3, 5, 8, 9];
/// Largest mean size of a page's words, bytes.
const WORD: usize = 64;
/// Largest size of a page apart from its values, bytes.
const PAGE_HEAD: usize = 1 << 16;

/// Checks that the pages of a column are within its bytes, and that their size suits their number of values.
///
/// # Errors
/// [`ChunkError`].
pub fn check(bytes: &[u8], leaf: &Leaf, chunk: &Chunk) -> Result<(), ChunkError> {
    if !CODECS.iter().any(|(codec, _)| *codec == chunk.codec) {
        let names: Vec<&str> = CODECS.iter().map(|(_, name)| *name).collect();
        let known = usize::try_from(chunk.codec).ok().and_then(|codec| CODEC_NAMES.get(codec));
        return Err(ChunkError::Codec {
            found: known.unwrap_or(&"an unknown codec"),
            known: names.join(", "),
        });
    }
    let mut reader = Reader::new(bytes);
    let mut left = chunk.values;
    while left > 0 {
        let header = reader.structure().ok_or(ChunkError::Damaged("a page's head is damaged"))?;
        let size = |number: i16| header.int(number).and_then(|value| usize::try_from(value).ok());
        let (whole, packed) =
            size(2).zip(size(3)).ok_or(ChunkError::Damaged("a page does not declare its length"))?;
        if packed > reader.left() || (chunk.codec == 0 && whole != packed) {
            return Err(ChunkError::Damaged("a page declares a wrong length"));
        }
        let body = match header.int(1) {
            Some(0) => header.field(5),
            Some(2) => header.field(7),
            Some(3) => header.field(8),
            _ => return Err(ChunkError::Damaged("a page is of an unknown kind")),
        };
        let body = body.ok_or(ChunkError::Damaged("a page does not declare its content"))?;
        let count = |number: i16| body.int(number).and_then(|value| usize::try_from(value).ok());
        let values = count(1).ok_or(ChunkError::Damaged("a page does not declare its number of values"))?;
        let is_dictionary = header.int(1) == Some(2);
        let encoding = body.int(if header.int(1) == Some(3) { 4 } else { 2 }).unwrap_or(-1);
        if !ENCODINGS.contains(&encoding) {
            return Err(ChunkError::Encoding(encoding));
        }
        if values > if is_dictionary { chunk.values } else { left } {
            return Err(ChunkError::Damaged("a page has more values than the column"));
        }
        // A dictionary contains all of its values in full, each text preceded by its length in four bytes.
        let least = if is_dictionary { values.saturating_mul(leaf.width.unwrap_or(4)) } else { 0 };
        let each = leaf.width.map_or(WORD, |width| 2 * width + 8);
        if whole < least || whole > PAGE_HEAD.saturating_add(values.saturating_mul(each)) {
            return Err(ChunkError::PageSize { values, bytes: whole });
        }
        left -= if is_dictionary { 0 } else { values };
        reader.skip(packed);
    }
    Ok(())
}

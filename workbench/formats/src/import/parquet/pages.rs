//! What the pages of a column say about themselves, before the `parquet` crate takes room for it.

use super::error::ChunkError;
use super::footer::{Chunk, Leaf};
use super::thrift::Reader;

/// How a page can be compressed, by the format's numbers: of these the crate takes no more room than the page
/// says.
const CODECS: [(i64, &str); 4] = [(0, "none"), (1, "snappy"), (6, "zstd"), (7, "lz4")];
/// All of the format's, for telling.
const CODEC_NAMES: [&str; 8] = ["none", "snappy", "gzip", "lzo", "brotli", "lz4 (old)", "zstd", "lz4"];
/// Encodings that are read, by the format's numbers: plain, dictionaries (old and new), runs, differences of
/// whole numbers, split bytes. Those of texts by their common beginnings can grow without a bound.
const ENCODINGS: [i64; 6] = [0, 2, 3, 5, 8, 9];
/// Bytes that a page's words may have each, on the average.
const WORD: usize = 64;
/// What a page has beside its values.
const PAGE_HEAD: usize = 1 << 16;

/// Whether the pages of a column are within its bytes, and as long as so many values can be.
///
/// # Errors
/// [`ChunkError`].
pub fn check(bytes: &[u8], leaf: &Leaf, chunk: &Chunk) -> Result<(), ChunkError> {
    if !CODECS.iter().any(|(codec, _)| *codec == chunk.codec) {
        let names: Vec<&str> = CODECS.iter().map(|(_, name)| *name).collect();
        let known = usize::try_from(chunk.codec).ok().and_then(|codec| CODEC_NAMES.get(codec));
        return Err(ChunkError::Codec {
            found: known.unwrap_or(&"something unknown"),
            known: names.join(", "),
        });
    }
    let mut reader = Reader::new(bytes);
    let mut left = chunk.values;
    while left > 0 {
        let header = reader.structure().ok_or(ChunkError::Damaged("a page's head is damaged"))?;
        let size = |number: i16| header.int(number).and_then(|value| usize::try_from(value).ok());
        let (whole, packed) =
            size(2).zip(size(3)).ok_or(ChunkError::Damaged("a page does not say how long it is"))?;
        if packed > reader.left() || (chunk.codec == 0 && whole != packed) {
            return Err(ChunkError::Damaged("a page is said to be longer than it is"));
        }
        let body = match header.int(1) {
            Some(0) => header.field(5),
            Some(2) => header.field(7),
            Some(3) => header.field(8),
            _ => return Err(ChunkError::Damaged("a page is of an unknown kind")),
        };
        let body = body.ok_or(ChunkError::Damaged("a page does not say what is in it"))?;
        let count = |number: i16| body.int(number).and_then(|value| usize::try_from(value).ok());
        let values = count(1).ok_or(ChunkError::Damaged("a page does not say how many values it has"))?;
        let is_dictionary = header.int(1) == Some(2);
        let encoding = body.int(if header.int(1) == Some(3) { 4 } else { 2 }).unwrap_or(-1);
        if !ENCODINGS.contains(&encoding) {
            return Err(ChunkError::Encoding(encoding));
        }
        if values > if is_dictionary { chunk.values } else { left } {
            return Err(ChunkError::Damaged("a page has more values than the column"));
        }
        // A dictionary has all of its values written out, each text behind its length in four bytes.
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

//! Layout of a log's messages, as defined by its FMT messages.
//!
//! Source: ArduPilot, `libraries/AP_Logger/LogStructure.h` (letters), and pymavlink's `DFReader` for the
//! letters of old logs.

/// Type of FMT messages in binary logs.
pub const FMT: u8 = 128;
/// Length of a header, bytes: two that mark it and the type.
pub const HEADER: usize = 3;
/// Length of a FMT message, bytes.
pub const FMT_LEN: usize = 89;

/// One field of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its letter.
    pub letter: u8,
    /// Offset from the end of the message's header.
    offset: usize,
}

/// One kind of message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Its type.
    pub kind: u8,
    /// Its name.
    pub name: String,
    /// Its fields.
    pub fields: Vec<Field>,
    /// Bytes after the header.
    pub len: usize,
}

/// Size of a letter's value, bytes; `None` for an unknown letter.
const fn bytes(letter: u8) -> Option<usize> {
    Some(match letter {
        b'b' | b'B' | b'M' => 1,
        b'h' | b'H' | b'c' | b'C' | b'g' => 2,
        b'i' | b'I' | b'f' | b'e' | b'E' | b'L' | b'n' => 4,
        b'd' | b'q' | b'Q' => 8,
        b'N' => 16,
        b'Z' | b'a' => 64,
        _ => return None,
    })
}

/// Divisor of a letter's number; text logs are already divided.
const fn divisor(letter: u8) -> f64 {
    match letter {
        b'c' | b'C' | b'e' | b'E' => 100.0,
        b'L' => 1e7,
        _ => 1.0,
    }
}

/// Whether a letter has its own scale, so that no MULT is applied.
pub const fn has_scale(letter: u8) -> bool {
    matches!(letter, b'c' | b'C' | b'e' | b'E' | b'L')
}

/// Whether a letter's number is an integer.
pub const fn is_integer(letter: u8) -> bool {
    matches!(letter, b'b' | b'B' | b'h' | b'H' | b'i' | b'I' | b'q' | b'Q')
}

/// Text up to its first NUL.
pub fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(bytes.get(..end).unwrap_or_default()).into_owned()
}

impl Layout {
    /// From the parts of a definition; `None` if they contradict each other. `length` includes the header and
    /// is missing in some text logs.
    pub fn new(kind: u8, length: Option<usize>, name: &str, letters: &str, columns: &str) -> Option<Self> {
        let is_name = |name: &str| {
            !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
        };
        let names: Vec<&str> =
            columns.split(',').map(str::trim).filter(|column| !column.is_empty()).collect();
        let letters = letters.trim().as_bytes();
        if !is_name(name) || names.len() > letters.len() {
            return None;
        }
        let mut fields = Vec::with_capacity(names.len());
        let mut offset = 0;
        for (index, letter) in letters.iter().enumerate() {
            if let Some(name) = names.get(index) {
                fields.push(Field { name: (*name).to_owned(), letter: *letter, offset });
            }
            offset += bytes(*letter)?;
        }
        let agrees = length.is_none_or(|length| length == HEADER + offset);
        agrees.then(|| Self { kind, name: name.to_owned(), fields, len: offset })
    }

    /// From a FMT message's bytes after its header.
    pub fn from_fmt(body: &[u8]) -> Option<Self> {
        let part = |from: usize, to: usize| body.get(from..to).map(text);
        let (&kind, &length) = (body.first()?, body.get(1)?);
        let (name, letters, columns) = (part(2, 6)?, part(6, 22)?, part(22, 86)?);
        Self::new(kind, Some(usize::from(length)), &name, &letters, &columns)
    }

    /// Index of the first of these names that is a field.
    pub fn field(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.fields.iter().position(|field| field.name == *name))
    }
}

/// A message's values, not yet read.
#[derive(Clone, Copy, Debug)]
pub enum Body<'a> {
    /// Bytes after the header.
    Binary(&'a [u8]),
    /// The parts of a line after the name.
    Text(&'a [&'a str]),
}

/// One message.
#[derive(Clone, Copy, Debug)]
pub struct Message<'a> {
    /// Index of its layout among the log's.
    pub layout: usize,
    /// Byte or line in the file.
    pub place: usize,
    /// Its values.
    pub body: Body<'a>,
}

impl Message<'_> {
    /// The number in a field, by its index in the layout, in the unit of its letter; `None` for text and what
    /// cannot be read.
    pub fn number(&self, layout: &Layout, index: usize) -> Option<f64> {
        let field = layout.fields.get(index)?;
        match self.body {
            Body::Binary(bytes) => binary_number(bytes.get(field.offset..)?, field.letter),
            Body::Text(parts) => parts.get(index)?.parse().ok(),
        }
    }

    /// The text in a field.
    pub fn text(&self, layout: &Layout, index: usize) -> Option<String> {
        let field = layout.fields.get(index)?;
        match self.body {
            Body::Binary(body) if matches!(field.letter, b'n' | b'N' | b'Z') => {
                body.get(field.offset..field.offset + bytes(field.letter)?).map(text)
            }
            Body::Binary(_) => None,
            Body::Text(parts) => parts.get(index).map(|part| (*part).to_owned()),
        }
    }
}

fn binary_number(bytes: &[u8], letter: u8) -> Option<f64> {
    macro_rules! read {
        ($kind:ty) => {
            bytes.first_chunk().map(|chunk| <$kind>::from_le_bytes(*chunk))
        };
    }
    let number = match letter {
        b'b' | b'M' => f64::from(read!(i8)?),
        b'B' => f64::from(read!(u8)?),
        b'h' | b'c' => f64::from(read!(i16)?),
        b'H' | b'C' => f64::from(read!(u16)?),
        b'i' | b'e' | b'L' => f64::from(read!(i32)?),
        b'I' | b'E' => f64::from(read!(u32)?),
        b'q' => read!(i64)? as f64,
        b'Q' => read!(u64)? as f64,
        b'f' => f64::from(read!(f32)?),
        b'd' => read!(f64)?,
        b'g' => half(read!(u16)?),
        _ => return None,
    };
    Some(number / divisor(letter))
}

/// A number of IEEE 754's binary16.
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    sign * match exponent {
        0 => fraction * 2_f64.powi(-24),
        0x1f if fraction == 0.0 => f64::INFINITY,
        0x1f => f64::NAN,
        _ => (1.0 + fraction / 1024.0) * 2_f64.powi(exponent - 15),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_is_read_at_its_place() {
        // Each letter with the bytes of one value, little-endian, and the value.
        let values: [(u8, &[u8], f64); 17] = [
            (b'b', &[0xfe], -2.0),
            (b'B', &[0xfe], 254.0),
            (b'M', &[5], 5.0),
            (b'h', &[0x00, 0x80], -32_768.0),
            (b'H', &[0x00, 0x80], 32_768.0),
            (b'c', &[0x9c, 0xff], -1.0),
            (b'C', &[0x39, 0x30], 123.45),
            (b'i', &[0xff, 0xff, 0xff, 0xff], -1.0),
            (b'I', &[0xff, 0xff, 0xff, 0xff], 4_294_967_295.0),
            (b'e', &[0x18, 0xfc, 0xff, 0xff], -10.0),
            (b'E', &[0xe8, 0x03, 0, 0], 10.0),
            (b'L', &[0x15, 0xcd, 0x5b, 0x07], 12.345_678_9),
            (b'f', &[0, 0, 0x20, 0xc1], -10.0),
            (b'd', &[0, 0, 0, 0, 0, 0, 0x24, 0x40], 10.0),
            (b'q', &[0xff; 8], -1.0),
            (b'Q', &[1, 0, 0, 0, 0, 0, 0, 0], 1.0),
            (b'g', &[0x00, 0xc9], -10.0),
        ];
        for first in 0..values.len() {
            // A definition holds at most sixteen letters.
            let some: Vec<_> = (0..16).map(|k| values[(first + k) % values.len()]).collect();
            let letters: String = some.iter().map(|(letter, ..)| char::from(*letter)).collect();
            let names: Vec<String> = (0..16).map(|k| format!("F{k}")).collect();
            let bytes: Vec<u8> = some.iter().flat_map(|(_, bytes, _)| *bytes).copied().collect();
            let layout =
                Layout::new(7, Some(HEADER + bytes.len()), "TEST", &letters, &names.join(",")).unwrap();
            let message = Message { layout: 0, place: 0, body: Body::Binary(&bytes) };
            for (index, (letter, _, value)) in some.iter().enumerate() {
                assert_eq!(message.number(&layout, index), Some(*value), "{}", char::from(*letter));
            }
            let cut = Message { layout: 0, place: 0, body: Body::Binary(&bytes[..bytes.len() - 1]) };
            assert_eq!(cut.number(&layout, 15), None);
        }
    }

    #[test]
    fn texts_end_at_their_first_nul() {
        let layout = Layout::new(7, Some(3 + 4 + 16 + 64 + 64), "TEXT", "nNZa", "A,B,C,D").unwrap();
        let mut bytes = vec![0_u8; 148];
        bytes[..4].copy_from_slice(b"ABCD");
        bytes[4..9].copy_from_slice(b"xy\0zz");
        let message = Message { layout: 0, place: 0, body: Body::Binary(&bytes) };
        assert_eq!(message.text(&layout, 0).unwrap(), "ABCD");
        assert_eq!(message.text(&layout, 1).unwrap(), "xy");
        assert_eq!(message.text(&layout, 2).unwrap(), "");
        assert_eq!(message.text(&layout, 3), None);
        assert_eq!(message.number(&layout, 0), None);
    }

    #[test]
    fn definitions_that_contradict_themselves_are_none() {
        assert!(Layout::new(1, Some(3 + 4), "OK", "BBH", "A,B,C").is_some());
        assert!(Layout::new(1, Some(3 + 5), "LEN", "BBH", "A,B,C").is_none());
        assert!(Layout::new(1, None, "X", "B?H", "A,B,C").is_none());
        assert!(Layout::new(1, None, "X", "BB", "A,B,C").is_none());
        assert!(Layout::new(1, None, "\u{1}X", "B", "A").is_none());
        assert!(Layout::from_fmt(&[0; 20]).is_none());
    }

    #[test]
    fn halves_are_those_of_the_standard() {
        for (bits, value) in
            [(0x3c00, 1.0), (0x0001, 2_f64.powi(-24)), (0x7bff, 65_504.0), (0xfc00, f64::NEG_INFINITY)]
        {
            assert_eq!(half(bits), value);
        }
        assert!(half(0x7e00).is_nan());
    }
}

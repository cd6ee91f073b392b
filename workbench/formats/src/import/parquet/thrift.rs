//! Reads Thrift's compact protocol
//! (<https://github.com/apache/thrift/blob/master/doc/specs/thrift-compact-protocol.md>), in which Parquet's
//! metadata are written, as a tree of values.
//!
//! The `parquet` crate reads it too, but allocates as many items as a list declares. Here a list has at most
//! as many items as there are bytes left, so the tree is bounded by the number of bytes.

/// Largest nesting of structures. Parquet's own are nested seven deep.
const DEEPEST: usize = 16;

/// One value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value<'a> {
    /// Any whole number; 0 and 1 for false and true.
    Int(i64),
    /// Text, or bytes.
    Bytes(&'a [u8]),
    /// A list or a set.
    List(Vec<Value<'a>>),
    /// Fields by their numbers.
    Struct(Vec<(i16, Value<'a>)>),
    /// Types that Parquet does not need here: doubles, maps.
    Other,
}

impl<'a> Value<'a> {
    /// A field of a structure.
    pub fn field(&self, number: i16) -> Option<&Self> {
        let Self::Struct(fields) = self else { return None };
        fields.iter().find(|(own, _)| *own == number).map(|(_, value)| value)
    }

    /// A field that is a whole number.
    pub fn int(&self, number: i16) -> Option<i64> {
        if let Some(Value::Int(value)) = self.field(number) { Some(*value) } else { None }
    }

    /// A field that is a text; invalid UTF-8 is replaced.
    pub fn text(&self, number: i16) -> Option<String> {
        let Some(Value::Bytes(bytes)) = self.field(number) else { return None };
        Some(String::from_utf8_lossy(bytes).into_owned())
    }

    /// A field that is a list; empty if it is missing.
    pub fn list(&self, number: i16) -> &[Value<'a>] {
        if let Some(Value::List(values)) = self.field(number) { values } else { &[] }
    }
}

/// The bytes not yet read.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// From bytes.
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Number of bytes left.
    pub const fn left(&self) -> usize {
        self.rest.len()
    }

    /// Reads a structure; `None` if the bytes are not one.
    pub fn structure(&mut self) -> Option<Value<'a>> {
        self.structure_at(0)
    }

    /// Skips `length` bytes, or to the end.
    pub fn skip(&mut self, length: usize) {
        self.rest = self.rest.get(length..).unwrap_or_default();
    }

    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.rest.split_first()?;
        self.rest = rest;
        Some(*first)
    }

    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(length)?;
        self.rest = rest;
        Some(taken)
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    fn zigzag(&mut self) -> Option<i64> {
        let value = self.varint()?;
        Some((value >> 1).cast_signed() ^ -(value & 1).cast_signed())
    }

    fn structure_at(&mut self, depth: usize) -> Option<Value<'a>> {
        if depth > DEEPEST {
            return None;
        }
        let mut fields = Vec::new();
        let mut number: i16 = 0;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Some(Value::Struct(fields));
            }
            number = match head >> 4 {
                0 => i16::try_from(self.zigzag()?).ok()?,
                step => number.checked_add(i16::from(step))?,
            };
            let value = match head & 0x0f {
                // The head of a field contains whether it is true.
                1 => Value::Int(1),
                2 => Value::Int(0),
                kind => self.value(kind, depth)?,
            };
            fields.push((number, value));
        }
    }

    fn value(&mut self, kind: u8, depth: usize) -> Option<Value<'a>> {
        Some(match kind {
            1 | 2 => Value::Int(i64::from(self.byte()? == 1)),
            3 => Value::Int(i64::from(self.byte()?.cast_signed())),
            4..=6 => Value::Int(self.zigzag()?),
            7 => self.take(8).map(|_| Value::Other)?,
            8 => {
                let length = usize::try_from(self.varint()?).ok()?;
                Value::Bytes(self.take(length)?)
            }
            9 | 10 => {
                let head = self.byte()?;
                let count = if head >> 4 == 15 { self.varint()? } else { u64::from(head >> 4) };
                let count = usize::try_from(count).ok().filter(|count| *count <= self.left())?;
                let mut values = Vec::new();
                for _ in 0..count {
                    values.push(self.value_within(head & 0x0f, depth)?);
                }
                Value::List(values)
            }
            11 => {
                let count = self.varint()?;
                let kinds = if count == 0 { 0 } else { self.byte()? };
                for _ in 0..count {
                    self.value_within(kinds >> 4, depth)?;
                    self.value_within(kinds & 0x0f, depth)?;
                }
                Value::Other
            }
            12 => self.structure_at(depth + 1)?,
            _ => return None,
        })
    }

    fn value_within(&mut self, kind: u8, depth: usize) -> Option<Value<'a>> {
        if depth > DEEPEST { None } else { self.value(kind, depth + 1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_what_the_protocol_says() {
        // 1: i32 -3; 2: true; 18 (after 16 more): "ab"; 19: list of i32 [1, -1]; end.
        let bytes = [0x15, 5, 0x11, 0x08, 36, 2, b'a', b'b', 0x19, 0x25, 2, 1, 0];
        let mut reader = Reader::new(&bytes);
        let value = reader.structure().unwrap();
        assert_eq!((value.int(1), value.int(2), value.text(18).as_deref()), (Some(-3), Some(1), Some("ab")));
        assert_eq!(value.list(19), [Value::Int(1), Value::Int(-1)]);
        assert_eq!(reader.left(), 0);
    }

    #[test]
    fn what_says_that_it_is_longer_than_it_is_is_refused() {
        // A list of 2^31 structures; a text of 2^31 bytes; structures nested without end.
        assert_eq!(Reader::new(&[0x19, 0xfc, 0x80, 0x80, 0x80, 0x80, 8, 0, 0]).structure(), None);
        assert_eq!(Reader::new(&[0x18, 0x80, 0x80, 0x80, 0x80, 8, 0]).structure(), None);
        assert_eq!(Reader::new(&[0x1c; 100_000]).structure(), None);
        assert_eq!(Reader::new(&[0x19; 100_000]).structure(), None);
    }
}

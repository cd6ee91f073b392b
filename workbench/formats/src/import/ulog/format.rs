//! Layout of a ULog's messages, as given by its format definitions.
//!
//! Source: PX4 developer guide, "ULog File Format".

use std::cell::RefCell;
use std::collections::BTreeMap;

/// Largest nesting of formats; a log that nests deeper is damaged.
const DEEPEST: usize = 8;
/// Limit on sizes and counts: more than a message's 16 bits of length.
const LONGEST: usize = 1 << 16;

/// A type of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    /// The type of that name.
    pub fn of(name: &str) -> Option<Self> {
        Some(match name {
            "int8_t" => Self::I8,
            "uint8_t" | "bool" | "char" => Self::U8,
            "int16_t" => Self::I16,
            "uint16_t" => Self::U16,
            "int32_t" => Self::I32,
            "uint32_t" => Self::U32,
            "int64_t" => Self::I64,
            "uint64_t" => Self::U64,
            "float" => Self::F32,
            "double" => Self::F64,
            _ => return None,
        })
    }

    /// Size of one value, bytes.
    pub const fn len(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number at the beginning of these bytes.
    pub fn read(self, bytes: &[u8]) -> Option<f64> {
        macro_rules! read {
            ($kind:ty) => {
                bytes.first_chunk().map(|chunk| <$kind>::from_le_bytes(*chunk))
            };
        }
        Some(match self {
            Self::I8 => f64::from(read!(i8)?),
            Self::U8 => f64::from(read!(u8)?),
            Self::I16 => f64::from(read!(i16)?),
            Self::U16 => f64::from(read!(u16)?),
            Self::I32 => f64::from(read!(i32)?),
            Self::U32 => f64::from(read!(u32)?),
            Self::I64 => read!(i64)? as f64,
            Self::U64 => read!(u64)? as f64,
            Self::F32 => f64::from(read!(f32)?),
            Self::F64 => read!(f64)?,
        })
    }
}

/// One field of a format.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Member {
    kind: String,
    /// Number of values.
    count: usize,
    name: String,
}

/// Position of a number in a message's data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Offset from the beginning of the data.
    pub offset: usize,
    /// Its type.
    pub scalar: Scalar,
}

/// Every format that a log defines.
#[derive(Clone, Debug, Default)]
pub struct Formats {
    of_name: BTreeMap<String, Vec<Member>>,
    /// Sizes already computed: a log may name the same formats within each other many thousand times.
    sizes: RefCell<BTreeMap<String, usize>>,
}

impl Formats {
    /// Adds a definition's text; returns false if it is invalid or contradicts an earlier one.
    pub fn define(&mut self, text: &str) -> bool {
        let Some((name, members)) = parse(text) else { return false };
        match self.of_name.get(&name) {
            Some(known) => *known == members,
            None => {
                self.of_name.insert(name, members);
                true
            }
        }
    }

    /// Size of a format's message, bytes, and how many of them are padding at its end, which a log may leave
    /// out.
    pub fn len(&self, name: &str) -> Option<(usize, usize)> {
        let members = self.of_name.get(name)?;
        let total = self.size(name, 0)?;
        let padding = members
            .last()
            .filter(|member| member.name.starts_with("_padding"))
            .and_then(|member| self.member_size(member, 0))
            .unwrap_or(0);
        Some((total, padding))
    }

    /// The fields of a format.
    pub fn fields(&self, format: &str) -> impl Iterator<Item = &str> {
        self.of_name.get(format).into_iter().flatten().map(|member| member.name.as_str())
    }

    fn size(&self, name: &str, depth: usize) -> Option<usize> {
        if let Some(known) = self.sizes.borrow().get(name) {
            return Some(*known);
        }
        let members = self.of_name.get(name).filter(|_| depth < DEEPEST)?;
        let size = members.iter().try_fold(0_usize, |sum, member| {
            sum.checked_add(self.member_size(member, depth)?).filter(|sum| *sum < LONGEST)
        })?;
        self.sizes.borrow_mut().insert(name.to_owned(), size);
        Some(size)
    }

    fn member_size(&self, member: &Member, depth: usize) -> Option<usize> {
        let one = match Scalar::of(&member.kind) {
            Some(scalar) => scalar.len(),
            None => self.size(&member.kind, depth + 1)?,
        };
        one.checked_mul(member.count).filter(|size| *size < LONGEST)
    }

    /// Position of a number, by its path: `gyro_rad[2]`, `esc[0].esc_rpm`.
    pub fn find(&self, format: &str, path: &str) -> Option<Place> {
        let mut format = format;
        let mut rest = path;
        let mut offset = 0;
        for depth in 0..DEEPEST {
            let (step, next) = match rest.split_once('.') {
                Some((step, next)) => (step, Some(next)),
                None => (rest, None),
            };
            let (name, index) = match step.split_once('[') {
                Some((name, index)) => (name, index.strip_suffix(']')?.parse().ok()?),
                None => (step, 0),
            };
            let mut member = None;
            for candidate in self.of_name.get(format)? {
                if candidate.name == name {
                    member = Some(candidate);
                    break;
                }
                offset += self.member_size(candidate, depth)?;
            }
            let member = member.filter(|member| index < member.count)?;
            offset += self.member_size(member, depth)? / member.count * index;
            match (Scalar::of(&member.kind), next) {
                (Some(scalar), None) => return Some(Place { offset, scalar }),
                (None, Some(next)) => {
                    format = &member.kind;
                    rest = next;
                }
                _ => return None,
            }
        }
        None
    }
}

/// `name:type field;type[3] other;`
fn parse(text: &str) -> Option<(String, Vec<Member>)> {
    let (name, members) = text.split_once(':')?;
    let is_name = |name: &str| {
        !name.is_empty()
            && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b'/'))
    };
    let members: Option<Vec<Member>> = members
        .split(';')
        .map(str::trim)
        .filter(|member| !member.is_empty())
        .map(|member| {
            let (kind, name) = member.split_once(' ')?;
            let (kind, count) = match kind.split_once('[') {
                Some((kind, count)) => (kind, count.strip_suffix(']')?.parse().ok()?),
                None => (kind, 1),
            };
            (is_name(kind) && is_name(name) && (1..LONGEST).contains(&count)).then(|| Member {
                kind: kind.to_owned(),
                count,
                name: name.to_owned(),
            })
        })
        .collect();
    let members = members.filter(|members| is_name(name) && !members.is_empty())?;
    Some((name.to_owned(), members))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formats() -> Formats {
        let mut formats = Formats::default();
        assert!(
            formats.define("outer:uint64_t timestamp;inner[3] parts;float[2] pair;uint8_t[4] _padding0;")
        );
        assert!(formats.define("inner:bool good;double[2] value;"));
        formats
    }

    #[test]
    fn nested_and_repeated_fields_are_found() {
        let formats = formats();
        assert_eq!(formats.len("outer"), Some((8 + 3 * 17 + 8 + 4, 4)));
        let place = |path| formats.find("outer", path).map(|place| (place.offset, place.scalar));
        assert_eq!(place("timestamp"), Some((0, Scalar::U64)));
        assert_eq!(place("parts[2].value[1]"), Some((8 + 34 + 1 + 8, Scalar::F64)));
        assert_eq!(place("parts.good"), Some((8, Scalar::U8)));
        assert_eq!(place("pair[1]"), Some((8 + 51 + 4, Scalar::F32)));
        for missing in ["pair[2]", "parts", "parts[3].good", "timestamp.x", "none", "pair[x]", "pair[1"] {
            assert_eq!(place(missing), None, "{missing}");
        }
    }

    #[test]
    fn definitions_that_are_none_are_refused() {
        let mut formats = formats();
        assert!(formats.define("inner:bool good;double[2] value;"));
        for bad in [
            "inner:bool good;",
            "x",
            "x:float",
            "x:float[ a;",
            "x:float[0] a;",
            "x:float[99999999999] a;",
            "x y:float a;",
            "empty:",
            ":",
        ] {
            assert!(!formats.define(bad), "{bad}");
        }
        // One that contains itself, and one that would take gigabytes.
        assert!(formats.define("loop:loop[2] again;") && formats.define("wide:uint64_t[60000] a;"));
        assert_eq!((formats.len("loop"), formats.len("wide"), formats.len("none")), (None, None, None));
        assert_eq!(formats.find("loop", "again.again.again"), None);
        assert!(formats.define("holder:none a;float b;"));
        assert_eq!(formats.find("holder", "b"), None);
    }
}

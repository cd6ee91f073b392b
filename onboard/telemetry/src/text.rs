//! Texts of fifty bytes, without the standard library's formatting, which can panic.

/// Length of a STATUSTEXT, bytes.
pub const MAX_TEXT: usize = 50;

/// A text. An excess is cut off, which no text of this crate reaches (a test).
#[derive(Clone, Copy, Debug)]
pub struct Text {
    bytes: [u8; MAX_TEXT],
    len: usize,
}

impl Text {
    /// An empty text.
    pub const fn new() -> Self {
        Self { bytes: [0; MAX_TEXT], len: 0 }
    }

    /// The bytes; zeros follow a shorter text.
    pub const fn bytes(&self) -> [u8; MAX_TEXT] {
        self.bytes
    }

    /// Adds a text.
    #[inline(never)]
    pub fn text(&mut self, text: &str) -> &mut Self {
        for byte in text.bytes() {
            self.byte(byte);
        }
        self
    }

    /// Adds a whole number.
    #[inline(never)]
    pub fn number(&mut self, number: u64) -> &mut Self {
        // The largest has twenty digits.
        let mut digits = [0_u8; 20];
        let mut rest = number;
        let mut count = 0;
        for digit in &mut digits {
            *digit = b'0' + (rest % 10) as u8;
            rest /= 10;
            count += 1;
            if rest == 0 {
                break;
            }
        }
        for digit in digits.iter().take(count).rev() {
            self.byte(*digit);
        }
        self
    }

    /// Adds a time as seconds with three decimals.
    pub fn seconds(&mut self, time_us: u64) -> &mut Self {
        let milliseconds = time_us / 1_000;
        self.number(milliseconds / 1_000).text(".").padded(milliseconds % 1_000, 100)
    }

    /// Adds metres: one decimal below 1000 m, none above; `nan` if not a number, `huge` from 100 km on.
    pub fn metres(&mut self, metres: f32) -> &mut Self {
        if metres.is_nan() {
            return self.text("nan");
        }
        if metres < 0.0 {
            self.text("-");
        }
        let size = libm::fabsf(metres);
        // At 999.95 rounding to one decimal would give 1000.0.
        if size < 999.95 {
            let tenths = libm::roundf(size * 10.0) as u64;
            self.number(tenths / 10).text(".").number(tenths % 10)
        } else if size < 99_999.5 {
            self.number(libm::roundf(size) as u64)
        } else {
            self.text("huge")
        }
    }

    /// Adds a number with leading zeros, from the digit of `place` on.
    fn padded(&mut self, number: u64, place: u64) -> &mut Self {
        let mut place = place;
        while place > number && place > 1 {
            self.byte(b'0');
            place /= 10;
        }
        self.number(number)
    }

    fn byte(&mut self, byte: u8) {
        if let Some(slot) = self.bytes.get_mut(self.len) {
            *slot = byte;
            self.len += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: Text) -> String {
        String::from_utf8(text.bytes[..text.len].to_vec()).unwrap()
    }

    #[test]
    fn numbers_are_written_as_people_write_them() {
        assert_eq!(said(*Text::new().number(0)), "0");
        assert_eq!(said(*Text::new().number(u64::MAX)), u64::MAX.to_string());
        for time_us in [0, 999, 1_000, 45_000, 123_456_789, 5_007_000] {
            let expected = format!("{:.3}", (time_us / 1_000) as f64 / 1e3);
            assert_eq!(said(*Text::new().seconds(time_us)), expected);
        }
        for (metres, expected) in [
            (0.0, "0.0"),
            (-0.04, "-0.0"),
            (-40.33, "-40.3"),
            (999.94, "999.9"),
            (999.96, "1000"),
            (-99_999.0, "-99999"),
            (1e9, "huge"),
            (f32::NAN, "nan"),
            (f32::NEG_INFINITY, "-huge"),
        ] {
            assert_eq!(said(*Text::new().metres(metres)), expected, "{metres}");
        }
    }

    #[test]
    fn fifty_bytes_are_all_that_fit() {
        let text = *Text::new().text(&"x".repeat(49)).number(123);
        assert_eq!(said(text), format!("{}1", "x".repeat(49)));
    }
}

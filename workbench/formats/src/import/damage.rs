//! How much of a log is damaged, and where.

/// Bytes that could not be read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Damage {
    /// Stretches.
    pub stretches: usize,
    /// Bytes in them.
    pub bytes: usize,
    /// Where the first of them begins.
    pub first: usize,
    /// Where the last message begins, if the file ends within it.
    pub cut_at: Option<usize>,
}

impl Damage {
    /// Adds a stretch of `bytes` bytes.
    pub fn lost(&mut self, at: usize, bytes: usize) {
        if self.stretches == 0 {
            self.first = at;
        }
        self.stretches += 1;
        self.bytes += bytes;
    }

    /// As text, for a log of `len` bytes.
    pub fn notes(&self, len: usize) -> Vec<String> {
        let mut notes = Vec::new();
        if self.stretches > 0 {
            let places = if self.stretches == 1 {
                "1 stretch".to_owned()
            } else {
                format!("{} stretches", self.stretches)
            };
            notes.push(format!(
                "damaged: {places}, {} of the file's {len} bytes ({}), the first at byte {}; what is before and after \
                 was read",
                self.bytes,
                percent(self.bytes, len),
                self.first
            ));
        }
        if let Some(at) = self.cut_at {
            notes.push(format!("the file ends within its last message, which begins at byte {at}"));
        }
        notes
    }
}

/// A share in per cent, with two significant digits below one per cent.
pub fn percent(part: usize, whole: usize) -> String {
    let percent = 100.0 * part as f64 / whole.max(1) as f64;
    match percent {
        _ if part == 0 => "0 %".to_owned(),
        percent if percent >= 10.0 => format!("{percent:.0} %"),
        percent if percent >= 1.0 => format!("{percent:.1} %"),
        percent if percent >= 0.01 => format!("{percent:.2} %"),
        _ => "less than 0.01 %".to_owned(),
    }
}

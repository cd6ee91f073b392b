//! Messages of a text log (`.log`).

use std::collections::HashMap;

use super::format::{Body, Layout, Message};

/// What was left out of a text log.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Unread {
    /// Lines that could not be read.
    pub lines: usize,
    /// The first of them, from 1.
    pub first: usize,
    /// Lines of undefined kinds.
    pub undefined: usize,
    /// Definitions that contradict themselves or an earlier one.
    pub bad_definitions: usize,
}

/// The lines of a text log.
pub struct Lines<'a> {
    log: &'a [u8],
    layouts: Vec<Layout>,
    by_name: HashMap<String, usize>,
    /// Lines that were left out.
    pub unread: Unread,
    /// Lines before the first definition: the autopilot's name, in old logs.
    pub preamble: Vec<String>,
}

/// The lines of a text, counted from 1, each without leading or trailing spaces.
fn lines(log: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let log = log.strip_prefix(b"\xef\xbb\xbf").unwrap_or(log);
    let end = if log.contains(&b'\n') { b'\n' } else { b'\r' };
    log.split(move |byte| *byte == end).enumerate().map(|(index, line)| (index + 1, line.trim_ascii()))
}

fn parts(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(str::trim)
}

/// Parses the line of a definition.
fn definition(line: &str) -> Option<Option<Layout>> {
    let mut parts = parts(line);
    if parts.next() != Some("FMT") {
        return None;
    }
    let kind = parts.next().and_then(|kind| kind.parse().ok());
    let length = parts.next().and_then(|length| length.parse().ok());
    let (name, letters) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    let columns = parts.collect::<Vec<_>>().join(",");
    // Some logs leave out the last column name of FMT itself.
    Some(kind.and_then(|kind| Layout::new(kind, length, name, letters, &columns)))
}

/// Whether these lines contain a definition.
pub fn has_definition(log: &[u8]) -> bool {
    lines(log).any(|(_, line)| {
        line.starts_with(b"FMT")
            && std::str::from_utf8(line).is_ok_and(|line| matches!(definition(line), Some(Some(_))))
    })
}

impl<'a> Lines<'a> {
    /// The lines of a log.
    pub fn new(log: &'a [u8]) -> Self {
        let mut found = Self {
            log,
            layouts: Vec::new(),
            by_name: HashMap::new(),
            unread: Unread::default(),
            preamble: Vec::new(),
        };
        let mut any = false;
        for (number, line) in lines(log) {
            let Ok(line) = std::str::from_utf8(line) else { continue };
            match definition(line) {
                Some(Some(layout)) => {
                    any = true;
                    let known = found.by_name.get(&layout.name).and_then(|index| found.layouts.get(*index));
                    match known {
                        None => {
                            found.by_name.insert(layout.name.clone(), found.layouts.len());
                            found.layouts.push(layout);
                        }
                        Some(known) if *known == layout => {}
                        Some(_) => found.bad(number),
                    }
                }
                Some(None) => found.bad(number),
                None if !any && !line.is_empty() && found.preamble.len() < 16 => {
                    found
                        .preamble
                        .push(line.chars().filter(|letter| !letter.is_control()).take(80).collect());
                }
                None => {}
            }
        }
        found
    }

    fn bad(&mut self, number: usize) {
        self.unread.bad_definitions += 1;
        self.unread.first = if self.unread.first == 0 { number } else { self.unread.first.min(number) };
    }

    fn lost(&mut self, number: usize) {
        self.unread.lines += 1;
        self.unread.first = if self.unread.first == 0 { number } else { self.unread.first.min(number) };
    }

    /// Every kind of message that the log defines.
    pub fn layouts(&self) -> &[Layout] {
        &self.layouts
    }

    /// Passes on every message; `take` returns whether its numbers could be read.
    pub fn each(&mut self, mut take: impl FnMut(&Message<'_>) -> bool) {
        let mut is_preamble = true;
        let mut scratch: Vec<&str> = Vec::new();
        for (place, line) in lines(self.log) {
            if line.is_empty() {
                continue;
            }
            let Ok(line) = std::str::from_utf8(line) else {
                self.lost(place);
                continue;
            };
            let name = parts(line).next().unwrap_or_default();
            if name == "FMT" {
                is_preamble = false;
                continue;
            }
            if is_preamble {
                continue;
            }
            let Some(layout) = self.by_name.get(name).copied() else {
                if line.contains(',') {
                    self.unread.undefined += 1;
                } else {
                    self.lost(place);
                }
                continue;
            };
            let fields = self.layouts.get(layout).map_or(0, |layout| layout.fields.len());
            scratch.clear();
            // A text in the last field may contain commas.
            scratch.extend(line.splitn(fields + 1, ',').skip(1).map(str::trim));
            let message = Message { layout, place, body: Body::Text(&scratch) };
            if scratch.len() < fields || !take(&message) {
                self.lost(place);
            }
        }
    }
}

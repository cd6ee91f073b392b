//! Reads the messages of a ULog and skips what is not a message.

use std::collections::BTreeMap;

use super::format::Formats;
use crate::import::damage::Damage;

/// Start of every ULog; a version and the start time follow.
pub const MAGIC: [u8; 7] = [b'U', b'L', b'o', b'g', 0x01, 0x12, 0x35];
/// Bytes before the first message.
const FILE_HEADER: usize = 16;
/// Size of a message's header (length and kind), bytes.
const HEADER: usize = 3;
/// Payload of a message of kind S.
const SYNC: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];
/// The only incompatible flag that this reader supports: data were appended.
const DATA_APPENDED: u8 = 1;

/// One logged topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subscription {
    /// Its name.
    pub topic: String,
    /// Its instance.
    pub instance: u8,
    /// Length of its data and how many bytes of it may be missing; none if its format is not defined.
    pub len: Option<(usize, usize)>,
}

impl Subscription {
    /// Its name for users: the first instance has no number.
    pub fn name(&self) -> String {
        let number = u16::from(self.instance) + 1;
        let instance = if number > 1 { format!(" {number}") } else { String::new() };
        format!("{}{instance}", self.topic)
    }
}

/// One message.
#[derive(Clone, Copy, Debug)]
pub enum Message<'a> {
    /// Data of a topic.
    Data { id: u16, at: usize, data: &'a [u8] },
    /// A parameter: its name and value.
    Parameter { name: &'a str, value: f64 },
    /// A text about the log: its name and value.
    Info { name: &'a str, value: &'a [u8] },
    /// The logger lost data for this many milliseconds.
    Dropout { ms: u16 },
}

/// The messages of a ULog, in file order.
pub struct Reader<'a> {
    log: &'a [u8],
    at: usize,
    /// Where data were appended after a crash; the message that was being written ends there.
    appended: Vec<usize>,
    /// All format definitions.
    pub formats: Formats,
    /// Topics by message id.
    pub subscriptions: BTreeMap<u16, Subscription>,
    /// By message id, the length of the data and how many bytes of it may be missing. Every message looks
    /// this up twice.
    lengths: Vec<Option<(usize, usize)>>,
    /// Place and end of the message that confirms the one before it. It is read next, so its end is kept.
    ahead: Option<(usize, usize)>,
    /// What was left out as damaged.
    pub damage: Damage,
    /// Messages that were cut short when the autopilot failed; appended data follow them.
    pub interrupted: usize,
    /// Definitions that are invalid or contradict an earlier one.
    pub bad_definitions: usize,
    /// Number of unreadable data messages by id: the id has no subscription, or its format is undefined or
    /// has another length.
    pub unsubscribed: BTreeMap<u16, usize>,
    /// Whether there are flags that this reader does not support.
    pub unknown_flags: bool,
}

fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok().map(|text| text.trim_end_matches('\0'))
}

/// Splits an 8-bit length, a key of that length such as `float NAME`, and its value.
fn keyed(payload: &[u8]) -> Option<(&str, &str, &[u8])> {
    let (length, rest) = payload.split_first()?;
    let (key, value) = rest.split_at_checked(usize::from(*length))?;
    let (kind, name) = text(key)?.split_once(' ')?;
    let is_name = |name: &str| {
        !name.is_empty()
            && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-'))
    };
    is_name(name).then_some((kind, name, value))
}

fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    bytes.get(at..)?.first_chunk().map(|chunk| u64::from_le_bytes(*chunk))
}

impl<'a> Reader<'a> {
    /// Reader of a log that begins with [`MAGIC`].
    pub fn new(log: &'a [u8]) -> Self {
        Self {
            log,
            at: FILE_HEADER.min(log.len()),
            appended: Vec::new(),
            formats: Formats::default(),
            subscriptions: BTreeMap::new(),
            lengths: Vec::new(),
            ahead: None,
            damage: Damage::default(),
            interrupted: 0,
            bad_definitions: 0,
            unsubscribed: BTreeMap::new(),
            unknown_flags: false,
        }
    }

    /// Kind and payload range of a possible message, whatever its content.
    fn header(&self, at: usize) -> Option<(u8, usize, usize)> {
        let &[low, high, kind] = self.log.get(at..at + HEADER)? else { return None };
        let (start, length) = (at + HEADER, usize::from(u16::from_le_bytes([low, high])));
        Some((kind, start, start + length))
    }

    /// The end of a message that is valid by its kind and length, even if the log ends before it.
    fn end(&self, at: usize) -> Option<usize> {
        let (kind, start, end) = self.header(at)?;
        let length = end - start;
        let payload = self.log.get(start..end);
        let is_keyed = || payload.is_none_or(|payload| keyed(payload).is_some());
        let fits = match kind {
            b'D' => {
                let id = self.log.get(start..)?.first_chunk().map(|id| u16::from_le_bytes(*id))?;
                let (most, padding) = (*self.lengths.get(usize::from(id))?)?;
                length >= 2 && (most - padding..=most).contains(&(length - 2))
            }
            b'F' => length > 3 && payload.is_none_or(|payload| payload.contains(&b':')),
            b'I' | b'P' => length > 3 && is_keyed(),
            b'M' | b'Q' => {
                length > 3
                    && payload.is_none_or(|payload| keyed(payload.get(1..).unwrap_or_default()).is_some())
            }
            b'A' => {
                length > 3
                    && payload.is_none_or(|payload| {
                        payload.get(3..).is_some_and(|name| name.iter().all(u8::is_ascii_graphic))
                    })
            }
            // Only the first message may be of this kind. Another one would be a damaged definition that
            // changes how everything is read.
            b'B' => at == FILE_HEADER && length >= 40,
            b'L' => {
                length >= 9
                    && payload.is_none_or(|payload| {
                        payload.first().is_some_and(|level| (b'0'..=b'7').contains(level))
                    })
            }
            b'C' => length >= 11,
            b'S' => payload == Some(&SYNC[..]),
            b'O' | b'R' => length == 2,
            _ => false,
        };
        fits.then_some(end)
    }

    /// Whether a whole message is there, followed by another one, the log's end or appended data.
    fn is_vouched_for(&self, at: usize) -> bool {
        self.end(at).is_some_and(|end| {
            end == self.log.len()
                || (end < self.log.len() && (self.appended.contains(&end) || self.end(end).is_some()))
        })
    }

    /// Whether a message that ends there is followed by another one, the log's end or appended data.
    fn is_followed(&mut self, end: usize) -> bool {
        self.ahead = self.end(end).map(|next_end| (end, next_end));
        end == self.log.len()
            || (end < self.log.len() && (self.ahead.is_some() || self.appended.contains(&end)))
    }

    fn next_vouched_for(&self, from: usize, to: usize) -> Option<usize> {
        (from..to.min(self.log.len())).find(|at| self.is_vouched_for(*at))
    }

    /// Skips a data message whose id has no subscription, if another message follows it. Returns whether it
    /// did.
    fn skip_unsubscribed(&mut self) -> bool {
        let Some((b'D', start, end)) = self.header(self.at) else { return false };
        let Some(id) = self.log.get(start..).and_then(|data| data.first_chunk()) else { return false };
        if end > self.log.len() || (end < self.log.len() && self.end(end).is_none()) {
            return false;
        }
        *self.unsubscribed.entry(u16::from_le_bytes(*id)).or_default() += 1;
        self.at = end;
        true
    }

    fn definition(&mut self, kind: u8, payload: &[u8]) {
        match kind {
            b'F' => {
                let is_good = text(payload).is_some_and(|text| self.formats.define(text));
                self.bad_definitions += usize::from(!is_good);
            }
            b'B' => {
                let incompatible = payload.get(8..16).unwrap_or_default();
                let first = incompatible.first().copied().unwrap_or(0);
                self.unknown_flags =
                    first & !DATA_APPENDED != 0 || incompatible.iter().skip(1).any(|flags| *flags != 0);
                if first & DATA_APPENDED != 0 {
                    let offsets = (0..3).filter_map(|k| u64_at(payload, 16 + 8 * k));
                    let inside = offsets.filter_map(|at| usize::try_from(at).ok());
                    self.appended = inside.filter(|at| (FILE_HEADER..self.log.len()).contains(at)).collect();
                    self.appended.sort_unstable();
                }
            }
            b'A' => {
                let (Some(instance), Some(id), Some(topic)) = (
                    payload.first(),
                    payload.get(1..).and_then(|rest| rest.first_chunk()).map(|id| u16::from_le_bytes(*id)),
                    payload.get(3..).and_then(text),
                ) else {
                    return;
                };
                let len = self.formats.len(topic);
                let found = Subscription { topic: topic.to_owned(), instance: *instance, len };
                self.bad_definitions += usize::from(len.is_none());
                // Two ids for one instance: one of the two definitions is damaged, and it is unknown which.
                let is_taken = self.subscriptions.iter().any(|(other, known)| {
                    *other != id && known.topic == found.topic && known.instance == found.instance
                });
                match self.subscriptions.get(&id) {
                    Some(known) if *known != found => self.bad_definitions += 1,
                    Some(_) => {}
                    None if is_taken => self.bad_definitions += 1,
                    None => {
                        let place = usize::from(id);
                        self.lengths.resize(self.lengths.len().max(place + 1), None);
                        if let Some(slot) = self.lengths.get_mut(place) {
                            *slot = found.len;
                        }
                        self.subscriptions.insert(id, found);
                    }
                }
            }
            _ => {}
        }
    }
}

impl<'a> Iterator for Reader<'a> {
    type Item = Message<'a>;

    fn next(&mut self) -> Option<Message<'a>> {
        while self.at < self.log.len() {
            let at = self.at;
            // A known length never changes, so the end stays valid whatever was defined since.
            let ahead = self.ahead.take().filter(|(place, _)| *place == at);
            let end = ahead.map_or_else(|| self.end(at), |(_, end)| Some(end));
            // A message that was being written when the autopilot failed ends where data were appended.
            let appended = self.appended.iter().copied().find(|start| *start > at);
            if let Some(start) = appended.filter(|start| end.is_some_and(|end| end > *start)) {
                self.interrupted += 1;
                self.at = start;
                continue;
            }
            let is_good = end
                .filter(|end| *end <= self.log.len())
                .is_some_and(|end| self.is_followed(end) || self.next_vouched_for(at + 1, end).is_none());
            let Some((kind, start, end)) = self.header(at).filter(|_| is_good) else {
                if end.is_none() && self.skip_unsubscribed() {
                    continue;
                }
                match self.next_vouched_for(at + 1, self.log.len()) {
                    Some(next) => {
                        if self.appended.contains(&next) {
                            self.interrupted += 1;
                        } else {
                            self.damage.lost(at, next - at);
                        }
                        self.at = next;
                    }
                    None => {
                        if end.is_some() || self.log.len() - at < HEADER {
                            self.damage.cut_at = Some(at);
                        } else {
                            self.damage.lost(at, self.log.len() - at);
                        }
                        self.at = self.log.len();
                    }
                }
                continue;
            };
            self.at = end;
            let Some(payload) = self.log.get(start..end) else { continue };
            match kind {
                b'D' => {
                    let Some((id, data)) = payload.split_first_chunk() else { continue };
                    return Some(Message::Data { id: u16::from_le_bytes(*id), at, data });
                }
                b'P' => {
                    let Some((kind, name, value)) = keyed(payload) else { continue };
                    let Some(value) = super::format::Scalar::of(kind).and_then(|scalar| scalar.read(value))
                    else {
                        continue;
                    };
                    return Some(Message::Parameter { name, value });
                }
                b'I' => {
                    let Some((_, name, value)) = keyed(payload) else { continue };
                    return Some(Message::Info { name, value });
                }
                b'O' => {
                    let Some(ms) = payload.first_chunk() else { continue };
                    return Some(Message::Dropout { ms: u16::from_le_bytes(*ms) });
                }
                kind => self.definition(kind, payload),
            }
        }
        None
    }
}

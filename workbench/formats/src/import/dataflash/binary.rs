//! Messages of a binary log (`.bin`), and damage between them.

use memchr::memmem;

use super::format::{Body, FMT, FMT_LEN, HEADER, Layout, Message};
use crate::import::damage::Damage;

/// First bytes of every message.
const MAGIC: [u8; 2] = [0xa3, 0x95];
/// Largest number of definitions tried for one type; a log has two where one is damaged.
const MOST_DEFINITIONS: usize = 8;
/// Number of messages of a type used to decide between two definitions.
const TRIED: usize = 1_000;

/// A binary log's messages, in its order.
pub struct Messages<'a> {
    log: &'a [u8],
    at: usize,
    /// Index into `layouts`, by type.
    known: [Option<usize>; 256],
    layouts: Vec<Layout>,
    /// Bytes that were left out.
    pub damage: Damage,
    /// Messages of undefined types.
    pub undefined: usize,
    /// Definitions that contradict themselves or another one of the same type.
    pub bad_definitions: usize,
}

/// Whether these bytes contain a complete definition of a message.
pub fn has_definition(bytes: &[u8]) -> bool {
    definitions(bytes).0.next().is_some()
}

/// The definitions in these bytes; and, once they have been read, the number of those that contradict
/// themselves.
fn definitions(log: &[u8]) -> (impl Iterator<Item = Layout> + '_, usize) {
    let places = memmem::find_iter(log, &[MAGIC[0], MAGIC[1], FMT]).collect::<Vec<_>>();
    let body = |at: usize| log.get(at + HEADER..at + FMT_LEN);
    let whole = places.iter().filter_map(|at| body(*at)).count();
    let good = places.iter().filter_map(|at| Layout::from_fmt(body(*at)?)).count();
    (
        places.into_iter().filter_map(move |at| Layout::from_fmt(log.get(at + HEADER..at + FMT_LEN)?)),
        whole - good,
    )
}

impl<'a> Messages<'a> {
    /// The messages of a log.
    pub fn new(log: &'a [u8]) -> Self {
        let (found, mut bad_definitions) = definitions(log);
        let mut of_type: Vec<Vec<Layout>> = vec![Vec::new(); 256];
        for layout in found {
            let Some(all) = of_type.get_mut(usize::from(layout.kind)).filter(|all| !all.contains(&layout))
            else {
                continue;
            };
            if all.len() < MOST_DEFINITIONS {
                all.push(layout);
            } else {
                bad_definitions += 1;
            }
        }
        let mut layouts = Vec::new();
        let mut known = [None; 256];
        for (slot, mut candidates) in known.iter_mut().zip(of_type) {
            bad_definitions += candidates.len().saturating_sub(1);
            let best = if candidates.len() > 1 { fitting(log, &candidates) } else { 0 };
            if best < candidates.len() {
                *slot = Some(layouts.len());
                layouts.push(candidates.swap_remove(best));
            }
        }
        if let (Some(slot @ None), Some(layout)) = (
            known.get_mut(usize::from(FMT)),
            Layout::new(FMT, Some(FMT_LEN), "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        ) {
            *slot = Some(layouts.len());
            layouts.push(layout);
        }
        Self { log, at: 0, known, layouts, damage: Damage::default(), undefined: 0, bad_definitions }
    }

    /// Every kind of message that the log defines.
    pub fn layouts(&self) -> &[Layout] {
        &self.layouts
    }

    /// Whether a message's header is at `at`, of a known type or not.
    fn is_marked(&self, at: usize) -> bool {
        self.log.get(at..at + 2) == Some(&MAGIC[..])
    }

    /// The layout and the end of the message that begins at `at`, if its type is known.
    fn end(&self, at: usize) -> Option<(usize, usize)> {
        let kind = self.log.get(at + 2).filter(|_| self.is_marked(at))?;
        let layout = *self.known.get(usize::from(*kind))?;
        let layout = layout?;
        Some((layout, at + HEADER + self.layouts.get(layout)?.len))
    }

    /// Whether a complete message is at `at`, followed by another one or by the log's end.
    fn is_vouched_for(&self, at: usize) -> bool {
        self.end(at).is_some_and(|(_, end)| end == self.log.len() || self.is_marked(end))
    }

    /// The first message in this stretch that is confirmed by what follows it.
    fn next_vouched_for(&self, from: usize, to: usize) -> Option<usize> {
        let stretch = self.log.get(from..to.min(self.log.len()))?;
        memchr::memchr_iter(MAGIC[0], stretch).map(|offset| from + offset).find(|at| self.is_vouched_for(*at))
    }

    /// Continues at the next message that can be read.
    fn skip(&mut self) {
        let next = self.next_vouched_for(self.at + 1, self.log.len()).unwrap_or(self.log.len());
        self.damage.lost(self.at, next - self.at);
        self.at = next;
    }
}

impl<'a> Iterator for Messages<'a> {
    type Item = Message<'a>;

    fn next(&mut self) -> Option<Message<'a>> {
        while self.at < self.log.len() {
            let at = self.at;
            let Some((layout, end)) = self.end(at) else {
                self.undefined += usize::from(self.is_marked(at));
                self.skip();
                continue;
            };
            if !self.is_vouched_for(at) {
                // Bytes missing in it make the next message come earlier.
                if let Some(next) = self.next_vouched_for(at + 1, end) {
                    self.damage.lost(at, next - at);
                    self.at = next;
                    continue;
                }
                if end > self.log.len() {
                    self.damage.cut_at = Some(at);
                    self.at = self.log.len();
                    return None;
                }
            }
            self.at = end;
            let Some(body) = self.log.get(at + HEADER..end) else { continue };
            return Some(Message { layout, place: at, body: Body::Binary(body) });
        }
        None
    }
}

/// The index of the definition of one type that most of its messages agree with.
fn fitting(log: &[u8], candidates: &[Layout]) -> usize {
    let kind = candidates.first().map_or(0, |layout| layout.kind);
    let fits = |layout: &Layout| {
        memmem::find_iter(log, &[MAGIC[0], MAGIC[1], kind])
            .take(TRIED)
            .filter(|at| {
                let end = at + HEADER + layout.len;
                end == log.len() || log.get(end..end + 2) == Some(&MAGIC[..])
            })
            .count()
    };
    let counts: Vec<usize> = candidates.iter().map(fits).collect();
    // Of equals, the first.
    let most = counts.iter().max().copied().unwrap_or(0);
    counts.iter().position(|count| *count == most).unwrap_or(0)
}

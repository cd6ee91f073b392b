//! The umbilical's discrete: debounced, and whether it can be trusted.

use super::{LaunchConfig, LaunchCounts, LaunchInput, WireCondition, count};
use crate::time::microseconds;

/// Openings, each within the time below of the previous one, that make a wire a loose contact. A plug that is
/// pulled bounces for some 10 ms, of which the tick sees one or two edges.
const RESTLESS: u8 = 5;
/// Time for [`RESTLESS`], microseconds. A contact that has been at rest for longer is no longer loose.
const RESTLESS_US: u64 = 1_000_000;

/// What the wire shows of a launch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reading {
    /// No launch.
    Closed,
    /// A possible launch.
    Open {
        edge_us: u64,
        /// For longer than the debounce.
        is_settled: bool,
    },
    /// Nothing: it is broken, or cannot be read.
    Nothing,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wire {
    /// First reading of this opening.
    edge_us: Option<u64>,
    /// See [`Wire::has_reopened`].
    has_reopened: bool,
    is_settled: bool,
    is_broken: bool,
    /// Start of the present closed readings.
    closed_us: Option<u64>,
    /// Time of the last reading, or of the first attempt.
    read_us: Option<u64>,
    is_unreadable: bool,
    /// The last reading.
    was_open: bool,
    /// Openings that each followed the previous one closely, and the last one's edge.
    openings: u8,
    opened_us: u64,
}

impl Wire {
    pub(super) fn take(&mut self, input: &LaunchInput, config: &LaunchConfig, counts: &mut LaunchCounts) {
        let now_us = input.time_us;
        let read_us = *self.read_us.get_or_insert(now_us);
        let Some(is_open) = input.is_open else {
            count(&mut counts.unreadable);
            if now_us.saturating_sub(read_us) >= microseconds(config.undecided_s) {
                self.is_unreadable = true;
                self.edge_us = None;
                self.is_settled = false;
            }
            return;
        };
        self.read_us = Some(now_us);
        self.is_unreadable = false;
        self.was_open = is_open;
        let debounce_us = microseconds(config.debounce_s);
        if is_open {
            let closed_us = self.closed_us.take();
            if self.is_broken && !self.is_restless() {
                return;
            }
            if self.edge_us.is_none() {
                self.has_reopened =
                    closed_us.is_some_and(|closed_us| now_us.saturating_sub(closed_us) < RESTLESS_US);
            }
            let open_us = now_us.saturating_sub(*self.edge_us.get_or_insert(now_us));
            if !self.is_broken {
                self.is_settled = open_us >= debounce_us;
            } else if open_us >= RESTLESS_US {
                self.call_whole(counts);
            }
            return;
        }
        if let Some(edge_us) = self.edge_us.take().filter(|_| !self.is_broken) {
            count(if self.is_settled { &mut counts.reclosures } else { &mut counts.bounces });
            self.note_opening(edge_us, counts);
        }
        self.is_settled = false;
        let closed_us = *self.closed_us.get_or_insert(now_us);
        let rest_us = if self.is_restless() { RESTLESS_US } else { debounce_us };
        if self.is_broken && now_us.saturating_sub(closed_us) >= rest_us {
            self.call_whole(counts);
        }
    }

    fn call_whole(&mut self, counts: &mut LaunchCounts) {
        self.is_broken = false;
        self.openings = 0;
        count(&mut counts.mended_wires);
    }

    /// A wire that opens and closes repeatedly is a loose contact, and broken: a launch would be lost among
    /// its edges. Once it is at rest, closed or open, it counts like any other wire.
    fn note_opening(&mut self, edge_us: u64, counts: &mut LaunchCounts) {
        let is_next = edge_us.saturating_sub(self.opened_us) < RESTLESS_US;
        self.openings = if is_next { self.openings.saturating_add(1) } else { 1 };
        self.opened_us = edge_us;
        if self.is_restless() {
            self.is_broken = true;
            count(&mut counts.broken_wires);
        }
    }

    /// Whether it is a loose contact that has not come to rest yet.
    pub(super) const fn is_restless(&self) -> bool {
        self.openings >= RESTLESS
    }

    /// Whether it was closed for less than a second before this opening: the two openings are one.
    pub(super) const fn has_reopened(&self) -> bool {
        self.has_reopened
    }

    /// Whether this reading closes it; for the time after launch.
    pub(super) fn closes(&mut self, is_open: Option<bool>) -> bool {
        is_open.is_some_and(|is_open| core::mem::replace(&mut self.was_open, is_open) && !is_open)
    }

    pub(super) fn call_broken(&mut self) {
        *self =
            Self { is_broken: true, edge_us: None, is_settled: false, closed_us: None, openings: 0, ..*self };
    }

    pub(super) const fn condition(&self) -> WireCondition {
        match (self.is_unreadable, self.is_broken, self.edge_us) {
            (true, ..) => WireCondition::Unreadable,
            (_, true, _) => WireCondition::Broken,
            (_, _, Some(_)) => WireCondition::Open,
            (_, _, None) => WireCondition::Closed,
        }
    }

    pub(super) const fn reading(&self) -> Reading {
        match (self.condition(), self.edge_us) {
            (WireCondition::Unreadable | WireCondition::Broken, _) => Reading::Nothing,
            (_, Some(edge_us)) => Reading::Open { edge_us, is_settled: self.is_settled },
            (_, None) => Reading::Closed,
        }
    }
}

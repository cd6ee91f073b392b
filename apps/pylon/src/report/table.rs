//! Traces of a flight as the columns of a chart, at common times.

use crate::compare::{Envelope, Slot};

/// Several traces at their common times.
#[derive(Clone, Debug)]
pub(super) struct Table {
    /// The common times, microseconds.
    times_us: Vec<u64>,
    /// Each trace's slot at each of these times, if it has one.
    series: Vec<Vec<Option<Slot>>>,
}

impl Table {
    /// The table of traces whose slots are in order of time.
    pub(super) fn of(traces: &[&Envelope]) -> Self {
        let mut rest: Vec<&[Slot]> = traces.iter().map(|trace| trace.slots()).collect();
        let mut table = Self { times_us: Vec::new(), series: vec![Vec::new(); traces.len()] };
        while let Some(time_us) = rest.iter().filter_map(|slots| slots.first()).map(|slot| slot.time_us).min()
        {
            table.times_us.push(time_us);
            for (slots, series) in rest.iter_mut().zip(&mut table.series) {
                let here = match *slots {
                    [first, after @ ..] if first.time_us == time_us => {
                        *slots = after;
                        Some(*first)
                    }
                    _ => None,
                };
                series.push(here);
            }
        }
        table
    }

    /// Whether the table is empty.
    pub(super) fn is_empty(&self) -> bool {
        self.times_us.is_empty()
    }

    /// The common times, seconds after `origin_us`.
    pub(super) fn times_s(&self, origin_us: u64) -> Vec<f64> {
        let seconds = |time_us: u64| (time_us as i64 - origin_us as i64) as f64 * 1e-6;
        self.times_us.iter().map(|time_us| rounded(seconds(*time_us))).collect()
    }

    /// Least value of a trace at each time.
    pub(super) fn least(&self, series: usize) -> Vec<Option<f64>> {
        self.column(series, |slot| f64::from(slot.least))
    }

    /// Greatest value of a trace at each time.
    pub(super) fn greatest(&self, series: usize) -> Vec<Option<f64>> {
        self.column(series, |slot| f64::from(slot.greatest))
    }

    /// Mean value of a trace at each time.
    pub(super) fn mean(&self, series: usize) -> Vec<Option<f64>> {
        self.column(series, Slot::mean)
    }

    fn column(&self, series: usize, value: impl Fn(&Slot) -> f64) -> Vec<Option<f64>> {
        let slots = self.series.get(series).into_iter().flatten();
        slots.map(|slot| slot.as_ref().map(|slot| rounded(value(slot)))).collect()
    }
}

/// Rounded to the millimetre or the millisecond: it saves digits, and is finer than a diagram shows.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 1e3).round() * 1e-3 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn traces_keep_their_values_over_common_places() {
        let [mut errors, mut averages] = [Envelope::new(100), Envelope::new(100)];
        for (time_us, error) in [(0, 1.0), (400, 3.0), (500_000, -2.0), (1_000_000, 4.0)] {
            errors.push(time_us, error);
        }
        for (time_us, average) in [(500_000, 0.5), (700_000, 0.25)] {
            averages.push(time_us, average);
        }
        let table = Table::of(&[&errors, &averages]);
        assert_eq!(table.times_s(500_000), [-0.5, 0.0, 0.2, 0.5]);
        assert_eq!(table.least(0), [Some(1.0), Some(-2.0), None, Some(4.0)]);
        assert_eq!(table.greatest(0), [Some(3.0), Some(-2.0), None, Some(4.0)]);
        assert_eq!(table.mean(0)[0], Some(2.0));
        assert_eq!(table.mean(1), [None, Some(0.5), Some(0.25), None]);
        assert!(Table::of(&[&Envelope::new(1)]).is_empty() && !table.is_empty());
    }
}

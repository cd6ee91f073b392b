//! Series of a flight, thinned out to what a screen can show: least, greatest and mean of each slot of time.

/// Slots at most: four times the pixels of a wide diagram, so that a zoom has something to show.
const MOST_SLOTS: u64 = 6_000;

/// Some series over one stretch of flight that share their slots.
#[derive(Clone, Debug)]
pub(super) struct Table {
    start_us: u64,
    end_us: u64,
    /// Time of the first value of each slot, microseconds.
    first_us: Vec<Option<u64>>,
    series: Vec<Vec<Slot>>,
}

/// One series in one slot.
#[derive(Clone, Copy, Debug)]
struct Slot {
    least: f32,
    greatest: f32,
    sum: f64,
    count: u32,
}

const EMPTY: Slot = Slot { least: f32::INFINITY, greatest: f32::NEG_INFINITY, sum: 0.0, count: 0 };

impl Table {
    /// A table of `series` series between two times, each of about `readings` values.
    pub(super) fn new(start_us: u64, end_us: u64, readings: u64, series: usize) -> Self {
        let slots = readings.clamp(1, MOST_SLOTS) as usize;
        Self { start_us, end_us, first_us: vec![None; slots], series: vec![vec![EMPTY; slots]; series] }
    }

    /// Takes a value of a series; what is not finite, or outside of the table's stretch, is not drawn.
    #[inline]
    pub(super) fn push(&mut self, series: usize, time_us: u64, value: f32) {
        if !value.is_finite() || time_us < self.start_us || time_us > self.end_us {
            return;
        }
        let slots = self.first_us.len();
        let span = (self.end_us - self.start_us + 1) as f64;
        let index = ((time_us - self.start_us) as f64 / span * slots as f64) as usize;
        let Some(slot) = self.series.get_mut(series).and_then(|series| series.get_mut(index)) else { return };
        slot.least = slot.least.min(value);
        slot.greatest = slot.greatest.max(value);
        slot.sum += f64::from(value);
        slot.count += 1;
        if let Some(first_us) = self.first_us.get_mut(index) {
            *first_us = Some(first_us.map_or(time_us, |first_us| first_us.min(time_us)));
        }
    }

    /// Whether nothing was taken.
    pub(super) fn is_empty(&self) -> bool {
        self.first_us.iter().all(Option::is_none)
    }

    /// Times of the slots that hold something, seconds after `origin_us`.
    pub(super) fn times_s(&self, origin_us: u64) -> Vec<f64> {
        let seconds = |time_us: u64| (time_us as i64 - origin_us as i64) as f64 * 1e-6;
        self.first_us.iter().flatten().map(|time_us| rounded(seconds(*time_us))).collect()
    }

    /// Least value in each of those slots.
    pub(super) fn least(&self, series: usize) -> Vec<Option<f64>> {
        self.column(series, |slot| f64::from(slot.least))
    }

    /// Greatest value in each of those slots.
    pub(super) fn greatest(&self, series: usize) -> Vec<Option<f64>> {
        self.column(series, |slot| f64::from(slot.greatest))
    }

    /// Mean value in each of those slots.
    pub(super) fn mean(&self, series: usize) -> Vec<Option<f64>> {
        self.column(series, |slot| slot.sum / f64::from(slot.count))
    }

    fn column(&self, series: usize, value: impl Fn(&Slot) -> f64) -> Vec<Option<f64>> {
        let slots = self.series.get(series).into_iter().flatten();
        slots
            .zip(&self.first_us)
            .filter(|(_, first_us)| first_us.is_some())
            .map(|(slot, _)| (slot.count > 0).then(|| rounded(value(slot))))
            .collect()
    }
}

/// To the millimetre and the millisecond: fewer digits to carry, and more than a diagram shows.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 1e3).round() * 1e-3 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_extreme_is_lost_and_slots_are_bounded() {
        let count = 100_000_u64;
        let mut table = Table::new(1_000, 1_000 + (count - 1) * 5_000, count, 2);
        for index in 0..count {
            let value = if index == 77_777 { -9.0 } else { (index % 10) as f32 };
            table.push(0, 1_000 + index * 5_000, value);
        }
        table.push(1, 0, 5.0);
        table.push(1, 2_000, f32::NAN);
        assert_eq!(table.times_s(1_000).len(), MOST_SLOTS as usize);
        assert_eq!(table.times_s(1_000)[0], 0.0);
        let least = table.least(0).into_iter().flatten().fold(f64::INFINITY, f64::min);
        let greatest = table.greatest(0).into_iter().flatten().fold(f64::NEG_INFINITY, f64::max);
        assert_eq!((least, greatest), (-9.0, 9.0));
        // 16 or 17 values a slot of 0 to 9: their mean is near 4.5.
        assert!(table.mean(0).into_iter().flatten().all(|mean| (2.0..7.0).contains(&mean)));
        assert!(table.mean(1).iter().all(Option::is_none));
    }

    #[test]
    fn few_readings_are_kept_as_they_are() {
        let mut table = Table::new(0, 1_000_000, 3, 1);
        for (time_us, value) in [(0, 1.0), (500_000, 2.0), (1_000_000, 3.0)] {
            table.push(0, time_us, value);
        }
        assert_eq!(table.times_s(500_000), [-0.5, 0.0, 0.5]);
        assert_eq!(table.mean(0), [Some(1.0), Some(2.0), Some(3.0)]);
        assert!(Table::new(0, 0, 0, 1).is_empty());
    }
}

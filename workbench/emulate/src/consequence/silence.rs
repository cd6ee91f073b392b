//! For how long a source delivered nothing.

/// Ticks at which a source was silent with the fault and was not without it; `None` for a source that never
/// delivers without the fault.
pub fn ticks(clean: &[bool], with_fault: &[bool]) -> Option<usize> {
    let usual = usual_interval(clean)?;
    let (clean, with_fault) = (silent(clean, usual), silent(with_fault, usual));
    Some(clean.iter().zip(&with_fault).filter(|(clean, with_fault)| !**clean && **with_fault).count())
}

/// The median interval between two samples, ticks.
fn usual_interval(delivers: &[bool]) -> Option<usize> {
    let samples: Vec<usize> = samples(delivers).collect();
    let mut intervals: Vec<usize> =
        samples.iter().zip(samples.iter().skip(1)).map(|(last, next)| next - last).collect();
    let middle = intervals.len() / 2;
    if intervals.is_empty() { None } else { Some(*intervals.select_nth_unstable(middle).1) }
}

fn samples(delivers: &[bool]) -> impl Iterator<Item = usize> {
    delivers.iter().enumerate().filter(|(_, delivers)| **delivers).map(|(tick, _)| tick)
}

/// The ticks of silence: from when a sample was due until it came, if that is later by more than another
/// interval plus two ticks, by which polls and conversions may be out of step.
fn silent(delivers: &[bool], usual: usize) -> Vec<bool> {
    let mut silent = vec![false; delivers.len()];
    let mut due = 0;
    for tick in samples(delivers).chain([delivers.len()]) {
        if tick.saturating_sub(due) > usual + 2
            && let Some(stretch) = silent.get_mut(due..tick)
        {
            stretch.fill(true);
        }
        due = tick + usual;
    }
    silent
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sample every `every` ticks, except in a stretch.
    fn source(len: usize, every: usize, missing: std::ops::Range<usize>) -> Vec<bool> {
        (0..len).map(|tick| tick.is_multiple_of(every) && !missing.contains(&tick)).collect()
    }

    #[test]
    fn silence_is_from_the_first_sample_that_was_due_to_the_next_that_came() {
        let clean = source(1_000, 4, 0..0);
        assert_eq!(ticks(&clean, &clean), Some(0));
        assert_eq!(ticks(&clean, &source(1_000, 4, 100..300)), Some(200));
        assert_eq!(ticks(&source(1_000, 1, 0..0), &source(1_000, 1, 500..521)), Some(21));
        // Silent to the end, and from the beginning.
        assert_eq!(ticks(&clean, &source(1_000, 4, 800..1_000)), Some(200));
        assert_eq!(ticks(&clean, &source(1_000, 4, 0..400)), Some(400));
    }

    #[test]
    fn what_was_silent_anyway_and_what_is_out_of_step_is_no_consequence() {
        let clean = source(1_000, 4, 600..1_000);
        assert_eq!(ticks(&clean, &source(1_000, 4, 500..1_000)), Some(100));
        let late: Vec<bool> = (0..1_000).map(|tick| tick % 4 == if tick < 500 { 0 } else { 2 }).collect();
        assert_eq!(ticks(&source(1_000, 4, 0..0), &late), Some(0));
        assert_eq!(ticks(&[false; 100], &[false; 100]), None);
    }
}

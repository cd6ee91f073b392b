//! Whether probabilities are right: how many of the effects reported with some probability act.

use std::fmt::Write as _;

/// Bounds of the bins of probability.
const BOUNDS: [f64; 7] = [0.01, 0.1, 0.5, 0.9, 0.95, 0.99, 1.0];

/// A reliability diagram of effects with the reported probability of each, and whether it acts; and the Brier
/// score.
#[must_use]
pub fn diagram(said: &[(f64, bool)]) -> String {
    if said.is_empty() {
        return "no probability was reported for a flight whose truth is known\n".to_owned();
    }
    let mut text = format!("{:<24} {:>8} {:>10} {:>8}\n", "reported probability", "effects", "mean", "act");
    for bounds in BOUNDS.windows(2) {
        let is_last = bounds[1] == 1.0;
        let within: Vec<&(f64, bool)> =
            said.iter().filter(|(p, _)| *p >= bounds[0] && (*p < bounds[1] || is_last)).collect();
        let count = within.len();
        let name = format!("{:.0} to {:.0} %", 100.0 * bounds[0], 100.0 * bounds[1]);
        if count == 0 {
            let _ = writeln!(text, "{name:<24} {count:>8} {:>10} {:>8}", "-", "-");
            continue;
        }
        let mean = within.iter().map(|(p, _)| p).sum::<f64>() / count as f64;
        let acts = within.iter().filter(|(_, acts)| *acts).count() as f64 / count as f64;
        let _ = writeln!(text, "{name:<24} {count:>8} {:>8.1} % {:>6.1} %", 100.0 * mean, 100.0 * acts);
    }
    let brier = |of: &dyn Fn(f64) -> f64| {
        let squares = said.iter().map(|(p, acts)| (of(*p) - f64::from(u8::from(*acts))).powi(2));
        squares.sum::<f64>() / said.len() as f64
    };
    let _ = writeln!(
        text,
        "Brier score {:.4}; with 95 % and 5 % rounded to yes and no {:.4}; with no to all {:.4}",
        brier(&|p| p),
        brier(&|p| if p >= 0.95 {
            1.0
        } else if p <= 0.05 {
            0.0
        } else {
            p
        }),
        brier(&|_| 0.0)
    );
    text
}

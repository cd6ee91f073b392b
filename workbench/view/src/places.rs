//! Combines curves with different positions on the axis.

use crate::chart::Values;

/// Curves, each by ascending position, as columns over common positions. A position that occurs twice in one
/// curve is kept twice.
#[must_use]
pub fn common_places<const N: usize>(curves: [&[(f64, f64)]; N]) -> (Vec<f64>, [Values; N]) {
    let mut rest = curves;
    let (mut places, mut columns) = (Vec::new(), [const { Values::new() }; N]);
    while let Some(place) =
        rest.iter().filter_map(|curve| curve.first()).map(|(x, _)| *x).min_by(f64::total_cmp)
    {
        places.push(place);
        for (curve, column) in rest.iter_mut().zip(&mut columns) {
            let value = match *curve {
                [(x, y), after @ ..] if x.total_cmp(&place).is_eq() => {
                    *curve = after;
                    Some(*y)
                }
                _ => None,
            };
            column.push(value);
        }
    }
    (places, columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_curve_keeps_its_points_in_their_order() {
        let (spiked, smooth) = ([(0.0, -2.0), (0.0, 3.0), (2.0, 1.0)], [(-1.0, 5.0), (0.0, 6.0), (1.0, 7.0)]);
        let (places, [first, second, none]) = common_places([&spiked, &smooth, &[]]);
        assert_eq!(places, [-1.0, 0.0, 0.0, 1.0, 2.0]);
        assert_eq!(first, [None, Some(-2.0), Some(3.0), None, Some(1.0)]);
        assert_eq!(second, [Some(5.0), Some(6.0), None, Some(7.0), None]);
        assert_eq!(none, [None; 5]);
    }
}

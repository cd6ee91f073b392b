//! Products of matrices with the same bits on every processor.

use nalgebra::DMatrix;

/// The product of two matrices, each entry summed in the order of the inner index. For all but the smallest
/// matrices, `nalgebra`'s own product uses the widest instructions that the processor has, including fused
/// ones.
#[must_use]
pub fn product(left: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(left.nrows(), right.ncols(), |r, c| {
        left.row(r).iter().zip(right.column(c).iter()).fold(0.0, |sum, (left, right)| sum + left * right)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_product() {
        let left = DMatrix::from_fn(7, 9, |r, c| f64::from((r * 5 + c * 3) as u32 % 11));
        let right = DMatrix::from_fn(9, 8, |r, c| f64::from((r * 2 + c * 7) as u32 % 13));
        assert_eq!(product(&left, &right), &left * &right);
    }
}

//! Percentiles of a list.

/// The percentile of `values`, with linear interpolation (numpy's default); `None` for an empty list. Sorts
/// the list in part.
pub(crate) fn percentile(values: &mut [f64], percent: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let rank = (percent / 100.0).clamp(0.0, 1.0) * last as f64;
    let index = rank.floor() as usize;
    let (_, &mut below, above) = values.select_nth_unstable_by(index, f64::total_cmp);
    let next = above.iter().copied().min_by(f64::total_cmp).unwrap_or(below);
    Some(below + (next - below) * (rank - index as f64))
}

#[cfg(test)]
mod tests {
    use super::percentile;

    #[test]
    fn it_interpolates_as_numpy_does() {
        assert_eq!(percentile(&mut [3.0, 1.0, 2.0, 10.0], 50.0), Some(2.5));
        assert_eq!(percentile(&mut [3.0, 1.0, 2.0, 10.0], 100.0), Some(10.0));
        assert_eq!(percentile(&mut [7.0], 99.0), Some(7.0));
        assert_eq!(percentile(&mut [], 99.0), None);
    }
}

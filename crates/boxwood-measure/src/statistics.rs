//! Numbers that one bad round does not move.

/// The middle value, of an even count the upper one; 0 without values.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or_default()
}

/// The `n`-th root of the product of positive values; NaN without values.
pub fn geometric_mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values
        .into_iter()
        .fold((0.0, 0.0), |(sum, count), x| (sum + x.ln(), count + 1.0));
    (sum / count).exp()
}

/// How far values lie apart, as a part of their median: the distance of the quartiles, scaled such that it is the standard
/// deviation of a normal distribution. 0 for fewer than three values. (The median distance from the median would call it calm
/// when two of five rounds took twice as long.)
pub fn spread(values: &[f64]) -> f64 {
    let middle = median(values);
    if values.len() < 3 || middle == 0.0 {
        return 0.0;
    }
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    // Rather too far out than too near.
    let quarter = sorted.len() / 4;
    (sorted[sorted.len() - 1 - quarter] - sorted[quarter]) / 1.349 / middle
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outlier_moves_neither_the_median_nor_the_spread() {
        assert_eq!(median(&[5.0, 900.0, 4.0, 6.0, 5.0]), 5.0);
        assert_eq!(median(&[]), 0.0);
        let calm = spread(&[100.0, 101.0, 99.0, 100.0, 102.0]);
        let disturbed = spread(&[100.0, 101.0, 99.0, 100.0, 900.0]);
        assert!((calm - 0.01 / 1.349).abs() < 1e-12, "{calm}");
        assert!(disturbed < 0.02, "{disturbed}");
        let two_of_five = spread(&[100.0, 101.0, 100.0, 200.0, 200.0]);
        assert!(two_of_five > 0.5, "{two_of_five}");
        assert_eq!(spread(&[3.0]), 0.0);
    }

    #[test]
    fn the_geometric_mean_of_a_ratio_and_its_inverse_is_one() {
        assert!((geometric_mean([4.0, 0.25]) - 1.0).abs() < 1e-12);
        assert!((geometric_mean([2.0, 8.0, 4.0]) - 4.0).abs() < 1e-12);
        assert!(geometric_mean([]).is_nan());
    }
}

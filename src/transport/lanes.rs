//! Folds in eight lanes, whose results are folded in their turn: one lane would wait for each step of the one before.

const LANES: usize = 8;

/// Sum of the values, each lane by itself.
pub(super) fn sum(values: &[f64]) -> f64 {
    fold(values, 0.0, |sum, value| sum + value)
}

/// The largest of the values and 0.
pub(super) fn largest(values: &[f64]) -> f64 {
    fold(values, 0.0, |most, value| if value > most { value } else { most })
}

/// Least `a - b`, infinite without any.
pub(super) fn least_difference(a: &[f64], b: &[f64]) -> f64 {
    let less = |least: f64, x: f64| if x < least { x } else { least };
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut lanes = [f64::INFINITY; LANES];
    for (a, b) in a.iter().zip(b) {
        for (k, lane) in lanes.iter_mut().enumerate() {
            *lane = less(*lane, a[k] - b[k]);
        }
    }
    let rest = a_rest.iter().zip(b_rest).map(|(a, b)| a - b);
    lanes.into_iter().chain(rest).fold(f64::INFINITY, less)
}

fn fold(values: &[f64], start: f64, step: impl Fn(f64, f64) -> f64) -> f64 {
    let (blocks, rest) = values.as_chunks::<LANES>();
    let mut lanes = [start; LANES];
    for block in blocks {
        lanes.iter_mut().zip(block).for_each(|(lane, value)| *lane = step(*lane, *value));
    }
    lanes.iter().chain(rest).fold(start, |a, b| step(a, *b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_length_is_folded_whole() {
        for n in [0, 1, 7, 8, 9, 40, 41] {
            let values: Vec<f64> = (0..n).map(|k| f64::from((5 * k + 3) % 17)).collect();
            let falling: Vec<f64> = (0..n).map(|k| f64::from(n - k)).collect();
            assert_eq!(sum(&values), values.iter().sum::<f64>());
            assert_eq!(largest(&values), values.iter().copied().fold(0.0, f64::max));
            let differences = values.iter().zip(&falling).map(|(a, b)| a - b);
            assert_eq!(least_difference(&values, &falling), differences.fold(f64::INFINITY, f64::min));
        }
    }
}

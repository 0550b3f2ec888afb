//! How long pictures took.

use std::collections::VecDeque;
use std::time::Duration;

/// The last pictures' times.
#[derive(Debug, Clone, Default)]
pub struct FrameTimes {
    /// Milliseconds, oldest first.
    times: VecDeque<f64>,
}

impl FrameTimes {
    /// How many are kept.
    pub const KEPT: usize = 120;

    /// A picture was drawn.
    pub fn push(&mut self, time: Duration) {
        if self.times.len() == Self::KEPT {
            self.times.pop_front();
        }
        self.times.push_back(1e3 * time.as_secs_f64());
    }

    /// Milliseconds, oldest first.
    pub fn all(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.times.iter().copied()
    }

    /// The last one, milliseconds.
    pub fn last(&self) -> Option<f64> {
        self.times.back().copied()
    }

    /// Median and largest of those kept, milliseconds.
    pub fn median_and_largest(&self) -> Option<[f64; 2]> {
        let mut sorted: Vec<f64> = self.all().collect();
        sorted.sort_by(f64::total_cmp);
        Some([*sorted.get(sorted.len() / 2)?, *sorted.last()?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_ones_are_kept() {
        let mut times = FrameTimes::default();
        assert!(times.median_and_largest().is_none());
        for k in 0..FrameTimes::KEPT as u64 + 10 {
            times.push(Duration::from_millis(k));
        }
        assert_eq!(times.all().len(), FrameTimes::KEPT);
        assert_eq!(times.last(), Some(129.0));
        assert_eq!(times.median_and_largest(), Some([70.0, 129.0]));
    }
}

//! Sums whose error does not grow with the number of terms.

/// A sum of numbers and products as if in twice the working precision (Ogita, Rump & Oishi 2005, Sum2 and Dot2).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    pub fn add(&mut self, term: f64) {
        let sum = self.high + term;
        let kept = sum - self.high;
        // What rounding took from the sum, exactly (Knuth's two-sum).
        self.low += (self.high - (sum - kept)) + (term - kept);
        self.high = sum;
    }

    pub fn add_product(&mut self, a: f64, b: f64) {
        let product = a * b;
        self.add(product);
        self.low += a.mul_add(b, -product);
    }

    pub fn value(self) -> f64 {
        self.high + self.low
    }
}

impl Extend<f64> for Sum {
    fn extend<T: IntoIterator<Item = f64>>(&mut self, terms: T) {
        terms.into_iter().for_each(|term| self.add(term));
    }
}

impl FromIterator<f64> for Sum {
    fn from_iter<T: IntoIterator<Item = f64>>(terms: T) -> Self {
        let mut sum = Self::default();
        sum.extend(terms);
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cancellation_loses_nothing() {
        assert_eq!([1e16, 1.0, -1e16].into_iter().collect::<Sum>().value(), 1.0);
        let mut sum = Sum::default();
        sum.add_product(1.0 + f64::EPSILON, 1.0 - f64::EPSILON);
        sum.add(-1.0);
        assert_eq!(sum.value(), -f64::EPSILON * f64::EPSILON);
    }
}

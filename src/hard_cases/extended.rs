//! Numbers of 256 bits, 77 digits, with which f64 and f32 are compared.

use dashu_float::FBig;
use dashu_float::round::mode::HalfEven;

/// A number of 256 bits, its exponent as good as unbounded.
pub type Big = FBig<HalfEven, 2>;

/// Bits of a mantissa.
const BITS: usize = 256;

/// The number itself; it is finite.
pub fn big(x: impl Into<f64>) -> Big {
    // Only a NaN has no value.
    Big::try_from(x.into()).unwrap_or(Big::ZERO).with_precision(BITS).value()
}

/// pi to 77 digits.
pub fn pi() -> Big {
    Big::pi(BITS)
}

/// The square.
pub fn squared(x: &Big) -> Big {
    x * x
}

/// `|value / truth - 1|`, truth not 0; NaN or infinite if the value is.
pub fn relative(value: impl Into<f64>, truth: &Big) -> f64 {
    over(value.into(), truth, truth)
}

/// `|value - truth|`; NaN or infinite if the value is.
pub fn absolute(value: impl Into<f64>, truth: &Big) -> f64 {
    over(value.into(), truth, &big(1.0))
}

/// `|value - truth|` over a scale other than 0; NaN or infinite if the value is.
pub fn over(value: f64, truth: &Big, scale: &Big) -> f64 {
    if !value.is_finite() {
        return value.abs();
    }
    ((big(value) - truth) / scale).to_f64().value().abs()
}

//! Reflection and refraction at a smooth dielectric boundary.

use num_traits::Float;

/// Unpolarized Fresnel reflectance of a dielectric, exact.
///
/// `cos_i`: cosine of the incidence angle, in [0, 1]. `eta`: index beyond the boundary over index before it, > 0; below 1
/// there is total reflection. `r_x(theta)` of Ershov 2001 with x = `eta`.
pub fn dielectric<F: Float>(cos_i: F, eta: F) -> F {
    let one = F::one();
    // No boundary: nothing is reflected, also at exactly grazing, where the quotients below are 0/0.
    if eta == one {
        return F::zero();
    }
    let cos_i = cos_i.min(one);
    let squared = refracted_squared(cos_i, eta);
    if squared <= F::zero() {
        return one;
    }
    let cos_t = squared.sqrt();
    let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    (s * s + p * p) / (one + one)
}

/// Unpolarized Fresnel reflectance of a complex index `n + i k` over air, exact, real arithmetic throughout (Born & Wolf, 14.2).
///
/// `cos_i` in [0, 1], `n` above 0, `k` 0 or more. Meant for what absorbs or is much denser than air: with `k` 0 and `n` near 1
/// use [`dielectric`], which loses no digits there.
pub fn conductor<F: Float>(cos_i: F, n: F, k: F) -> F {
    let two = F::one() + F::one();
    let (c2, s2) = (cos_i * cos_i, F::one() - cos_i * cos_i);
    let real = (n - k) * (n + k) - s2;
    // |n^2 - sin^2|, and the real part of its root.
    let size = real.hypot(two * n * k);
    let root = ((size + real) / two).max(F::zero()).sqrt();
    let twice = two * root * cos_i;
    let s = (size + c2 - twice) / (size + c2 + twice);
    let (a, b) = (c2 * size + s2 * s2, twice * s2);
    let p = s * (a - b) / (a + b);
    (s + p) / two
}

/// `1 - dielectric(cos_i, eta)` to the last digits at grazing, too, where the difference has lost them; 0 in total reflection.
pub fn transmitted<F: Float>(cos_i: F, eta: F) -> F {
    let one = F::one();
    if eta == one {
        return one;
    }
    let cos_i = cos_i.min(one);
    let squared = refracted_squared(cos_i, eta);
    if squared <= F::zero() {
        return F::zero();
    }
    let cos_t = squared.sqrt();
    // 1 - s^2 and 1 - p^2, each a quotient of products.
    let (s, p) = (cos_i + eta * cos_t, eta * cos_i + cos_t);
    (one + one) * eta * cos_i * cos_t * (one / (s * s) + one / (p * p))
}

/// Cosine of the refracted angle, from the cosine outside; `eta` as in [`dielectric`], at least 1, where it bends nothing.
pub fn refracted_cosine<F: Float>(cos_i: F, eta: F) -> F {
    if eta == F::one() { cos_i } else { refracted_squared(cos_i.min(F::one()), eta).sqrt() }
}

/// Squared cosine of the refracted angle; negative where reflection is total. `1 - sin^2/eta^2` without the difference of
/// two numbers near 1, which near grazing leaves nothing of an index near 1.
fn refracted_squared<F: Float>(cos_i: F, eta: F) -> F {
    ((eta - F::one()) * (eta + F::one()) + cos_i * cos_i) / (eta * eta)
}

/// Schlick's approximation, Golla & Klein 2018, eq. 3. `f0` in [0, 1], `cos_d` = h . wo.
pub fn schlick<F: Float>(f0: F, cos_d: F) -> F {
    let m = (F::one() - cos_d).max(F::zero());
    let m2 = m * m;
    f0 + (F::one() - f0) * (m2 * m2 * m)
}

/// Reflectance at normal incidence of an index `eta` >= 1: eq. 4.
pub fn normal_reflectance<F: Float>(eta: F) -> F {
    let r = (eta - F::one()) / (eta + F::one());
    r * r
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against complex arithmetic, and against the dielectric without absorption.
    #[test]
    fn a_conductor_reflects_by_its_complex_index() {
        use nalgebra::Complex;
        for (n, k) in [(2.6, 0.0), (2.6, 0.02), (0.2, 3.5), (1.4, 7.6), (4.0, 5.0)] {
            let index = Complex::new(n, k);
            for cos in [0.0f64, 1e-6, 0.2, 0.7, 1.0] {
                let bent = (index * index - (1.0 - cos * cos)).sqrt();
                let s = (cos - bent) / (cos + bent);
                let p = (index * index * cos - bent) / (index * index * cos + bent);
                let expected = 0.5 * (s.norm_sqr() + p.norm_sqr());
                let found = conductor(cos, n, k);
                assert!((found - expected).abs() < 1e-13, "{n} {k} {cos}: {found} {expected}");
            }
        }
        assert!((conductor(0.5, 2.6, 0.0) - dielectric(0.5, 2.6f64)).abs() < 1e-14);
    }

    #[test]
    fn limits_and_reciprocity() {
        assert!((dielectric(1.0, 1.5) - 0.04f64).abs() < 1e-16);
        assert_eq!(dielectric(0.0, 1.5), 1.0);
        assert_eq!(dielectric(0.5, 1.0), 0.0);
        assert_eq!(dielectric(0.3, 1.0 / 1.5), 1.0);
        for k in 1..=20 {
            let cos_i = f64::from(k) / 20.0;
            let inside = refracted_cosine(cos_i, 1.5);
            // Helmholtz reciprocity; a handful of roundings.
            assert!((dielectric(cos_i, 1.5) - dielectric(inside, 1.0 / 1.5)).abs() < 1e-14);
        }
    }

    #[test]
    fn grazing_light_keeps_its_digits() {
        for cos_i in [1e-9, 1e-200, 0.0f64] {
            assert_eq!((dielectric(cos_i, 1.0), refracted_cosine(cos_i, 1.0)), (0.0, cos_i));
        }
        assert_eq!((dielectric(1e-30f32, 1.0), refracted_cosine(1e-30f32, 1.0)), (0.0, 1e-30));
        // cos^2 beyond the boundary is 1 - 1/eta^2 = 5/9 to 1e-18; 1 - F starts with 2 (eta + 1/eta) cos_i / cos_t.
        assert!((refracted_cosine(1e-9, 1.5) - (5.0f64 / 9.0).sqrt()).abs() < 1e-15);
        let passed = 1.0 - dielectric(1e-9, 1.5);
        let slope = 2.0 * (1.5 + 1.0 / 1.5) / (5.0f64 / 9.0).sqrt();
        // A difference of numbers near 1, over 1e-9: 2e-16 / 6e-9.
        assert!((passed / (slope * 1e-9) - 1.0).abs() < 1e-7, "{passed:e}");
        assert!((transmitted(1e-9, 1.5) / (slope * 1e-9) - 1.0).abs() < 1e-8);
        for cos_i in [0.1, 0.5, 1.0] {
            assert!((transmitted(cos_i, 1.5) - (1.0 - dielectric(cos_i, 1.5f64))).abs() < 1e-15);
        }
        // An index near 1 at a cosine to match: cos_t^2 = (2 d + c^2) / eta^2 to the last digits; d = 2^-40 is exact in eta.
        let d = (-40f64).exp2();
        let exact = ((2.0 * d + d * d + 1e-12) / ((1.0 + d) * (1.0 + d))).sqrt();
        assert!((refracted_cosine(1e-6, 1.0 + d) / exact - 1.0).abs() < 1e-15);
    }
}

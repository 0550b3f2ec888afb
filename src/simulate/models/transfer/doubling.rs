//! Doubling of a homogeneous film from a thin layer (Ershov 2001, eq. 6).
//!
//! A homogeneous film is the same from both sides, so light that is even or odd about its middle plane stays so, and the
//! middle of two equal layers acts as a mirror of reflectance +1 or -1:
//!
//! `S+ = T (1 - R)^-1 T`, `S- = T (1 + R)^-1 T`, `R' = R + (S+ - S-)/2`, `T' = (S+ + S-)/2`,
//!
//! which is eq. 6, with two symmetric positive definite systems in place of one general one.

use crate::error::{Error, Result};
use nalgebra::DMatrix;

/// Reflection and transmission of a film, symmetric matrices; the transmission has the unscattered light on its diagonal.
#[derive(Debug, Clone, PartialEq)]
pub struct Slab {
    /// R.
    pub reflection: DMatrix<f64>,
    /// T.
    pub transmission: DMatrix<f64>,
}

impl Slab {
    /// Two of these.
    ///
    /// # Errors
    /// The layer reflects more than all light: rounding of a film of extreme thickness without absorption.
    pub fn doubled(&self) -> Result<Self> {
        let even = self.between_mirrors(1.0)?;
        let odd = self.between_mirrors(-1.0)?;
        Ok(Self { reflection: &self.reflection + (&even - &odd) * 0.5, transmission: (even + odd) * 0.5 })
    }

    /// `T (1 - sign R)^-1 T`, by elimination without pivots, which a positive definite matrix does not need. With
    /// `1 - sign R = L D L^T` it is `Z D^-1 Z^T`, `Z = T L^-T`.
    fn between_mirrors(&self, sign: f64) -> Result<DMatrix<f64>> {
        let n = self.reflection.nrows();
        let mut a = &self.reflection * -sign;
        let mut z = self.transmission.clone();
        for k in 0..n {
            a[(k, k)] += 1.0;
        }
        let mut scaled = DMatrix::zeros(n, n);
        let (a_all, z_all) = (a.as_mut_slice(), z.as_mut_slice());
        for k in 0..n {
            let pivot = a_all[k * n + k];
            if pivot.is_nan() || pivot <= 0.0 {
                let legal = "a layer that reflects less than all light";
                return Err(Error::not_converged("doubling", "pivot", pivot, legal));
            }
            let (a_head, a_tail) = a_all.split_at_mut((k + 1) * n);
            let (z_head, z_tail) = z_all.split_at_mut((k + 1) * n);
            let (a_k, z_k) = (&a_head[k * n..], &z_head[k * n..]);
            for (i, (a_i, z_i)) in a_tail.chunks_exact_mut(n).zip(z_tail.chunks_exact_mut(n)).enumerate() {
                let factor = -a_k[k + 1 + i] / pivot;
                let from = k + 1 + i;
                a_i[from..].iter_mut().zip(&a_k[from..]).for_each(|(x, y)| *x += factor * y);
                z_i.iter_mut().zip(z_k).for_each(|(x, y)| *x += factor * y);
            }
            for (row, value) in z_k.iter().enumerate() {
                scaled[(k, row)] = value / pivot;
            }
        }
        Ok(z * scaled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubling_is_adding_two_equal_layers() {
        let n = 5;
        let symmetric =
            |scale: f64, shift: usize| DMatrix::from_fn(n, n, |i, j| scale / (1.0 + (i + j + shift) as f64));
        let slab = Slab {
            reflection: symmetric(0.1, 0),
            transmission: symmetric(0.07, 1) + DMatrix::identity(n, n) * 0.5,
        };
        let (r, t) = (&slab.reflection, &slab.transmission);
        let rounds = (DMatrix::identity(n, n) - r * r).try_inverse().unwrap();
        let double = slab.doubled().unwrap();
        // Eq. 6 as it stands; rounding.
        assert!((double.reflection - (r + t * r * &rounds * t)).amax() < 1e-15);
        assert!((double.transmission - t * rounds * t).amax() < 1e-15);
    }
}

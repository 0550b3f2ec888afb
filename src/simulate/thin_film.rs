//! Coherent reflection and transmission of a stack of thin layers: characteristic 2 x 2 matrices.
//!
//! Abeles' method (Macleod, Thin-Film Optical Filters, chapter 2), time convention exp(-i omega t), indices n + i k with
//! k >= 0 absorbing. Per layer, phase `delta = 2 pi N d cos(theta) / lambda` and admittance `q = N cos(theta)` (s) or
//! `N / cos(theta)` (p) with the complex cosine of the layer: total reflection needs no case of its own, because the
//! matrices are even in that cosine.

use nalgebra::Complex;
use std::f64::consts::PI;

/// One layer at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmLayer {
    /// Complex index n + i k.
    pub index: Complex<f64>,
    /// Thickness, nanometres, >= 0.
    pub thickness_nm: f64,
}

/// Power reflectance and transmittance, each in [0, 1].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StackPower {
    /// Reflectance, polarization s and p.
    pub reflectance: [f64; 2],
    /// Transmittance, polarization s and p.
    pub transmittance: [f64; 2],
}

impl StackPower {
    /// Reflectance of unpolarized light: r_p of Ershov 2001, whose p stands for platelet.
    pub fn unpolarized_reflectance(&self) -> f64 {
        0.5 * (self.reflectance[0] + self.reflectance[1])
    }

    /// Transmittance of unpolarized light: t_p of Ershov 2001.
    pub fn unpolarized_transmittance(&self) -> f64 {
        0.5 * (self.transmittance[0] + self.transmittance[1])
    }
}

/// A stack met from a medium of real index `ambient` at angle `acos(cos_alpha)` in that medium, `cos_alpha` in [0, 1];
/// layers in the order light meets them; `exit` is the medium behind.
pub fn stack_power(
    ambient: f64,
    layers: &[FilmLayer],
    exit: Complex<f64>,
    cos_alpha: f64,
    wavelength_nm: f64,
) -> StackPower {
    // At exactly 90 degrees the p admittance is infinite; the limit is total reflection, reached to rounding here.
    let cos_alpha = cos_alpha.clamp(1e-14, 1.0);
    let incidence = (ambient, cos_alpha);
    let both = [false, true].map(|p| {
        let q0 = if p { ambient / cos_alpha } else { ambient * cos_alpha };
        let (mut b, mut c) = (Complex::new(1.0, 0.0), admittance(exit, incidence, p));
        let exit_admittance = c.re;
        let mut log_scale = 0.0;
        for layer in layers.iter().rev() {
            let cosine = complex_cosine(layer.index, incidence);
            let q = if p { layer.index / cosine } else { layer.index * cosine };
            let delta = layer.index * cosine * (2.0 * PI * layer.thickness_nm / wavelength_nm);
            // cos and sin of delta without their growth exp(Im delta), which a thick metal would overflow.
            let forward = Complex::new(-2.0 * delta.im, 2.0 * delta.re).exp();
            let turn = Complex::new(0.0, -delta.re).exp();
            let cos = turn * (forward + 1.0) * 0.5;
            let i_sin = turn * (forward - 1.0) * 0.5;
            log_scale += delta.im;
            (b, c) = (cos * b - i_sin / q * c, cos * c - i_sin * q * b);
        }
        let denominator = b * q0 + c;
        let reflected = (b * q0 - c) / denominator;
        let transmitted = (2.0 * q0 / denominator).norm_sqr() * (-2.0 * log_scale).exp();
        (reflected.norm_sqr(), exit_admittance / q0 * transmitted)
    });
    StackPower { reflectance: both.map(|x| x.0), transmittance: both.map(|x| x.1) }
}

fn admittance(index: Complex<f64>, incidence: (f64, f64), p: bool) -> Complex<f64> {
    let cosine = complex_cosine(index, incidence);
    if p { index / cosine } else { index * cosine }
}

/// Cosine of the angle in a medium, from index and cosine of the first one; the root that decays. `1 - (n0 sin / N)^2`
/// without the difference of numbers near 1, which at grazing leaves nothing of a medium like the first.
fn complex_cosine(index: Complex<f64>, (ambient, cos_alpha): (f64, f64)) -> Complex<f64> {
    let square = ((index - ambient) * (index + ambient) + (ambient * cos_alpha).powi(2)) / (index * index);
    // Exactly at the critical angle sin(delta)/cosine is 0/0; this far from it the limit is met to rounding.
    let square = if square.norm_sqr() < 1e-60 { Complex::new(1e-30, 0.0) } else { square };
    let root = square.sqrt();
    if (index * root).im < 0.0 { -root } else { root }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(n: f64, k: f64, thickness_nm: f64) -> FilmLayer {
        FilmLayer { index: Complex::new(n, k), thickness_nm }
    }

    #[test]
    fn no_layer_is_fresnel() {
        for k in 0..=50 {
            let cos = f64::from(k) / 50.0;
            for (from, to) in [(1.0, 1.5), (1.5, 1.0)] {
                let ours =
                    stack_power(from, &[], Complex::new(to, 0.0), cos, 550.0).unpolarized_reflectance();
                let fresnel = crate::brdf::fresnel::dielectric(cos, to / from);
                // The slope at grazing times the 1e-14 by which cos 0 is moved, and rounding.
                assert!((ours - fresnel).abs() < 1e-13, "{cos} {from} {to}: {ours} {fresnel}");
            }
        }
    }

    #[test]
    fn energy_closes_without_absorption_even_beyond_the_critical_angle() {
        let stack = [layer(2.5, 0.0, 60.0), layer(1.3, 0.0, 80.0), layer(2.5, 0.0, 60.0)];
        for k in 0..=200 {
            let cos = f64::from(k) / 200.0;
            let power = stack_power(1.5, &stack, Complex::new(1.5, 0.0), cos, 470.0);
            for p in 0..2 {
                let total = power.reflectance[p] + power.transmittance[p];
                // Rounding of three matrices.
                assert!((total - 1.0).abs() < 1e-12, "{cos}: {total}");
            }
        }
        // The critical angle of the inner layer to the bit.
        let cos = (1.0 - (1.3f64 / 1.5).powi(2)).sqrt();
        let power = stack_power(1.5, &stack, Complex::new(1.5, 0.0), cos, 470.0);
        assert!((power.unpolarized_reflectance() + power.unpolarized_transmittance() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_quarter_wave_layer_of_the_mean_index_reflects_nothing() {
        let index = 1.5f64.sqrt();
        let power =
            stack_power(1.0, &[layer(index, 0.0, 550.0 / index / 4.0)], Complex::new(1.5, 0.0), 1.0, 550.0);
        assert!(power.unpolarized_reflectance() < 1e-30, "{power:?}");
    }

    #[test]
    fn a_thick_metal_is_its_surface_and_no_thickness_is_nothing() {
        let metal = layer(1.0, 6.0, 1e6);
        let exit = Complex::new(1.5, 0.0);
        for cos in [1.0, 0.6, 0.01] {
            let thick = stack_power(1.5, &[metal], exit, cos, 550.0);
            let surface = stack_power(1.5, &[], metal.index, cos, 550.0);
            assert!((thick.unpolarized_reflectance() - surface.unpolarized_reflectance()).abs() < 1e-14);
            assert_eq!(thick.unpolarized_transmittance(), 0.0);
            let none = stack_power(1.5, &[layer(2.5, 0.1, 0.0)], exit, cos, 550.0);
            // The square of rounding in an admittance of 150.
            assert!(none.unpolarized_reflectance() < 1e-22);
        }
    }
}

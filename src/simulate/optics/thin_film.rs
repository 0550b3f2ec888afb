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

/// How light meets a stack: from a medium of real index, at an angle in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Incidence {
    ambient: f64,
    cos_alpha: f64,
    wavelength_nm: f64,
}

impl Incidence {
    /// From a medium of real index `ambient` at the angle `acos(cos_alpha)` in it, `cos_alpha` in [0, 1].
    pub fn new(ambient: f64, cos_alpha: f64, wavelength_nm: f64) -> Self {
        // At exactly 90 degrees the p admittance is infinite; the limit is total reflection, reached to rounding here.
        Self { ambient, cos_alpha: cos_alpha.clamp(1e-14, 1.0), wavelength_nm }
    }

    /// Admittances s and p of the medium itself.
    fn admittances(&self) -> [f64; 2] {
        [self.ambient * self.cos_alpha, self.ambient / self.cos_alpha]
    }

    /// Cosine of the angle in a medium; the root that decays. `1 - (n0 sin / N)^2` without the difference of numbers near 1,
    /// which at grazing leaves nothing of a medium like the first.
    fn cosine(&self, index: Complex<f64>) -> Complex<f64> {
        let own = (self.ambient * self.cos_alpha).powi(2);
        let square = ((index - self.ambient) * (index + self.ambient) + own) / (index * index);
        // Exactly at the critical angle sin(delta)/cosine is 0/0; this far from it the limit is met to rounding.
        let square = if square.norm_sqr() < 1e-60 { Complex::new(1e-30, 0.0) } else { square };
        let root = root(square);
        if (index * root).im < 0.0 { -root } else { root }
    }

    /// The waves s and p in a layer of this index.
    pub fn layer(&self, index: Complex<f64>) -> LayerWave {
        let cosine = self.cosine(index);
        let per_nm = index * cosine * (2.0 * PI / self.wavelength_nm);
        LayerWave { per_nm, admittances: [index * cosine, index / cosine] }
    }
}

/// The waves s and p in a layer of some thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerWave {
    /// Phase over a nanometre of thickness.
    per_nm: Complex<f64>,
    admittances: [Complex<f64>; 2],
}

/// `cos(delta)` and `i sin(delta)` times `exp(-Im delta)`, without which they overflow in a thick metal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    cos: Complex<f64>,
    i_sin: Complex<f64>,
    /// The square of that factor.
    decay: f64,
}

impl LayerWave {
    /// What a thickness in nanometres does to the phase.
    pub fn turn(&self, thickness_nm: f64) -> Turn {
        let delta = self.per_nm * thickness_nm;
        let (sin, cos) = delta.re.sin_cos();
        let decay = if delta.im == 0.0 { 1.0 } else { (-2.0 * delta.im).exp() };
        let (forward, backward) = (Complex::new(cos, sin) * decay, Complex::new(cos, -sin));
        Turn { cos: (forward + backward) * 0.5, i_sin: (forward - backward) * 0.5, decay }
    }

    /// What multiplies `i sin(delta)` in the characteristic matrices; the unit matrix multiplies `cos(delta)`.
    pub fn generators(&self) -> [Characteristic; 2] {
        self.admittances.map(|q| {
            let zero = Complex::new(0.0, 0.0);
            Characteristic { m: [zero, -q.inv(), -q, zero], decay: 1.0 }
        })
    }

    /// Characteristic matrices s and p.
    pub fn matrices(&self, thickness_nm: f64) -> [Characteristic; 2] {
        let Turn { cos, i_sin, decay } = self.turn(thickness_nm);
        self.generators().map(|g| Characteristic { m: [cos, i_sin * g.m[1], i_sin * g.m[2], cos], decay })
    }
}

/// Square root, real part >= 0, without the angle that [`Complex::sqrt`] goes by.
fn root(z: Complex<f64>) -> Complex<f64> {
    let larger = (0.5 * (z.re.abs() + z.norm_sqr().sqrt())).sqrt();
    let smaller = 0.5 * z.im / larger;
    if z.re >= 0.0 {
        Complex::new(larger, smaller)
    } else {
        Complex::new(smaller.abs(), larger.copysign(z.im))
    }
}

/// Characteristic matrix of consecutive layers, row by row: takes the fields behind them to those before. It is multiplied by
/// the root of `decay`, so that nothing overflows in a thick metal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Characteristic {
    m: [Complex<f64>; 4],
    decay: f64,
}

impl Characteristic {
    /// Of no layer.
    pub const NONE: Self = {
        let (one, zero) = (Complex::new(1.0, 0.0), Complex::new(0.0, 0.0));
        Self { m: [one, zero, zero, one], decay: 1.0 }
    };

    /// With more layers behind.
    #[must_use]
    pub fn then(&self, behind: &Self) -> Self {
        let (a, b) = (&self.m, &behind.m);
        Self {
            m: [
                a[0] * b[0] + a[1] * b[2],
                a[0] * b[1] + a[1] * b[3],
                a[2] * b[0] + a[3] * b[2],
                a[2] * b[1] + a[3] * b[3],
            ],
            decay: self.decay * behind.decay,
        }
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
    let incidence = Incidence::new(ambient, cos_alpha, wavelength_nm);
    let mut total = [Characteristic::NONE; 2];
    for layer in layers {
        total = then(&total, &incidence.layer(layer.index).matrices(layer.thickness_nm));
    }
    let cosine = incidence.cosine(exit);
    let behind = [exit * cosine, exit / cosine];
    let both = [0, 1].map(|p| {
        let (q0, m) = (incidence.admittances()[p], &total[p].m);
        let (b, c) = (m[0] + m[1] * behind[p], m[2] + m[3] * behind[p]);
        let denominator = b * q0 + c;
        let reflected = (b * q0 - c) / denominator;
        let transmitted = (2.0 * q0 / denominator).norm_sqr() * total[p].decay;
        (reflected.norm_sqr(), behind[p].re / q0 * transmitted)
    });
    StackPower { reflectance: both.map(|x| x.0), transmittance: both.map(|x| x.1) }
}

/// Both polarizations of a stack with more layers behind.
pub fn then(stack: &[Characteristic; 2], behind: &[Characteristic; 2]) -> [Characteristic; 2] {
    [stack[0].then(&behind[0]), stack[1].then(&behind[1])]
}

/// Amplitudes of a stack with the same medium on both sides, one polarization; linear in its characteristic matrix.
///
/// Light from behind meets the same layers in reverse, whose matrix is the first with its diagonal exchanged (each layer's
/// is symmetric about the other diagonal). With `a = q0 m12 - m21/q0`, `d = m11 - m22` and
/// `D = m11 + m22 + q0 m12 + m21/q0` the amplitudes of reflection are `(a +- d)/D`, that of transmission is `2/D`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Embedded {
    a: Complex<f64>,
    d: Complex<f64>,
    denominator: Complex<f64>,
    decay: f64,
}

impl Embedded {
    /// Polarizations s and p of a stack in the medium light comes from.
    pub fn new(incidence: &Incidence, stack: &[Characteristic; 2]) -> [Self; 2] {
        let q0 = incidence.admittances();
        [0, 1].map(|p| {
            let [m11, m12, m21, m22] = stack[p].m;
            let (electric, magnetic) = (m12 * q0[p], m21 / q0[p]);
            Self {
                a: electric - magnetic,
                d: m11 - m22,
                denominator: m11 + m22 + electric + magnetic,
                decay: stack[p].decay,
            }
        })
    }

    /// `cos(delta)` times this and `i sin(delta)` times `other`: the stack with a layer in it, from the stack without it
    /// and with the layer's generator in its place.
    #[must_use]
    pub fn turned(&self, other: &Self, turn: &Turn) -> Self {
        Self {
            a: self.a * turn.cos + other.a * turn.i_sin,
            d: self.d * turn.cos + other.d * turn.i_sin,
            denominator: self.denominator * turn.cos + other.denominator * turn.i_sin,
            decay: self.decay * turn.decay,
        }
    }

    /// Power reflectance, mean of both faces, and transmittance, the same from both.
    pub fn power(&self) -> (f64, f64) {
        let per = self.denominator.norm_sqr().recip();
        ((self.a.norm_sqr() + self.d.norm_sqr()) * per, 4.0 * per * self.decay)
    }
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

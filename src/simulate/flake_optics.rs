//! Reflectance and transmittance of one flake in its binder, over wavelength and angle of incidence.

use super::composition::{FlakeKind, Mirror, StackLayer};
use super::piecewise::Piecewise;
use super::thin_film::{FilmLayer, StackPower, stack_power};
use crate::color::{BANDS, wavelength_nm};
use crate::error::{Error, Result};
use nalgebra::Complex;

/// Error of the tabulated stacks, of the largest value over angles: well below that of the extinction made from them, whose
/// own table would otherwise chase the seams of this one.
const TOLERANCE: f64 = 1e-9;

/// r_p and t_p of a flake (Ershov 2001; p stands for platelet). Flakes lie either side up, so faces are averaged.
#[derive(Debug, Clone, PartialEq)]
pub enum FlakeOptics {
    /// The same at every angle.
    Mirror(Box<Mirror>),
    /// Interference of thin layers, tabulated over `|cos alpha|`, in which it is analytic.
    Stack {
        /// r_p, mean of both faces.
        reflectance: Piecewise<BANDS>,
        /// t_p, the same from both (reciprocity).
        transmittance: Piecewise<BANDS>,
    },
}

impl FlakeOptics {
    /// Optics of a kind of flakes in a binder of real index `binder`.
    ///
    /// # Errors
    /// An unknown material, a kind without optics: what [`super::Composition::validate`] refuses. A stack whose fringes over
    /// the angle are too fine for the table: it must hold a resonance far sharper than those of any flake.
    pub fn new(kind: &FlakeKind, binder: f64) -> Result<Self> {
        match (&kind.mirror, &kind.stack) {
            (Some(mirror), _) => Ok(Self::Mirror(Box::new(mirror.clone()))),
            (None, Some(layers)) => Self::stack(layers, binder),
            (None, None) => Err(Error::invalid("", "flake", "neither mirror nor stack", "one of the two")),
        }
    }

    fn stack(layers: &[StackLayer], binder: f64) -> Result<Self> {
        let mut down = vec![Vec::new(); BANDS];
        for layer in layers {
            let (n, k) = layer.indices()?;
            for (band, film) in down.iter_mut().enumerate() {
                let index = Complex::new(n.0[band], k.0[band]);
                film.push(FilmLayer { index, thickness_nm: layer.thickness_nm });
            }
        }
        let up: Vec<Vec<_>> = down.iter().map(|film| film.iter().rev().copied().collect()).collect();
        let exit = Complex::new(binder, 0.0);
        let power = |films: &[Vec<FilmLayer>], band: usize, cos_alpha: f64| -> StackPower {
            stack_power(binder, &films[band], exit, cos_alpha, wavelength_nm(band))
        };
        let range = [0.0, 0.5, 1.0];
        Ok(Self::Stack {
            reflectance: Piecewise::fit("reflectance of a stack", &range, TOLERANCE, |cos_alpha| {
                std::array::from_fn(|band| {
                    let [a, b] = [&down, &up].map(|films| power(films, band, cos_alpha));
                    0.5 * (a.unpolarized_reflectance() + b.unpolarized_reflectance())
                })
            })?,
            transmittance: Piecewise::fit("transmittance of a stack", &range, TOLERANCE, |cos_alpha| {
                std::array::from_fn(|band| power(&down, band, cos_alpha).unpolarized_transmittance())
            })?,
        })
    }

    /// r_p at an angle of incidence alpha on the flake.
    pub fn reflectance(&self, cos_alpha: f64) -> [f64; BANDS] {
        match self {
            Self::Mirror(mirror) => mirror.reflectance.0,
            Self::Stack { reflectance, .. } => reflectance.eval(cos_alpha),
        }
    }

    /// t_p at an angle of incidence alpha on the flake.
    pub fn transmittance(&self, cos_alpha: f64) -> [f64; BANDS] {
        match self {
            Self::Mirror(mirror) => mirror.transmittance.0,
            Self::Stack { transmittance, .. } => transmittance.eval(cos_alpha),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_hold_what_the_matrices_say() {
        let layer = |material: &str, thickness_nm| StackLayer {
            material: Some(material.into()),
            index: None,
            extinction: None,
            thickness_nm,
        };
        // Asymmetric and absorbing, with a silica layer that reflects totally in this binder.
        let layers = [layer("TiO2", 120.0), layer("SiO2", 400.0), layer("Al", 15.0)];
        let optics = FlakeOptics::stack(&layers, 1.5).unwrap();
        for step in 0..=400 {
            let cos_alpha = f64::from(step) / 400.0;
            let (r, t) = (optics.reflectance(cos_alpha), optics.transmittance(cos_alpha));
            for band in [0, 17, 40] {
                let film: Vec<_> = layers
                    .iter()
                    .map(|l| {
                        let (n, k) = l.indices().unwrap();
                        let index = Complex::new(n.0[band], k.0[band]);
                        FilmLayer { index, thickness_nm: l.thickness_nm }
                    })
                    .collect();
                let back: Vec<_> = film.iter().rev().copied().collect();
                let exit = Complex::new(1.5, 0.0);
                let [a, b] = [film, back].map(|f| stack_power(1.5, &f, exit, cos_alpha, wavelength_nm(band)));
                let mean = 0.5 * (a.unpolarized_reflectance() + b.unpolarized_reflectance());
                // Ten times the tolerance of the three points tested while tabulating.
                assert!((r[band] - mean).abs() < 1e-8, "{cos_alpha} {band}");
                assert!((t[band] - a.unpolarized_transmittance()).abs() < 1e-8, "{cos_alpha} {band}");
                assert!((t[band] - b.unpolarized_transmittance()).abs() < 1e-8, "{cos_alpha} {band}");
            }
        }
    }
}

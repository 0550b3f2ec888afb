//! Reflectance and transmittance of the flakes of one kind in their binder, over wavelength and angle of incidence.

use super::piecewise::Piecewise;
use super::stack_classes::StackClasses;
use crate::color::BANDS;
use crate::error::{Error, Result};
use crate::simulate::composition::{FlakeKind, Mirror};

/// Error of the tabulated stacks, of the largest value over angles: a thousandth of what the models promise, and well below
/// that of the extinction made from them, whose own table would otherwise chase the seams of this one.
const TOLERANCE: f64 = 1e-5;
/// The same for flakes of many classes, whose mean is no better than [`StackClasses`] says.
const MEAN_TOLERANCE: f64 = 1e-4;
/// First panels: a flake becomes a sharper resonator as light grazes it.
const PANELS: [f64; 6] = [0.0, 0.0625, 0.125, 0.25, 0.5, 1.0];

/// r_p and t_p of the flakes of a kind (Ershov 2001; p stands for platelet). Flakes lie either side up, so faces are
/// averaged.
#[derive(Debug, Clone, PartialEq)]
pub enum FlakeOptics {
    /// The same at every angle.
    Mirror(Box<Mirror>),
    /// Interference of thin layers, tabulated over `|cos alpha|`, in which it is analytic.
    Stack {
        /// The classes of flakes, one unless a layer's thickness varies.
        classes: StackClasses,
        /// r_p, mean of both faces and all classes.
        reflectance: Piecewise<BANDS>,
        /// t_p, mean of all classes; the same from both faces (reciprocity).
        transmittance: Piecewise<BANDS>,
    },
}

/// r_p and t_p of all bands over `|cos alpha|`.
type Rows<'a> = dyn Fn(f64) -> [f64; 2 * BANDS] + Sync + 'a;

impl FlakeOptics {
    /// Optics of a kind of flakes in a binder of real index `binder`.
    ///
    /// # Errors
    /// An unknown material, a kind without optics: what [`crate::simulate::Composition::validate`] refuses. A stack whose fringes over
    /// the angle are too fine for the table: it must hold a resonance far sharper than those of any flake. Spreads that take
    /// too many classes ([`StackClasses::new`]).
    pub fn new(kind: &FlakeKind, binder: f64) -> Result<Self> {
        Self::tabulated(kind, binder, |classes, both| {
            let tolerance = if classes.weights().len() == 1 { TOLERANCE } else { MEAN_TOLERANCE };
            Piecewise::fit("reflectance of a stack", &PANELS, tolerance, both)
        })
    }

    /// [`FlakeOptics::new`] with tables at 32 angles, whatever that leaves of the fringes: for averages over angles.
    ///
    /// # Errors
    /// As [`FlakeOptics::new`].
    pub fn coarse(kind: &FlakeKind, binder: f64) -> Result<Self> {
        Self::tabulated(kind, binder, |_, both| {
            let halves = [0.0, 0.5, 1.0];
            let values: Vec<_> = Piecewise::<{ 2 * BANDS }>::nodes(&halves).into_iter().map(both).collect();
            Ok(Piecewise::from_values(&halves, &values))
        })
    }

    fn tabulated(
        kind: &FlakeKind,
        binder: f64,
        table: impl FnOnce(&StackClasses, &Rows) -> Result<Piecewise<{ 2 * BANDS }>>,
    ) -> Result<Self> {
        match (&kind.mirror, &kind.stack) {
            (Some(mirror), _) => Ok(Self::Mirror(Box::new(mirror.clone()))),
            (None, Some(layers)) => {
                let classes = StackClasses::new(layers, binder)?;
                let both = table(&classes, &|cos_alpha| {
                    let mut row = [0.0; 2 * BANDS];
                    for band in 0..BANDS {
                        (row[band], row[BANDS + band]) = classes.mean(cos_alpha, band);
                    }
                    row
                })?;
                Ok(Self::Stack { classes, reflectance: both.part(0), transmittance: both.part(BANDS) })
            }
            (None, None) => Err(Error::invalid("", "flake", "neither mirror nor stack", "one of the two")),
        }
    }

    /// r_p at an angle of incidence alpha on the flake, mean of all flakes, computed anew.
    pub fn exact_reflectance(&self, cos_alpha: f64) -> [f64; BANDS] {
        match self {
            Self::Mirror(mirror) => mirror.reflectance.0,
            Self::Stack { classes, .. } => std::array::from_fn(|band| classes.mean(cos_alpha, band).0),
        }
    }

    /// r_p at an angle of incidence alpha on the flake, mean of all flakes.
    pub fn reflectance(&self, cos_alpha: f64) -> [f64; BANDS] {
        match self {
            Self::Mirror(mirror) => mirror.reflectance.0,
            Self::Stack { reflectance, .. } => reflectance.eval(cos_alpha),
        }
    }

    /// t_p at an angle of incidence alpha on the flake, mean of all flakes.
    pub fn transmittance(&self, cos_alpha: f64) -> [f64; BANDS] {
        match self {
            Self::Mirror(mirror) => mirror.transmittance.0,
            Self::Stack { transmittance, .. } => transmittance.eval(cos_alpha),
        }
    }

    /// Share of the flakes in each class of equal flakes; the sum is 1.
    pub fn class_weights(&self) -> &[f64] {
        match self {
            Self::Mirror(_) => &[1.0],
            Self::Stack { classes, .. } => classes.weights(),
        }
    }

    /// r_p of each class, in the order of [`FlakeOptics::class_weights`], computed anew; its weighted mean is
    /// [`FlakeOptics::reflectance`] to the error of that table, 1e-4 of its greatest value over angles.
    pub fn class_reflectances(&self, cos_alpha: f64) -> Vec<[f64; BANDS]> {
        match self {
            Self::Mirror(mirror) => vec![mirror.reflectance.0],
            Self::Stack { classes, .. } => classes.reflectances(cos_alpha),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::thin_film::{FilmLayer, stack_power};
    use super::*;
    use crate::color::wavelength_nm;
    use crate::simulate::composition::StackLayer;
    use nalgebra::Complex;

    fn layer(material: &str, thickness_nm: f64, thickness_spread: f64) -> StackLayer {
        StackLayer {
            material: Some(material.into()),
            index: None,
            extinction: None,
            thickness_nm,
            thickness_spread,
        }
    }

    fn flake(layers: &[StackLayer]) -> FlakeKind {
        let text = "area_density = 1\ndiameter_um = 20\nsigma_deg = 5\nstack = []\n";
        FlakeKind { stack: Some(layers.to_vec()), ..toml::from_str(text).unwrap() }
    }

    /// Mean reflectance of both faces, and the transmittances of both, straight from the matrices.
    fn exact(layers: &[StackLayer], cos_alpha: f64, band: usize) -> (f64, [f64; 2]) {
        let film: Vec<_> = layers
            .iter()
            .map(|l| {
                let (n, k) = l.indices().unwrap();
                FilmLayer { index: Complex::new(n.0[band], k.0[band]), thickness_nm: l.thickness_nm }
            })
            .collect();
        let back: Vec<_> = film.iter().rev().copied().collect();
        let exit = Complex::new(1.5, 0.0);
        let [a, b] = [film, back].map(|f| stack_power(1.5, &f, exit, cos_alpha, wavelength_nm(band)));
        let mean = 0.5 * (a.unpolarized_reflectance() + b.unpolarized_reflectance());
        (mean, [a.unpolarized_transmittance(), b.unpolarized_transmittance()])
    }

    #[test]
    fn tables_hold_what_the_matrices_say() {
        // Asymmetric and absorbing, with a silica layer that reflects totally in this binder.
        let layers = [layer("TiO2", 120.0, 0.0), layer("SiO2", 400.0, 0.0), layer("Al", 15.0, 0.0)];
        let optics = FlakeOptics::new(&flake(&layers), 1.5).unwrap();
        for step in 0..=400 {
            let cos_alpha = f64::from(step) / 400.0;
            let (r, t) = (optics.reflectance(cos_alpha), optics.transmittance(cos_alpha));
            for band in [0, 17, 40] {
                let (mean, passed) = exact(&layers, cos_alpha, band);
                // Ten times the tolerance of the three points tested while tabulating.
                assert!((r[band] - mean).abs() < 10.0 * TOLERANCE, "{cos_alpha} {band}");
                assert!((t[band] - passed[0]).abs() < 10.0 * TOLERANCE, "{cos_alpha} {band}");
                // Reciprocity, to rounding.
                assert!((passed[0] - passed[1]).abs() < 1e-13, "{cos_alpha} {band}");
            }
        }
        assert_eq!(optics.class_weights(), [1.0]);
    }

    #[test]
    fn the_mean_over_classes_is_the_smooth_reflectance_and_that_of_the_law() {
        let layers = [layer("TiO2", 60.0, 0.05), layer("mica", 500.0, 0.2), layer("TiO2", 60.0, 0.0)];
        let optics = FlakeOptics::new(&flake(&layers), 1.5).unwrap();
        let weights = optics.class_weights();
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-13);
        // Both laws are cut at three standard deviations: a plain product rule over them.
        let fine: Vec<(f64, f64)> = (0..400)
            .map(|k| -3.0 + 0.015 * (f64::from(k) + 0.5))
            .map(|t| (t, (-0.5 * t * t).exp()))
            .collect();
        let coarse: Vec<_> = super::super::thickness_spread::gauss_rule(0.05, 8)
            .iter()
            .map(|(x, w)| ((x - 1.0) / 0.05, *w))
            .collect();
        let total: f64 = fine.iter().map(|x| x.1).sum();
        for cos_alpha in [0.72, 0.9, 1.0] {
            let classes = optics.class_reflectances(cos_alpha);
            for band in [0, 12, 40] {
                let mean: f64 = weights.iter().zip(&classes).map(|(w, r)| w * r[band]).sum();
                let smooth = optics.reflectance(cos_alpha)[band];
                // Three times the tolerance of the points tested while tabulating.
                assert!((mean - smooth).abs() < 3.0 * MEAN_TOLERANCE, "{cos_alpha} {band}: {mean} {smooth}");
                let mut law = 0.0;
                for (coating, w) in &coarse {
                    for (core, v) in &fine {
                        let mut one = layers.clone();
                        one[0].thickness_nm *= 1.0 + 0.05 * coating;
                        one[1].thickness_nm *= 1.0 + 0.2 * core;
                        law += w * v / total * exact(&one, cos_alpha, band).0;
                    }
                }
                // The classes' tolerance, once for each spread.
                assert!((mean - law).abs() < 2e-3, "{cos_alpha} {band}: {mean} {law}");
            }
        }
    }

    #[test]
    fn a_spread_washes_out_the_fringes_of_the_core() {
        let ripple = |spread: f64| {
            let layers = [layer("TiO2", 43.0, 0.0), layer("mica", 500.0, spread), layer("TiO2", 43.0, 0.0)];
            let optics = FlakeOptics::new(&flake(&layers), 1.5).unwrap();
            let r = optics.reflectance(1.0);
            (1..BANDS - 1).map(|k| (r[k - 1] - 2.0 * r[k] + r[k + 1]).abs()).sum::<f64>()
        };
        assert!(ripple(0.25) < 0.1 * ripple(0.0), "{} {}", ripple(0.25), ripple(0.0));
    }

    #[test]
    fn a_coating_of_no_thickness_is_none_and_metal_takes_its_share() {
        let optics = |layers: &[StackLayer]| FlakeOptics::new(&flake(layers), 1.5).unwrap();
        let coated = optics(&[layer("TiO2", 0.0, 0.3), layer("mica", 500.0, 0.0), layer("TiO2", 0.0, 0.0)]);
        let bare = optics(&[layer("mica", 500.0, 0.0)]);
        let metal = optics(&[layer("SiO2", 300.0, 0.0), layer("Al", 20.0, 0.0)]);
        for k in 0..=50 {
            let cos_alpha = f64::from(k) / 50.0;
            let [a, b] = [&coated, &bare].map(|o| o.reflectance(cos_alpha));
            let (r, t) = (metal.reflectance(cos_alpha), metal.transmittance(cos_alpha));
            for band in 0..BANDS {
                // Two tables.
                assert!((a[band] - b[band]).abs() < 20.0 * TOLERANCE, "{cos_alpha} {band}");
                let total = bare.transmittance(cos_alpha)[band] + b[band];
                assert!((total - 1.0).abs() < 20.0 * TOLERANCE, "{cos_alpha} {band}: {total}");
                // Grazing light is all reflected.
                assert!(r[band] + t[band] < 1.0 + 20.0 * TOLERANCE, "{cos_alpha} {band}");
                assert!(k < 5 || r[band] + t[band] < 0.995, "{cos_alpha} {band}: {}", r[band] + t[band]);
            }
        }
    }
}

//! The clear coat: what light loses on its way in and out, and the gloss it makes.
//!
//! `f_outside = (1 - F(wi)) (1 - F(wo)) f_base + gloss`, with exact unpolarized Fresnel reflectance of the coat's index;
//! with `refracts` the base is evaluated at the refracted directions. The 1/eta^2 of refraction is absorbed in the base's
//! coefficients, as in AxF files. An index of 1 takes nothing away: so is a paint fitted to a measurement from outside,
//! whose gloss is a narrow lobe of its own (Rump et al. 2008, eq. 6), never colored by chi. A simulated rough surface has both
//! the losses and the lobe.

use super::cook_torrance::Lobe;
use super::fresnel::{normal_reflectance, refracted_cosine, transmitted};
use crate::error::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_1_SQRT_2;

/// The clear coat of a paint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClearCoat {
    /// Index of refraction, 1 to 4; 1 = no loss at the surface.
    pub ior: f64,
    /// Whether the base is seen along refracted directions.
    pub refracts: bool,
    /// Share of the ideal mirror reflection F(theta) at the surface, 0 to 1.
    pub mirror: f64,
    /// Gloss lobe of a slightly rough surface, measured or [`ClearCoat::rough`].
    pub gloss: Option<Lobe>,
}

impl ClearCoat {
    /// No coat at all.
    pub const NONE: Self = Self { ior: 1.0, refracts: false, mirror: 0.0, gloss: None };

    /// An ideal coat of index `ior`: mirror gloss and Fresnel losses.
    pub fn ideal(ior: f64, refracts: bool) -> Self {
        Self { ior, refracts, mirror: 1.0, gloss: None }
    }

    /// A coat of index `ior` whose gloss spreads about the mirror direction with the width `sigma`, radians, > 0, of a
    /// Gaussian over directions at normal incidence, instead of the mirror: all of it goes into one lobe.
    ///
    /// Half vectors turn half as far as directions, and Beckmann's alpha is sqrt 2 times their width: alpha = sigma / sqrt 2.
    /// The coefficient 1/4 takes back the convention's factor of four. Schlick's reflectance is below Fresnel's up to 74
    /// degrees, at an index of 1.5 by at most 0.02, or 23 %, near 60.
    pub fn rough(ior: f64, refracts: bool, sigma: f64) -> Self {
        let gloss = Lobe { coefficient: 0.25, roughness: sigma * FRAC_1_SQRT_2, f0: normal_reflectance(ior) };
        Self { ior, refracts, mirror: 0.0, gloss: Some(gloss) }
    }

    /// Transmittance `(1 - F(wi)) (1 - F(wo))` for outer cosines.
    pub fn transmittance(&self, cos_i: f64, cos_o: f64) -> f64 {
        transmitted(cos_i, self.ior) * transmitted(cos_o, self.ior)
    }

    /// The direction that the base sees: refracted, or the outer one.
    pub fn inner(&self, outer: DVec3) -> DVec3 {
        if !self.refracts {
            return outer;
        }
        let tangent = outer.truncate() / self.ior;
        tangent.extend(refracted_cosine(outer.z, self.ior))
    }

    /// The outer direction that the base sees as this one; `None` if light is held in the coat by total reflection.
    pub fn outer(&self, inner: DVec3) -> Option<DVec3> {
        if !self.refracts {
            return Some(inner);
        }
        let tangent = inner.truncate() * self.ior;
        let squared = 1.0 - tangent.length_squared();
        (squared > 0.0).then(|| tangent.extend(squared.sqrt()))
    }

    /// # Errors
    /// A field outside its legal range, named.
    pub fn validate(&self) -> Result<()> {
        if !(1.0..=4.0).contains(&self.ior) {
            return Err(Error::invalid("clear coat", "ior", self.ior, "1 to 4"));
        }
        if !(0.0..=1.0).contains(&self.mirror) {
            return Err(Error::invalid("clear coat", "mirror", self.mirror, "0 to 1"));
        }
        if let Some(lobe) = &self.gloss {
            lobe.validate().map_err(|e| e.within("clear coat: gloss"))?;
        }
        Ok(())
    }
}

impl Lobe {
    /// Largest absolute value of a coefficient.
    pub const MAX_COEFFICIENT: f64 = 1e6;

    /// # Errors
    /// A field outside its legal range, named: a coefficient within +-1e6 (extrapolated paints have negative ones), a
    /// roughness of 1e-30 to 100 (its square is still a number; the renderer takes 1e-6 for anything sharper), F0 of 0 to 1.
    pub fn validate(&self) -> Result<()> {
        if !(-Self::MAX_COEFFICIENT..=Self::MAX_COEFFICIENT).contains(&self.coefficient) {
            return Err(Error::invalid("lobe", "coefficient", self.coefficient, "-1e6 to 1e6"));
        }
        if !(1e-30..=100.0).contains(&self.roughness) {
            return Err(Error::invalid("lobe", "roughness", self.roughness, "1e-30 to 100"));
        }
        if !(0.0..=1.0).contains(&self.f0) {
            return Err(Error::invalid("lobe", "f0", self.f0, "0 to 1"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refraction_is_undone() {
        let coat = ClearCoat::ideal(1.5, true);
        for theta in [0.0, 0.4, 1.2, 1.57] {
            let outer = DVec3::new(f64::sin(theta), 0.0, f64::cos(theta));
            // At grazing the cosine is the root of a difference of squares of about 1.
            assert!((coat.outer(coat.inner(outer)).unwrap() - outer).length() < 1e-12, "{theta}");
        }
        assert_eq!(coat.outer(DVec3::new(0.7, 0.0, 0.51f64.sqrt())), None, "beyond 41.8 degrees");
        let plain = ClearCoat::ideal(1.5, false);
        assert_eq!(plain.outer(DVec3::X), Some(DVec3::X));
    }

    #[test]
    fn what_cannot_be_rendered_is_refused() {
        let good = Lobe { coefficient: -1e6, roughness: 1e-30, f0: 0.04 };
        good.validate().unwrap();
        for bad in [f64::NAN, f64::INFINITY, -1.1e6, 1e300] {
            assert!(Lobe { coefficient: bad, ..good }.validate().is_err(), "{bad}");
        }
        for bad in [f64::NAN, 0.0, 1e-200, 101.0] {
            assert!(Lobe { roughness: bad, ..good }.validate().is_err(), "{bad}");
        }
        for bad in [f64::NAN, -0.1, 1.1] {
            assert!(Lobe { f0: bad, ..good }.validate().is_err(), "{bad}");
            assert!(ClearCoat { mirror: bad, ..ClearCoat::NONE }.validate().is_err(), "{bad}");
        }
        for bad in [f64::NAN, 0.9, 4.1] {
            assert!(ClearCoat { ior: bad, ..ClearCoat::NONE }.validate().is_err(), "{bad}");
        }
        let gloss = Some(Lobe { f0: 2.0, ..good });
        let message = ClearCoat { gloss, ..ClearCoat::NONE }.validate().unwrap_err().to_string();
        assert!(message.starts_with("clear coat: gloss: lobe: f0"), "{message}");
    }
}

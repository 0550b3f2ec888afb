//! Changes of one physical quantity of a composition.

use crate::color::Spectrum;
use crate::error::Result;
use crate::simulate::Composition;
use serde::Serialize;
use std::fmt;

/// A quantity that changes from one end to the other, all others staying.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PhysicalChange {
    /// Flake area per area, to 0.4 of it.
    FlakeDensity,
    /// Mean diameter, to twice it (area density kept).
    FlakeSize,
    /// Width of the tilts, to 1.8 of it.
    OrientationWidth,
    /// Thickness of the coatings of layered flakes (their first and last layers), to 1.4 of it.
    CoatingThickness,
    /// Reflectance of mirror flakes, to that of a copper color.
    FlakeColor,
    /// Absorption of the binder, by a pigment that takes 80/mm of blue and nothing of red.
    BaseColor,
}

impl PhysicalChange {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::FlakeDensity,
        Self::FlakeSize,
        Self::OrientationWidth,
        Self::CoatingThickness,
        Self::FlakeColor,
        Self::BaseColor,
    ];

    /// The composition that far, 0 to 1, toward the other end.
    ///
    /// # Errors
    /// An end that is no legal composition.
    pub fn at(self, start: &Composition, way: f64) -> Result<Composition> {
        let mut changed = start.clone();
        let [copper, yellow] = tints();
        for film in &mut changed.films {
            if self == Self::BaseColor {
                film.absorption_per_mm = sum(&film.absorption_per_mm, 1.0, &yellow, 80.0 * way);
            }
            for kind in &mut film.flakes {
                match self {
                    Self::FlakeDensity => kind.area_density *= 1.0 - 0.6 * way,
                    Self::FlakeSize => kind.diameter_um *= 1.0 + way,
                    Self::OrientationWidth => kind.sigma_deg = kind.sigma_deg.map(|s| s * (1.0 + 0.8 * way)),
                    Self::CoatingThickness => {
                        let layers = kind.stack.as_mut().filter(|layers| layers.len() > 2);
                        if let Some([first, .., last]) = layers.map(|l| &mut l[..]) {
                            first.thickness_nm *= 1.0 + 0.4 * way;
                            last.thickness_nm *= 1.0 + 0.4 * way;
                        }
                    }
                    Self::FlakeColor => {
                        if let Some(mirror) = &mut kind.mirror {
                            let own = mirror.reflectance.0;
                            let tinted = Spectrum(std::array::from_fn(|k| own[k] * copper.0[k]));
                            mirror.reflectance = sum(&mirror.reflectance, 1.0 - way, &tinted, way);
                        }
                    }
                    Self::BaseColor => {}
                }
            }
        }
        changed.validate()?;
        Ok(changed)
    }
}

impl fmt::Display for PhysicalChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::FlakeDensity => "flake density",
            Self::FlakeSize => "flake size",
            Self::OrientationWidth => "orientation width",
            Self::CoatingThickness => "coating thickness",
            Self::FlakeColor => "flake color",
            Self::BaseColor => "base color",
        })
    }
}

/// The filter that turns aluminium into copper, and the absorption of a yellow pigment, 0 to 1.
fn tints() -> [Spectrum; 2] {
    let ramp = |from: f64, to: f64| {
        let n = Spectrum::constant(0.0).0.len();
        Spectrum(std::array::from_fn(|k| {
            let x = (k as f64 / (n - 1) as f64 * 400.0 - 140.0) / 120.0;
            from + (to - from) * x.clamp(0.0, 1.0)
        }))
    };
    [ramp(0.45, 1.0), ramp(1.0, 0.0)]
}

fn sum(a: &Spectrum, wa: f64, b: &Spectrum, wb: f64) -> Spectrum {
    Spectrum(std::array::from_fn(|k| wa * a.0[k] + wb * b.0[k]))
}

//! What is legal in a recipe, but beyond what the model assumes.

use super::{Composition, Film, FlakeKind};
use crate::error::Result;

/// Thickness of a flake given by its reflectance alone, micrometres: aluminium flakes of the common kinds have 0.1-0.5.
const MIRROR_FLAKE_UM: f64 = 0.3;
/// Share of a film's volume up to which pigments scatter independently: from some 0.1 on the scattering per particle of
/// white pigments falls off (crowding).
const INDEPENDENT_PIGMENTS: f64 = 0.1;

impl Composition {
    /// Where the paint leaves what the model assumes, one sentence a place; empty for a sound one.
    ///
    /// Flakes are taken for independent of each other. Placed so, a flake crosses `D<S>h (2 d sin(gamma) + 8 t) / h` others
    /// on average: the number in a volume times the volume that one disc of diameter d and thickness t denies to another at
    /// an angle gamma (Onsager 1949), here the root mean square over P. Real flakes cannot cross; once independent ones
    /// would cross one other each, the warning is given, with the area density at which that begins. Flakes given by their
    /// reflectance count as 0.3 micrometres thick.
    ///
    /// Pigments are taken for independent too; the warning comes beyond a tenth of the film's volume.
    ///
    /// # Errors
    /// As [`FlakeKind::orientation`].
    pub fn warnings(&self) -> Result<Vec<String>> {
        let mut all = Vec::new();
        for (k, film) in self.films.iter().enumerate() {
            let crossed = film.crossed_flakes()?;
            if crossed > 1.0 {
                let area: f64 = film.flakes.iter().map(|kind| kind.area_density).sum();
                let limit = area / crossed;
                all.push(if crossed.is_finite() {
                    format!(
                        "film[{k}]: more flake area than space: at an area density of {area:.3} a flake crosses \
                         {crossed:.2} others on average; flakes are independent up to a density of about {limit:.2}"
                    )
                } else {
                    format!("film[{k}]: a film of no thickness has no room for flakes")
                });
            }
            let volume = film.sphere_volume();
            if volume > INDEPENDENT_PIGMENTS {
                all.push(format!(
                    "film[{k}]: pigments fill {volume:.3} of the volume; they scatter independently up to about \
                     {INDEPENDENT_PIGMENTS}"
                ));
            }
        }
        Ok(all)
    }
}

impl Film {
    /// How many others a flake placed at random crosses on average, all kinds alike.
    fn crossed_flakes(&self) -> Result<f64> {
        let (mut area, mut diameter, mut thickness, mut upright) = (0.0, 0.0, 0.0, 0.0);
        for kind in &self.flakes {
            area += kind.area_density;
            diameter += kind.area_density * kind.diameter_um;
            thickness += kind.area_density * kind.thickness_um();
            upright += kind.area_density * kind.orientation()?.mean_squared_cosine();
        }
        if area == 0.0 {
            return Ok(0.0);
        }
        // The mean of n n^T is diag((1 - c)/2, (1 - c)/2, c), and cos(gamma) = n . n' of two independent normals.
        let c = upright / area;
        let sin_gamma = (1.0 - c * c - 0.5 * (1.0 - c).powi(2)).max(0.0).sqrt();
        // A film of no thickness has room for none.
        Ok((2.0 * diameter * sin_gamma + 8.0 * thickness) / self.thickness_um)
    }
}

impl FlakeKind {
    fn thickness_um(&self) -> f64 {
        let stack =
            |layers: &Vec<_>| layers.iter().map(|l: &super::StackLayer| l.thickness_nm).sum::<f64>() * 1e-3;
        self.stack.as_ref().map_or(MIRROR_FLAKE_UM, stack)
    }
}

//! A measured or simulated isotropic BRDF as a table over both polar angles and the azimuth between them.

use crate::error::{Error, Result};
use crate::math::half_difference::spherical;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Linear Rec.709 BRDF values, 1/sr, no cosine, at cell centers: polar angles uniform over [0, pi/2), azimuth difference
/// uniform over [0, pi]. Azimuth is that of directions pointing away from the surface: pi is the mirror side, 0 the side of
/// the light.
#[derive(Debug, Clone, PartialEq)]
pub struct TabulatedBrdf {
    resolution: [usize; 2],
    values: Vec<[f32; 3]>,
}

impl TabulatedBrdf {
    /// Largest number of polar or azimuthal cells.
    pub const MAX_RESOLUTION: usize = 720;

    /// A table of `theta` polar and `phi` azimuthal cells; index `(theta_in * theta + theta_out) * phi + azimuth`.
    ///
    /// # Errors
    /// A resolution outside 2-720, a length that does not fit, a value that is not finite (its cell named).
    pub fn new(theta: usize, phi: usize, values: Vec<[f32; 3]>) -> Result<Self> {
        if [theta, phi].iter().any(|n| !(2..=Self::MAX_RESOLUTION).contains(n)) {
            return Err(Error::invalid(
                "table",
                "resolution",
                format!("{theta} x {phi}"),
                "sides of 2 to 720",
            ));
        }
        let expected = theta * theta * phi;
        if values.len() != expected {
            return Err(Error::invalid("table", "length", values.len(), format!("{expected} colors")));
        }
        if let Some(k) = values.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
            let place = format!(
                "table: theta_in {}, theta_out {}, phi {}",
                k / phi / theta,
                k / phi % theta,
                k % phi
            );
            return Err(Error::invalid(place, "value", format!("{:?}", values[k]), "finite numbers"));
        }
        Ok(Self { resolution: [theta, phi], values })
    }

    /// A table filled by a function of `(wi, wo)`.
    ///
    /// # Errors
    /// As [`TabulatedBrdf::new`].
    pub fn from_fn(theta: usize, phi: usize, f: impl Fn(DVec3, DVec3) -> DVec3 + Sync) -> Result<Self> {
        use rayon::prelude::*;
        let values = (0..theta * theta)
            .into_par_iter()
            .flat_map_iter(|row| {
                let f = &f;
                (0..phi).map(move |k| {
                    let wi = spherical(polar(row / theta, theta), 0.0);
                    let wo = spherical(polar(row % theta, theta), azimuth(k, phi));
                    f(wi, wo).as_vec3().to_array()
                })
            })
            .collect();
        Self::new(theta, phi, values)
    }

    /// Polar and azimuthal cells.
    pub fn resolution(&self) -> [usize; 2] {
        self.resolution
    }

    /// All values, in file order.
    pub fn values(&self) -> &[[f32; 3]] {
        &self.values
    }

    /// Directions at the center of cell (theta_in, theta_out, azimuth).
    pub fn directions(&self, theta_in: usize, theta_out: usize, phi: usize) -> (DVec3, DVec3) {
        let [n, m] = self.resolution;
        (spherical(polar(theta_in, n), 0.0), spherical(polar(theta_out, n), azimuth(phi, m)))
    }

    /// Value of cell (theta_in, theta_out, azimuth).
    pub fn cell(&self, theta_in: usize, theta_out: usize, phi: usize) -> DVec3 {
        let [n, m] = self.resolution;
        DVec3::from(self.values[(theta_in * n + theta_out) * m + phi].map(f64::from))
    }

    /// Trilinear look-up for directions away from the surface. Nearer the pole than the first cell center the table goes on
    /// through the pole, to the same cell seen from the other side; beyond the other outermost centers it is clamped.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> DVec3 {
        let [n, m] = self.resolution;
        let theta = |w: DVec3| w.truncate().length().atan2(w.z) / FRAC_PI_2 * n as f64 - 0.5;
        let cross = wi.truncate().perp_dot(wo.truncate());
        let turn = cross.abs().atan2(wi.truncate().dot(wo.truncate())) / PI * m as f64 - 0.5;
        let mut sum = DVec3::ZERO;
        for (a, over_a, weight_a) in across_the_pole(theta(wi), n) {
            for (b, over_b, weight_b) in across_the_pole(theta(wo), n) {
                // Passing the pole turns an azimuth by pi; the table's is folded at pi.
                let turn = if over_a == over_b { turn } else { (m - 1) as f64 - turn };
                let (low, fraction) = bracket(turn, m);
                for (c, weight_c) in [(low, 1.0 - fraction), (low + 1, fraction)] {
                    let weight = weight_a * weight_b * weight_c;
                    if weight != 0.0 {
                        sum += self.cell(a, b, c) * weight;
                    }
                }
            }
        }
        sum
    }
}

/// The two cells of a polar position, whether each lies beyond the pole, and their weights.
fn across_the_pole(position: f64, n: usize) -> [(usize, bool, f64); 2] {
    if position < 0.0 {
        return [(0, true, -position), (0, false, 1.0 + position)];
    }
    let (low, fraction) = bracket(position, n);
    [(low, false, 1.0 - fraction), (low + 1, false, fraction)]
}

fn polar(k: usize, n: usize) -> f64 {
    FRAC_PI_2 * (k as f64 + 0.5) / n as f64
}

fn azimuth(k: usize, n: usize) -> f64 {
    PI * (k as f64 + 0.5) / n as f64
}

/// Lower neighbour of a position in cell centers, and the weight of the upper one.
fn bracket(position: f64, n: usize) -> (usize, f64) {
    let x = position.clamp(0.0, (n - 1) as f64);
    let low = (x as usize).min(n - 2);
    (low, x - low as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cell_centres_return_their_value_and_planes_are_exact() {
        // Linear in both polar angles, so that trilinear interpolation is exact inside the outermost centers.
        let f = |wi: DVec3, wo: DVec3| DVec3::new(wi.z.acos(), wo.z.acos(), 1.0);
        let table = TabulatedBrdf::from_fn(9, 12, f).unwrap();
        for (a, b) in [(0.3, 0.9), (1.0, 0.5)] {
            let c = table.eval(spherical(a, 0.4), spherical(b, 2.0));
            // f32 storage.
            assert!((c - DVec3::new(a, b, 1.0)).abs().max_element() < 1e-6, "{c}");
        }
        let (wi, wo) = table.directions(3, 5, 7);
        assert!((table.eval(wi, wo) - table.cell(3, 5, 7)).length() < 1e-6);
    }

    #[test]
    fn the_pole_is_no_edge() {
        // Odd across the normal in the plane of incidence: 0 there by symmetry, whichever side the table is read from.
        let table = TabulatedBrdf::from_fn(9, 12, |wi, wo| DVec3::splat(wi.x * wo.x + wi.y * wo.y)).unwrap();
        for azimuth in [0.0, 1.0, 3.0] {
            // The azimuth cells nearest to 0 and pi are a half cell off: f32 and nothing else remains.
            assert!(table.eval(spherical(0.7, 0.0), spherical(0.0, azimuth)).abs().max_element() < 1e-7);
        }
        let (near, pole) = (spherical(1e-3, 0.3), spherical(0.0, 0.0));
        // Continuous: a thousandth of a radian times a slope below 1.
        assert!(
            (table.eval(near, spherical(0.7, 0.0)) - table.eval(pole, spherical(0.7, 0.0))).length() < 2e-3
        );
    }

    #[test]
    fn bad_tables_are_refused() {
        assert!(TabulatedBrdf::new(2, 2, vec![[0.0; 3]; 7]).is_err());
        assert!(TabulatedBrdf::new(1, 2, vec![[0.0; 3]; 2]).is_err());
        let mut values = vec![[0.0; 3]; 8];
        values[5][1] = f32::INFINITY;
        let message = TabulatedBrdf::new(2, 2, values).unwrap_err().to_string();
        assert!(message.contains("theta_in 1, theta_out 0, phi 1"), "{message}");
    }
}

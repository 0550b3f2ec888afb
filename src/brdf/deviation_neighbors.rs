//! A measurement in the plane of incidence as a BRDF of all directions, without a model: what Pranovich et al. 2024 compare theirs
//! with (Fig. 5, Table 1), a "filtered averaging of the measurements based on the four nearest neighbours in projected deviation
//! vector coordinates".
//!
//! The projected deviation vector (Tongbuasirilai, Unger & Kurt 2017) leads from the mirror direction to the eye, both projected
//! onto the surface: `d = P(wo) - P(mirrored wi) = P(wo) + P(wi)`. A BRDF that is isotropic and symmetric about it depends on the
//! length |d| and on where the mirror direction is, and the plane of incidence holds all such pairs. Here the place is the middle of
//! the deviation, `m = (P(wo) - P(wi)) / 2`, in place of the mirror direction itself: the coordinates
//! `(|m|, |d|)` do not change when light and eye are exchanged, so that the result is reciprocal; light mirrored at theta is at
//! `(sin theta, 0)` in both. In the plane the sines of the two polar angles, signed, are `|m| +- |d| / 2`: only a pair and its
//! reverse share a point, so that nothing measured is mixed with anything else.
//!
//! The paper names neither its metric nor its filter. Here they are the Euclidean one (to weigh |d| 2 to 8 times, because lobes are
//! narrow, gains nothing on a synthetic ink) and the inverse squared distance (Shepard 1968).
//! Neighbors change from one pair to the next, and with them the result jumps a little.

use super::Goniospectra;
use crate::error::{Error, Result};
use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use std::num::NonZero;

/// Neighbors that are averaged.
const NEIGHBORS: NonZero<usize> = NonZero::<usize>::MIN.saturating_add(3);
/// Distance below which geometries are the same: far above rounding, far below the step of any goniometer.
const SAME: f64 = 1e-9;

/// A measurement, ready to be looked up.
#[derive(Debug)]
pub struct DeviationNeighbors {
    tree: ImmutableKdTree<f64, 2>,
    bands: usize,
    /// BRDF, geometry after geometry, wavelength after wavelength.
    values: Vec<f64>,
}

impl DeviationNeighbors {
    /// Prepares a measurement for look-ups.
    ///
    /// # Errors
    /// Geometries that no tree can hold; none that a measurement has.
    pub fn new(measurement: &Goniospectra) -> Result<Self> {
        let places: Vec<[f64; 2]> = (measurement.spectra().iter())
            .map(|row| {
                let (wi, wo) = row.reading.directions();
                coordinates(wi, wo)
            })
            .collect();
        let tree = ImmutableKdTree::new_from_slice(&places).map_err(|e| {
            Error::invalid("measurement", "geometries", format!("{e:?}"), "one or more, finite")
        })?;
        let values = measurement.spectra().iter().flat_map(|row| row.mean.iter().copied()).collect();
        Ok(Self { tree, bands: measurement.wavelengths().len(), values })
    }

    /// BRDF, 1/sr, a value a wavelength of the measurement, for unit directions; 0 unless both are above the horizon.
    ///
    /// At a measured geometry it is what was measured there; where the reverse was measured too, the mean of both.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> Vec<f64> {
        let mut sum = vec![0.0; self.bands];
        if !(wi.z > 0.0 && wo.z > 0.0) {
            return sum;
        }
        let found =
            self.tree.query(&coordinates(wi, wo)).nearest_n::<SquaredEuclidean<f64>>(NEIGHBORS).execute();
        // The sum must not depend on the order in which a tree gives equal distances.
        let mut found: Vec<(f64, usize)> =
            found.into_iter().map(|entry| (entry.distance, entry.item as usize)).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut total = 0.0;
        for (squared, k) in found {
            let weight = 1.0 / (squared + SAME * SAME);
            let values = &self.values[k * self.bands..(k + 1) * self.bands];
            sum.iter_mut().zip(values).for_each(|(s, v)| *s += weight * v);
            total += weight;
        }
        sum.iter_mut().for_each(|s| *s /= total);
        sum
    }
}

/// |m| and |d|.
fn coordinates(wi: DVec3, wo: DVec3) -> [f64; 2] {
    let (light, eye) = (wi.truncate(), wo.truncate());
    [0.5 * (eye - light).length(), (eye + light).length()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::goniochromatic::Goniochromatic;
    use crate::brdf::instrument::Reading;
    use crate::brdf::{Bands, BrdfSample, LobeGeometry, SampleSet};
    use crate::math::half_difference::spherical;
    use std::f64::consts::PI;

    const INK: [Goniochromatic; 2] = [
        Goniochromatic { roughness: 0.19, reflectance: 0.5, growth: 2.0 },
        Goniochromatic { roughness: 0.19, reflectance: 0.1, growth: 5.0 },
    ];

    fn ink(wi: DVec3, wo: DVec3) -> Vec<f64> {
        INK.iter().map(|band| band.eval(&LobeGeometry::of(wi, wo))).collect()
    }

    /// The ink, measured as in the paper.
    fn measurement(incidences: &[f64]) -> Goniospectra {
        let mut set = SampleSet::new(Bands::Wavelengths(vec![450.0, 600.0])).unwrap();
        for incidence in incidences {
            for exit in (-80..=80).map(f64::from).filter(|exit| exit + incidence >= 20.0) {
                let (wi, wo) = Reading::between(*incidence, exit).unwrap().directions();
                set.push(BrdfSample::new(wi, wo, 1.0), &ink(wi, wo)).unwrap();
            }
        }
        Goniospectra::new(&set).unwrap()
    }

    const PAPER: [f64; 7] = [20.0, 30.0, 40.0, 50.0, 60.0, 65.0, 70.0];

    #[test]
    fn measured_geometries_come_back() {
        let measured = measurement(&PAPER);
        let neighbors = DeviationNeighbors::new(&measured).unwrap();
        for row in measured.spectra() {
            let (wi, wo) = row.reading.directions();
            for (found, expected) in neighbors.eval(wi, wo).iter().zip(&row.mean) {
                // The next geometry is half a degree off at least, whose weight is 1e-14 of this one's; the reverse is as high.
                assert!((found / expected - 1.0).abs() < 1e-10, "{:?}: {found} {expected}", row.reading);
            }
        }
    }

    #[test]
    fn a_pair_and_its_reverse_are_averaged() {
        let mut set = SampleSet::new(Bands::Wavelengths(vec![500.0])).unwrap();
        for (incidence, exit, value) in [(20.0, 40.0, 1.0), (40.0, 20.0, 2.0), (30.0, 0.0, 9.0)] {
            let (wi, wo) = Reading::between(incidence, exit).unwrap().directions();
            set.push(BrdfSample::new(wi, wo, 1.0), &[value]).unwrap();
        }
        let neighbors = DeviationNeighbors::new(&Goniospectra::new(&set).unwrap()).unwrap();
        let (wi, wo) = Reading::between(40.0, 20.0).unwrap().directions();
        assert!((neighbors.eval(wi, wo)[0] - 1.5).abs() < 1e-12);
    }

    #[test]
    fn it_is_reciprocal_isotropic_and_finite_everywhere() {
        let measured = measurement(&[20.0, 45.0]);
        let neighbors = DeviationNeighbors::new(&measured).unwrap();
        let largest = measured.spectra().iter().flat_map(|row| row.mean.clone()).fold(0.0, f64::max);
        let polar = [0.0, 1e-9, 0.3, 1.0, PI / 2.0 - 1e-9];
        for (a, b, phi) in
            polar.iter().flat_map(|a| polar.iter().flat_map(|b| [0.0, 1.0, PI].map(|phi| (*a, *b, phi))))
        {
            let (wi, wo) = (spherical(a, 0.4), spherical(b, 0.4 + phi));
            let f = neighbors.eval(wi, wo);
            assert!(f.iter().all(|f| (0.0..=largest * (1.0 + 1e-12)).contains(f)), "{a} {b} {phi}: {f:?}");
            assert_eq!(f, neighbors.eval(wo, wi));
        }
        let up = spherical(0.3, 0.0);
        assert_eq!(neighbors.eval(-up, up), [0.0, 0.0]);
        assert_eq!(neighbors.eval(up, DVec3::X), [0.0, 0.0]);
        // Turned about the normal, off the places where neighbors change.
        let turned = |phi: f64| neighbors.eval(spherical(0.71, phi), spherical(0.52, phi + 2.9));
        for (a, b) in turned(0.0).iter().zip(turned(2.0)) {
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }

    /// Root mean square error between the measured geometries, over the height of the peak.
    fn error(step: usize) -> f64 {
        let incidences: Vec<f64> = (20..=70).step_by(step).map(f64::from).collect();
        let neighbors = DeviationNeighbors::new(&measurement(&incidences)).unwrap();
        let (mut squares, mut count) = (0.0f64, 0);
        for incidence in (21..69).map(f64::from) {
            for exit in (-20..70).map(f64::from) {
                let (wi, wo) = Reading::between(incidence, exit + 0.5).unwrap().directions();
                let (found, expected) = (neighbors.eval(wi, wo), ink(wi, wo));
                let peak = ink(wi, DVec3::new(-wi.x, -wi.y, wi.z));
                for k in 0..2 {
                    squares += ((found[k] - expected[k]) / peak[k]).powi(2);
                    count += 1;
                }
            }
        }
        (squares / f64::from(count)).sqrt()
    }

    /// Neighbors at a distance cost a share of it: with twice the incidences half the error, but for the steps of the exit angle.
    #[test]
    fn denser_measurements_come_nearer_to_the_ink() {
        let errors = [10, 5].map(error);
        assert!(errors[1] < 0.6 * errors[0], "{errors:?}");
        // The ink of c = 5 grows by 5 sin(45 deg) times a fourth of the step, 2.5 degrees, a mean distance: 0.15; near the
        // peak, a third of the geometries, and in one band of two.
        assert!(errors[0] < 0.15 * (1.0f64 / 6.0).sqrt(), "{errors:?}");
    }
}

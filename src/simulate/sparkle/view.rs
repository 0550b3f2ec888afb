//! The sparkles of a paint for one light and one eye: how many, how bright, and the statistics of a pixel.

use super::count::{CountLaw, CountRule};
use super::geometry::SparkleGeometry;
use crate::color::{BANDS, Illuminant, Spectrum};
use crate::simulate::optics::film_optics::{FilmView, KindOptics, PaintOptics, mean_attenuation};
use crate::simulate::optics::flake_areas::FlakeAreas;
use crate::simulate::optics::flake_optics::FlakeOptics;
use crate::simulate::synthesis::flakes::class;
use glam::DVec3;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use std::sync::OnceLock;

/// What flakes above a flake do to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Masking {
    /// They dim it: the number of sparkles does not depend on depth (1999, eq. 5, "with masking"; 2001).
    #[default]
    Dimmed,
    /// They hide it or do not: fewer sparkles, of full brightness (1999, eq. 6, "without masking"). The same mean; a larger
    /// variance. Hiding knows no wavelength: numbers go by the mean luminance, and brightness takes the rest.
    Hidden,
}

/// Sparkles for one pair of directions.
#[derive(Debug, Clone)]
pub struct SparkleView<'a> {
    kinds: Vec<KindSparkles<'a>>,
    rule: CountRule,
    mean: [f64; BANDS],
}

/// Sparkles of one kind of flakes in one film.
#[derive(Debug, Clone)]
pub struct KindSparkles<'a> {
    /// Mean number per square micrometre of paint.
    pub density: f64,
    /// Luminance over the illuminance of the surface times the footprint's area, micrometres^2/sr, of a flake of mean area and
    /// mean reflectance at the top of its film.
    pub brightness: [f64; BANDS],
    /// Optical thickness of the film along both rays, over which a depth is uniformly distributed.
    pub thickness: [f64; BANDS],
    /// Areas of the flakes.
    pub areas: FlakeAreas,
    optics: &'a FlakeOptics,
    cos_alpha: f64,
    /// Brightness of each class of equal flakes over the mean, made when a sparkle asks: most pixels have none.
    colors: OnceLock<Vec<[f64; BANDS]>>,
}

/// More sparkles than this are drawn as what they tend to, a normal deviate for a kind and pixel.
const MANY: f64 = 4096.0;

impl<'a> KindSparkles<'a> {
    fn new(
        kind: &'a KindOptics,
        probability: f64,
        sparkle: &SparkleGeometry,
        seen: &FilmView,
        masking: Masking,
    ) -> Self {
        let flakes = kind.area_density / kind.areas.mean_um2;
        let luminance = sparkle.luminance(1.0, kind.areas.mean_um2);
        let bright = kind.reflectance(sparkle.geometry.cos_alpha).map(|r| r * luminance);
        let mut new = Self {
            density: flakes * probability,
            brightness: bright,
            thickness: seen.thickness,
            areas: kind.areas,
            optics: &kind.optics,
            cos_alpha: sparkle.geometry.cos_alpha,
            colors: OnceLock::new(),
        };
        match masking {
            Masking::Dimmed => {
                new.brightness.iter_mut().zip(&seen.above).for_each(|(b, above)| *b *= (-above).exp());
            }
            Masking::Hidden => {
                let share: [f64; BANDS] =
                    std::array::from_fn(|k| (-seen.above[k]).exp() * mean_attenuation(seen.thickness[k]));
                let gray = luminance_mean(&share);
                new.density *= gray;
                new.thickness = [0.0; BANDS];
                if gray > 0.0 {
                    new.brightness.iter_mut().zip(share).for_each(|(b, share)| *b *= share / gray);
                }
            }
        }
        new
    }

    fn add_mean(&self, sum: &mut [f64; BANDS]) {
        for (k, s) in sum.iter_mut().enumerate() {
            *s += self.density * self.brightness[k] * mean_attenuation(self.thickness[k]);
        }
    }

    /// Reflectance of each class of flakes over the mean, whose own mean is 1.
    fn colors(&self) -> &[[f64; BANDS]] {
        self.colors.get_or_init(|| {
            let weights = self.optics.class_weights();
            if weights.len() == 1 {
                return vec![[1.0; BANDS]];
            }
            let mut classes = self.optics.class_reflectances(self.cos_alpha);
            for k in 0..BANDS {
                let mean: f64 = weights.iter().zip(&classes).map(|(w, r)| w * r[k]).sum();
                // Where no class mirrors, neither does the mean.
                classes.iter_mut().for_each(|r| r[k] = if mean > 0.0 { r[k] / mean } else { 1.0 });
            }
            classes
        })
    }

    /// Variance of a pixel of area 1 with Poisson counts: the mean square of a sparkle, over area, depth and class.
    fn add_variance(&self, sum: &mut [f64; BANDS]) {
        let square = self.density * self.areas.mean_square();
        let classes = || self.optics.class_weights().iter().zip(self.colors());
        for (k, s) in sum.iter_mut().enumerate() {
            let color: f64 = classes().map(|(w, color)| w * color[k] * color[k]).sum();
            *s += square * color * self.brightness[k].powi(2) * mean_attenuation(2.0 * self.thickness[k]);
        }
    }

    /// Adds what one sparkle shows, times the area of the pixel.
    fn add_sparkle(&self, rng: &mut impl rand::Rng, sum: &mut [f64; BANDS]) {
        let area = self.areas.sample(rng);
        let depth: f64 = rng.random();
        let color = self.colors()[class(self.optics.class_weights(), rng.random())];
        for (k, s) in sum.iter_mut().enumerate() {
            *s += area * color[k] * self.brightness[k] * (-self.thickness[k] * depth).exp();
        }
    }

    /// Adds what a Poisson number of sparkles of a pixel show, times its area.
    fn add_sample(&self, area_um2: f64, rng: &mut impl rand::Rng, sum: &mut [f64; BANDS]) {
        let law = CountLaw { mean: self.density * area_um2, rule: CountRule::Poisson };
        if law.mean > MANY {
            let (mut mean, mut variance) = ([0.0; BANDS], [0.0; BANDS]);
            self.add_mean(&mut mean);
            self.add_variance(&mut variance);
            let normal: f64 = StandardNormal.sample(rng);
            for (k, s) in sum.iter_mut().enumerate() {
                *s += area_um2 * mean[k] + normal * (area_um2 * variance[k]).sqrt();
            }
            return;
        }
        for _ in 0..law.sample(rng) {
            self.add_sparkle(rng, sum);
        }
    }
}

impl<'a> SparkleView<'a> {
    /// Sparkles for unit directions `wi` and `wo` away from the surface and a light of angular radius `light_radius`,
    /// radians; none unless both are above the horizon.
    pub fn new(optics: &'a PaintOptics, wi: DVec3, wo: DVec3, light_radius: f64, masking: Masking) -> Self {
        Self::collect(optics, light_radius, masking, CountRule::Poisson, |add| {
            optics.visit_with(
                wi,
                wo,
                |k, g| optics.films[k].optical_thickness(g),
                |k, seen| {
                    let film = &optics.films[k];
                    for kind in &film.kinds {
                        add(film.index, kind, kind.orientation.density(seen.geometry.beta), seen);
                    }
                },
            );
        })
    }

    /// Sparkles of all kinds that `visit` hands to the function it is given, each with the index of its film, P(beta), 1/sr,
    /// and what the directions find in the film.
    pub(super) fn collect(
        optics: &'a PaintOptics,
        light_radius: f64,
        masking: Masking,
        rule: CountRule,
        visit: impl FnOnce(&mut dyn FnMut(f64, &'a KindOptics, f64, &FilmView)),
    ) -> Self {
        let mut kinds = Vec::with_capacity(optics.films.iter().map(|film| film.kinds.len()).sum());
        visit(&mut |index, kind, density, seen| {
            let sparkle = SparkleGeometry {
                geometry: seen.geometry,
                index,
                transmission: seen.transmission,
                light_radius,
            };
            let probability = density * sparkle.normals();
            // No light, no sparkles: a luminance without limit times none of them.
            if probability > 0.0 {
                kinds.push(KindSparkles::new(kind, probability, &sparkle, seen, masking));
            }
        });
        let mut mean = [0.0; BANDS];
        kinds.iter().for_each(|kind| kind.add_mean(&mut mean));
        Self { kinds, rule, mean }
    }

    /// The kinds of flakes that can sparkle here, topmost film first.
    pub fn kinds(&self) -> &[KindSparkles<'a>] {
        &self.kinds
    }

    /// Mean number of sparkles in a pixel of `area_um2`.
    pub fn mean_count(&self, area_um2: f64) -> f64 {
        area_um2 * self.kinds.iter().map(|kind| kind.density).sum::<f64>()
    }

    /// Law of the number of sparkles, of all kinds together, in a pixel of `area_um2`: that of [`SparkleView::sample`] and
    /// [`SparkleView::variance`].
    pub fn count_law(&self, area_um2: f64) -> CountLaw {
        CountLaw { mean: self.mean_count(area_um2), rule: self.rule }
    }

    /// Mean luminance over illuminance of any pixel, 1/sr: the BRDF of eq. 36.
    pub fn mean(&self) -> Spectrum {
        Spectrum(self.mean)
    }

    /// Variance of the luminance over illuminance of a pixel of `area_um2`, 1/sr^2.
    pub fn variance(&self, area_um2: f64) -> Spectrum {
        let mut sum = [0.0; BANDS];
        self.kinds.iter().for_each(|kind| kind.add_variance(&mut sum));
        // With Poisson counts; with one sparkle or none they are the mean square.
        let below = if self.count_law(area_um2).takes_shortcut() { self.mean } else { [0.0; BANDS] };
        Spectrum(std::array::from_fn(|k| sum[k] / area_um2 - below[k] * below[k]))
    }

    /// The luminance over illuminance of a pixel of `area_um2`, 1/sr, drawn at random.
    pub fn sample(&self, area_um2: f64, rng: &mut impl rand::Rng) -> Spectrum {
        let mut sum = [0.0; BANDS];
        let law = self.count_law(area_um2);
        if !law.takes_shortcut() {
            // A Poisson number split among kinds is one of each.
            self.kinds.iter().for_each(|kind| kind.add_sample(area_um2, rng, &mut sum));
        } else if law.sample(rng) > 0 {
            let shares: Vec<f64> = self.kinds.iter().map(|k| k.density * area_um2 / law.mean).collect();
            self.kinds[class(&shares, rng.random())].add_sparkle(rng, &mut sum);
        }
        Spectrum(sum.map(|s| s / area_um2))
    }
}

/// Luminance of a spectrum over that of a white one.
fn luminance_mean(spectrum: &[f64; BANDS]) -> f64 {
    Spectrum(*spectrum).xyz(&Illuminant::D65.spectrum()).y
}

//! Sparkles for a renderer: a paint's tables, made once, and the sparkles of a pixel.

use super::count::CountRule;
use super::light::Arrival;
use super::table::CosineTable;
use super::view::{Masking, SparkleView};
use crate::color::BANDS;
use crate::math::hash::pcg4d;
use crate::simulate::optics::film_optics::PaintOptics;
use glam::DVec3;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// Steps of the table of P.
const DENSITY_STEPS: usize = 4096;
/// Steps of the table of extinction.
const EXTINCTION_STEPS: usize = 512;

/// Sparkles of a paint.
#[derive(Debug, Clone)]
pub struct SparkleModel<'a> {
    optics: &'a PaintOptics,
    films: Vec<FilmTables>,
    /// What flakes above a flake do to it.
    pub masking: Masking,
    /// How numbers are drawn.
    pub counts: CountRule,
}

/// Tables of one film.
#[derive(Debug, Clone)]
struct FilmTables {
    /// `tau h cos` over the cosine inside the film.
    extinction: CosineTable<BANDS>,
    /// P of each kind over cos(beta); none for measured tilts, whose P is a look-up by itself and no exponential, which even
    /// steps would miss by any factor next to a knot.
    densities: Vec<Option<CosineTable<1>>>,
}

/// A pixel and what it sees of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// Column and row.
    pub place: [u32; 2],
    /// Area of the footprint on the surface, square micrometres, above 0.
    pub area_um2: f64,
}

/// Radiance of the sparkles of a pixel, linear RGB.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelSparkles {
    /// As drawn.
    pub drawn: DVec3,
    /// The mean of all draws.
    pub mean: DVec3,
}

impl PixelSparkles {
    /// What to add to a smooth radiance that holds the mean; its own mean is 0.
    pub fn fluctuation(&self) -> DVec3 {
        self.drawn - self.mean
    }
}

impl<'a> SparkleModel<'a> {
    /// Tables for a paint, in some 10 ms a film.
    pub fn new(optics: &'a PaintOptics) -> Self {
        let films = optics.films.iter().map(|film| {
            // The flattest ray that refracts into the film.
            let low = (1.0 - film.index.powi(-2)).max(0.0).sqrt();
            let extinction = CosineTable::new(low, EXTINCTION_STEPS, |cosine| {
                film.extinction(cosine.clamp(0.0, 1.0).acos())
            });
            let densities = film.kinds.iter().map(|kind| {
                let ends = kind.orientation.breaks();
                (!kind.orientation.is_tabulated()).then(|| {
                    CosineTable::new(ends[ends.len() - 1].cos(), DENSITY_STEPS, |cosine| {
                        [kind.orientation.density(cosine.clamp(-1.0, 1.0).acos())]
                    })
                })
            });
            FilmTables { extinction, densities: densities.collect() }
        });
        Self { optics, films: films.collect(), masking: Masking::default(), counts: CountRule::default() }
    }

    /// [`SparkleView::new`] by the tables: P of Gaussian tilts within 2e-5 of its value and of measured tilts exact,
    /// extinction within 1e-5 of its largest.
    pub fn view(&self, wi: DVec3, wo: DVec3, light_radius: f64) -> SparkleView<'a> {
        SparkleView::collect(self.optics, light_radius, self.masking, self.counts, |add| {
            self.optics.visit_with(
                wi,
                wo,
                |k, g| {
                    let [down, up] = g.cos_inside.map(|cosine| self.films[k].extinction.at(cosine));
                    std::array::from_fn(|b| down[b] / g.cos_inside[0] + up[b] / g.cos_inside[1])
                },
                |k, seen| {
                    let film = &self.optics.films[k];
                    for (kind, table) in film.kinds.iter().zip(&self.films[k].densities) {
                        let density = match table {
                            Some(table) => table.at_or_zero(seen.geometry.half.z)[0],
                            None => kind.orientation.density(seen.geometry.beta),
                        };
                        add(film.index, kind, density, seen);
                    }
                },
            );
        })
    }

    /// The sparkles of a pixel under all lights together, in the surface's frame: `wo` towards the eye and the lights'
    /// directions, unit, away from the surface. Radiance at the surface: what dims it on the way to the eye comes on top
    /// ([`super::light::Medium::transmittance`]).
    ///
    /// The draw depends on seed, pixel and the number of the light in the list, on nothing else. Lights are independent of
    /// each other: different flakes mirror them.
    pub fn pixel(&self, pixel: &Pixel, seed: u64, wo: DVec3, lights: &[Arrival]) -> PixelSparkles {
        let mut sum = PixelSparkles::default();
        for (number, light) in lights.iter().enumerate() {
            let view = self.view(light.direction, wo, light.radius);
            let illuminance = light.irradiance * light.direction.z.max(0.0);
            let drawn = view.sample(pixel.area_um2, &mut generator(seed, pixel.place, number as u32));
            sum.drawn += illuminance * drawn.linear_rgb();
            sum.mean += illuminance * view.mean().linear_rgb();
        }
        sum
    }
}

/// Random numbers of one light in one pixel.
fn generator(seed: u64, place: [u32; 2], light: u32) -> Pcg64 {
    let [a, b, c, _] = pcg4d([seed as u32, (seed >> 32) as u32, place[0], place[1]]);
    let [d, e, ..] = pcg4d([a, b, c, light]);
    Pcg64::seed_from_u64(u64::from(d) << 32 | u64::from(e))
}

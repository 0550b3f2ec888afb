//! What a camera receives: the panel under one flash, linear.
//!
//! With a flash of L points of intensity 1/L each, all distances finite, a place p of the panel sends
//! `[rest(wi, wo) + flakes] E + (1/L) sum_l g(wi_l, wo) cos_l / r_l^2`, `E = (1/L) sum_l cos_l / r_l^2`, towards the eye: substrate
//! and everything scattered more than once (the rest) and every single flake under light from the middle of the window, which
//! spans half a degree, the gloss g of a rough surface under every point. A mirror shows the window itself, as an even
//! rectangle of the same light: `F(wo)` of its radiance. A pixel is the mean over its square, flakes and mirror exactly.

use super::leds::{gray_field, leds};
use super::stand::{Stand, flash_energy};
use super::{DomeOptions, Truth};
use crate::brdf::fresnel::dielectric;
use crate::error::Result;
use crate::math::hash::pcg4d;
use crate::math::projection::Pose;
use crate::measure::{Images, PairGeometry, Pairs, Picture, Rig, Shot};
use crate::simulate::{LitFlake, Model, Panel};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Distance of the places at which the smooth part is evaluated, millimetres, at most: 0.09 degrees of direction at 650 mm.
const NODE_MM: f64 = 1.0;
/// Nodes a width of the gloss.
const NODES_A_GLOSS: f64 = 8.0;
/// Places along the side of a pixel at which a mirror is looked into.
const MIRROR_PLACES: usize = 4;

/// A panel in a dome.
pub struct Dome<'a> {
    options: DomeOptions,
    stand: Stand,
    panel: Panel<'a>,
}

impl<'a> Dome<'a> {
    /// Puts a panel of the model's paint into a dome.
    ///
    /// # Errors
    /// As [`Stand::new`] and [`Panel::new`].
    pub fn new(model: &'a Model, options: &DomeOptions) -> Result<Self> {
        let stand = Stand::new(options)?;
        let panel = Panel::new(model, options.sample_mm, options.seed)?;
        Ok(Self { options: options.clone(), stand, panel })
    }

    /// What stands where.
    pub fn options(&self) -> &DomeOptions {
        &self.options
    }

    /// What calibration has to find.
    pub fn truth(&self) -> &Truth {
        &self.stand.truth
    }

    /// The paint of the panel.
    pub fn model(&self) -> &Model {
        self.panel.model()
    }

    /// Linear light in the pixels of a camera under a nominal flash, row-major; the perfect diffuser under the flash straight
    /// above gives 1.
    pub fn radiance(&self, camera: usize, light: usize) -> Vec<[f64; 3]> {
        let scale = PI * self.options.radius_mm.powi(2);
        self.unit_radiance(camera, light).iter().map(|rgb| (*rgb * scale).to_array()).collect()
    }

    /// The same per unit intensity of the flash, 1/mm^2.
    fn unit_radiance(&self, camera: usize, light: usize) -> Vec<DVec3> {
        let seen = Seen::new(self, camera, light);
        let mut canvas = Canvas::new(self.options.image_px);
        seen.smooth(self, &mut canvas);
        seen.flakes(self, &mut canvas);
        seen.mirror(self, &mut canvas);
        canvas.pixels
    }

    /// All exposures of a pair.
    pub fn pair(&self, camera: usize, light: usize) -> Vec<Picture> {
        let radiance = Dome::radiance(self, camera, light);
        (0..self.stand.rig.exposures.len()).map(|e| self.expose_pair(&radiance, camera, light, e)).collect()
    }

    fn expose_pair(&self, radiance: &[[f64; 3]], camera: usize, light: usize, exposure: usize) -> Picture {
        let setting = self.stand.rig.exposures[exposure];
        let energy = flash_energy(&self.options, [camera, light, exposure]);
        let color = self.stand.truth.flash_color[light];
        let factor = color.map(|c| c * self.options.white * setting.relative * energy);
        let light_of = |rgb: &[f64; 3]| [0, 1, 2].map(|c| rgb[c] * factor[c]);
        let linear: Vec<[f64; 3]> = radiance.iter().map(light_of).collect();
        self.expose(&linear, camera, setting.iso, Shot::Pair { camera, light, exposure })
    }

    fn expose(&self, linear: &[[f64; 3]], camera: usize, iso: u32, shot: Shot) -> Picture {
        let [a, b, c, d] = match shot {
            Shot::LedsWide { camera } => [camera, 0, 0, 1],
            Shot::LedsZoom { camera } => [camera, 0, 0, 2],
            Shot::Response { camera, step } => [camera, step, 0, 3],
            Shot::Pair { camera, light, exposure } => [camera, light, exposure, 4],
        };
        let [high, low, ..] = pcg4d([a as u32, (b * 64 + c) as u32, d as u32, self.options.seed as u32]);
        let seed = u64::from(high) << 32 | u64::from(low);
        let pixels = self.stand.truth.sensors[camera].expose(linear, iso, seed);
        Picture { size: self.options.image_px, pixels }
    }
}

/// The dome as a capture without files; pictures are made when they are asked for.
impl Images for Dome<'_> {
    fn rig(&self) -> &Rig {
        &self.stand.rig
    }

    fn picture(&self, shot: Shot) -> Result<Picture> {
        let (camera, linear) = match shot {
            Shot::LedsWide { camera } => (camera, leds(&self.options, &self.stand, camera, false)),
            Shot::LedsZoom { camera } => (camera, leds(&self.options, &self.stand, camera, true)),
            Shot::Response { camera, step } => (camera, gray_field(&self.options, &self.stand, step)),
            Shot::Pair { camera, light, exposure } => {
                return Ok(self.expose_pair(&Dome::radiance(self, camera, light), camera, light, exposure));
            }
        };
        Ok(self.expose(&linear, camera, 50, shot))
    }
}

/// What a measurement without any error of its own would have: true poses, light itself.
impl Pairs for Dome<'_> {
    fn cameras(&self) -> usize {
        self.stand.truth.cameras.len()
    }

    fn geometry(&self, camera: usize, light: usize) -> Option<PairGeometry> {
        let cameras = &self.stand.truth.cameras;
        Some(PairGeometry::new(*cameras.get(camera)?, &self.options.flash, &cameras.get(light)?.pose))
    }

    fn size(&self) -> [usize; 2] {
        self.options.image_px
    }

    fn radiance(&self, camera: usize, light: usize) -> Result<Vec<[f32; 3]>> {
        Ok(self.unit_radiance(camera, light).iter().map(|rgb| rgb.as_vec3().to_array()).collect())
    }
}

/// A camera and a light.
struct Seen {
    pair: PairGeometry,
    light: Pose,
}

/// Colors of pixels, per unit intensity of the flash.
struct Canvas {
    size: [usize; 2],
    pixels: Vec<DVec3>,
    cover: Vec<(u32, f32)>,
}

impl Seen {
    fn new(dome: &Dome, camera: usize, light: usize) -> Self {
        let cameras = &dome.stand.truth.cameras;
        let light = cameras[light].pose;
        Self { pair: PairGeometry::new(cameras[camera], &dome.options.flash, &light), light }
    }

    /// Substrate, light scattered more than once, gloss of a rough surface, and the white targets.
    fn smooth(&self, dome: &Dome, canvas: &mut Canvas) {
        let model = dome.model();
        let width = model.optics().roughness * dome.options.radius_mm;
        let step = if width > 0.0 { NODE_MM.min(width / NODES_A_GLOSS) } else { NODE_MM };
        let panel = Nodes::new(dome.options.sample_mm, step, |place| {
            let (wi, wo) = self.pair.rays(place);
            let rest = model.rest(wi, wo).linear_rgb() * self.pair.irradiance(place, |_| 1.0);
            rest + DVec3::splat(self.pair.irradiance(place, |wi| model.gloss(wi, wo)))
        });
        for k in 0..canvas.pixels.len() {
            let pixel = DVec2::new((k % canvas.size[0]) as f64 + 0.5, (k / canvas.size[0]) as f64 + 0.5);
            let Some(place) = self.pair.camera.on_plane(pixel, 0.0).map(DVec3::truncate) else { continue };
            canvas.pixels[k] = panel.at(place).unwrap_or_else(|| {
                let inside = |t: &&crate::measure::WhiteTarget| {
                    (place - DVec2::from(t.center_mm)).abs().max_element() <= 0.5 * t.side_mm
                };
                dome.options.white_targets.iter().find(inside).map_or(DVec3::ZERO, |target| {
                    DVec3::splat(target.reflectance / PI * self.pair.irradiance(place, |_| 1.0))
                })
            });
        }
    }

    fn flakes(&self, dome: &Dome, canvas: &mut Canvas) {
        let size = dome.options.sample_mm;
        let irradiance =
            Nodes::new(size, NODE_MM, |place| DVec3::splat(self.pair.irradiance(place, |_| 1.0)));
        let pixels = Nodes::new(size, NODE_MM, |place| DVec3::splat(self.pixels_a_square_mm(place)));
        let draw = |flake: LitFlake| {
            let Some(at) = self.pair.camera.pixel(flake.place_mm.extend(0.0)) else { return };
            let (Some(light), Some(scale)) = (irradiance.near(flake.place_mm), pixels.near(flake.place_mm))
            else {
                return;
            };
            canvas.add_disc(at, flake.area_mm2 * scale.x, flake.color * light.x);
        };
        dome.panel.flakes(|place| self.pair.rays(place), draw);
    }

    /// Pixels that a square millimetre of the plane fills at a place.
    fn pixels_a_square_mm(&self, place: DVec2) -> f64 {
        let at = |offset: DVec2| self.pair.camera.pixel((place + offset).extend(0.0)).unwrap_or_default();
        let half = 0.05;
        let x = at(DVec2::X * half) - at(DVec2::X * -half);
        let y = at(DVec2::Y * half) - at(DVec2::Y * -half);
        x.perp_dot(y).abs() / (2.0 * half * 2.0 * half)
    }

    /// The flash, mirrored by a smooth surface.
    fn mirror(&self, dome: &Dome, canvas: &mut Canvas) {
        let (model, flash) = (dome.model(), &dome.options.flash);
        if model.coat().mirror == 0.0 {
            return;
        }
        let index = model.optics().top().index;
        let half = 0.5 * DVec2::from(flash.size_mm);
        let window = |place: DVec3| {
            let wo = (self.pair.eye_mm() - place).normalize();
            let mirrored = self.light.rotation * DVec3::new(-wo.x, -wo.y, wo.z);
            let from = self.light.local(place);
            let hit = (from - mirrored * (from.z / mirrored.z)).truncate() - DVec2::from(flash.offset_mm);
            let sees = mirrored.z < 0.0 && hit.abs().cmple(half).all();
            let area = flash.size_mm[0] * flash.size_mm[1] * mirrored.z.abs();
            if sees { dielectric(wo.z, index) / area } else { 0.0 }
        };
        let edge = 0.5 * DVec2::from(dome.options.sample_mm);
        let light = |pixel: DVec2| {
            let place =
                self.pair.camera.on_plane(pixel, 0.0).filter(|p| p.truncate().abs().cmple(edge).all());
            place.map_or(0.0, window)
        };
        let n = MIRROR_PLACES;
        for (row, column) in self.highlight(canvas.size) {
            let corner = DVec2::new(column as f64, row as f64);
            let at = |k: usize| corner + DVec2::new((k % n) as f64 + 0.5, (k / n) as f64 + 0.5) / n as f64;
            let mean = (0..n * n).map(|k| light(at(k))).sum::<f64>() / (n * n) as f64;
            canvas.pixels[row * canvas.size[0] + column] += DVec3::splat(mean);
        }
    }

    /// Rows and columns of the pixels that may see the mirrored window.
    fn highlight(&self, size: [usize; 2]) -> impl Iterator<Item = (usize, usize)> + use<> {
        let corners = self.pair.corners_mm.map(|corner| {
            let place = self.pair.mirrored_place(corner);
            self.pair.camera.pixel(place.extend(0.0)).unwrap_or(DVec2::splat(f64::INFINITY))
        });
        let range = |axis: usize| {
            let low = corners.iter().fold(f64::INFINITY, |m, c| m.min(c[axis]));
            let high = corners.iter().fold(f64::NEG_INFINITY, |m, c| m.max(c[axis]));
            let clamp = |x: f64| x.clamp(0.0, size[axis] as f64) as usize;
            clamp((low - 2.0).floor())..clamp((high + 2.0).ceil())
        };
        let (rows, columns) = (range(1), range(0));
        rows.flat_map(move |row| columns.clone().map(move |column| (row, column)))
    }
}

/// A smooth function over a rectangle about the origin, bilinear between nodes.
struct Nodes {
    size_mm: DVec2,
    count: [usize; 2],
    values: Vec<DVec3>,
}

impl Nodes {
    fn new(size_mm: [f64; 2], step_mm: f64, f: impl Fn(DVec2) -> DVec3) -> Self {
        let size = DVec2::from(size_mm);
        let count = size_mm.map(|side| (side / step_mm).ceil() as usize + 1);
        let place = |k: usize| {
            let share = DVec2::new((k % count[0]) as f64, (k / count[0]) as f64)
                / DVec2::new((count[0] - 1) as f64, (count[1] - 1) as f64);
            (share - 0.5) * size
        };
        Self { size_mm: size, count, values: (0..count[0] * count[1]).map(|k| f(place(k))).collect() }
    }

    /// The value at a place, unless it lies outside.
    fn at(&self, place: DVec2) -> Option<DVec3> {
        let inside = place.abs().cmple(0.5 * self.size_mm).all();
        inside.then(|| self.near(place)).flatten()
    }

    /// The value at a place, or at the edge next to it; `None` for what is no number.
    fn near(&self, place: DVec2) -> Option<DVec3> {
        let [columns, rows] = self.count;
        let last = DVec2::new((columns - 1) as f64, (rows - 1) as f64);
        let position = ((place / self.size_mm + 0.5) * last).clamp(DVec2::ZERO, last);
        if position.is_nan() {
            return None;
        }
        let [x, y] =
            [position.x.min(last.x - 1.0), position.y.min(last.y - 1.0)].map(|v| v.max(0.0) as usize);
        let [u, v] = [position.x - x as f64, position.y - y as f64];
        let value = |x: usize, y: usize| self.values[y * columns + x];
        let low = value(x, y).lerp(value(x + 1, y), u);
        Some(low.lerp(value(x, y + 1).lerp(value(x + 1, y + 1), u), v))
    }
}

impl Canvas {
    fn new(size: [usize; 2]) -> Self {
        Self { size, pixels: vec![DVec3::ZERO; size[0] * size[1]], cover: Vec::new() }
    }

    /// Adds a disc of an area, square pixels; one that reaches over the edge of the picture is left out.
    fn add_disc(&mut self, center: DVec2, area: f64, color: DVec3) {
        let radius = (area / PI).sqrt();
        let size = DVec2::new(self.size[0] as f64, self.size[1] as f64);
        if (center - radius).cmplt(DVec2::ZERO).any() || (center + radius).cmpge(size).any() {
            return;
        }
        let corner = center.floor();
        if (center - radius).cmpge(corner).all() && (center + radius).cmple(corner + 1.0).all() {
            self.pixels[corner.y as usize * self.size[0] + corner.x as usize] += color * area;
            return;
        }
        self.cover.clear();
        crate::simulate::synthesis::cover_disc(center.to_array(), radius, self.size, &mut self.cover);
        for (pixel, share) in &self.cover {
            self.pixels[*pixel as usize] += color * f64::from(*share);
        }
    }
}

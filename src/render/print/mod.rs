//! Soft proofs: halftoned prints with goniochromatic inks (Pranovich et al. 2024, "Printing application").
//!
//! A dot shows its ink, several dots under a pixel the mean of what each shows: reflectance is linear in their coverage. Light is
//! added up wavelength by wavelength and becomes linear Rec.709 by the observer's functions and the spectrum of the lamps
//! ([`PrintInks`]). Beneath all lies the [`Paper`].

mod inks;
mod look;
mod paper;

pub use inks::{InkBand, InkModel, PrintInks};
pub use look::{Bands, Look, own_inks};
pub use paper::Paper;

use super::image::{Options, Patch, Seen, Stage, sample_points};
use super::picture::Picture;
use super::shade::Geometry;
use crate::brdf::goniochromatic::ggx;
use crate::brdf::torrance_sparrow::smith_over_cosine;
use crate::color::luminance;
use crate::error::{Error, Result};
use crate::proof::Coverage;
use crate::scene::{DirectionalLight, Light, PointLight, Scene, SpotLight};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// What is printed, on what, with what.
#[derive(Debug, Clone, Copy)]
pub struct Print<'a> {
    /// The inks under the light of the scene.
    pub inks: &'a PrintInks,
    /// How much of every place each ink covers.
    pub coverage: &'a Coverage,
    /// What lies beneath.
    pub paper: Paper,
}

impl Print<'_> {
    /// BRDF where inks cover these shares of a place, linear Rec.709 of the light it was made for, 1/sr.
    pub fn reflectance(&self, covered: Vec3, wi: Vec3, wo: Vec3) -> Vec3 {
        self.inks.reflectance(covered, wi, wo) + self.inks.white * self.paper.reflectance(wi, wo)
    }
}

impl PrintInks {
    /// BRDF where inks cover these shares of a place, linear Rec.709, 1/sr; 0 below the horizon.
    pub fn reflectance(&self, covered: Vec3, wi: Vec3, wo: Vec3) -> Vec3 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return Vec3::ZERO;
        }
        let g = Geometry::of(wi, wo).lobe;
        let of_ink = |f: &dyn Fn(f32) -> f32| Vec3::from(self.roughness.to_array().map(f));
        let distribution = covered * of_ink(&|alpha| ggx(g.tan2_h, alpha));
        let shadowing =
            || of_ink(&|alpha| smith_over_cosine(g.cos_i, alpha) * smith_over_cosine(g.cos_o, alpha));
        match self.model {
            InkModel::Goniochromatic => self.goniochromatic(0.25 * distribution, &g),
            InkModel::Schlick => self.schlick(distribution * shadowing(), &g),
            InkModel::Exact => self.exact(distribution * shadowing(), &g),
        }
    }
}

/// Renders a print on all objects of a scene, as [`super::render()`] renders paints: linear Rec.709, not clamped. Lamps give the
/// power alone, by their luminance, and the light of the inks its color; surroundings are seen, but light nothing.
///
/// # Errors
/// An illegal scene or option; no lamp; no object that can be printed.
pub fn render_print(
    scene: &Scene,
    print: &Print,
    options: &Options,
    tick: &(dyn Fn() + Sync),
) -> Result<Picture> {
    render_print_rows(scene, print, options, 0..scene.size[1], tick)
}

/// Some rows of that picture, for who may not want the others any more.
///
/// # Errors
/// As [`render_print`]; rows that the scene has not.
pub fn render_print_rows(
    scene: &Scene,
    print: &Print,
    options: &Options,
    rows: Range<usize>,
    tick: &(dyn Fn() + Sync),
) -> Result<Picture> {
    let height = scene.size[1];
    if rows.start > rows.end || rows.end > height {
        return Err(Error::invalid("print", "rows", format!("{rows:?}"), format!("some of {height}")));
    }
    let reflecting =
        |covered: Vec3, wi: DVec3, wo: DVec3| print.reflectance(covered, wi.as_vec3(), wo.as_vec3());
    let stage = print_stage(scene, options)?;
    let covered = |patch: &Patch| {
        let place = stage.bodies.print_place(&patch.hit, patch.footprint.sides);
        place.map_or(Vec3::ZERO, |place| DVec3::from(print.coverage.sample(place.uv, place.sides)).as_vec3())
    };
    Ok(picture(&stage, |at| radiance(&stage, at, covered, reflecting), rows, tick))
}

/// The scene of a print, ready for rays.
///
/// # Errors
/// Those of [`render_print`].
pub(crate) fn print_stage<'a>(scene: &'a Scene, options: &'a Options) -> Result<Stage<'a>> {
    let stage = lit_stage(scene, options)?;
    if scene.lights.is_empty() {
        let legal = "one or more: prints are lit by lamps alone";
        return Err(Error::invalid("scene", "lamps", "none", legal));
    }
    if !stage.bodies.can_be_printed() {
        let legal = "an object that can be printed: a mesh with some, or another shape";
        return Err(Error::invalid("scene", "texture coordinates", "none", legal));
    }
    Ok(stage)
}

fn lit_stage<'a>(scene: &'a Scene, options: &'a Options) -> Result<Stage<'a>> {
    scene.validate()?;
    options.validate()?;
    Stage::new(scene, options)
}

/// What reflects: unit directions to light and eye in the frame of the surface; linear Rec.709, 1/sr.
pub type Reflecting<'a> = dyn Fn(DVec3, DVec3) -> Vec3 + Sync + 'a;

/// Renders a scene whose objects reflect its lamps by any function.
///
/// # Errors
/// An illegal scene or option.
pub fn render_lit(
    scene: &Scene,
    options: &Options,
    reflecting: &Reflecting,
    tick: &(dyn Fn() + Sync),
) -> Result<Picture> {
    let stage = lit_stage(scene, options)?;
    let seen = |at| radiance(&stage, at, |_| (), |(), wi, wo| reflecting(wi, wo));
    Ok(picture(&stage, seen, 0..scene.size[1], tick))
}

fn picture(
    stage: &Stage,
    radiance: impl Fn([f64; 2]) -> Vec3 + Sync,
    rows: Range<usize>,
    tick: &(dyn Fn() + Sync),
) -> Picture {
    let Stage { scene, options, .. } = stage;
    let width = scene.size[0];
    let mut pixels = vec![[0.0; 3]; width * rows.len()];
    pixels.par_chunks_mut(width).enumerate().for_each(|(k, row)| {
        let y = rows.start + k;
        for (x, pixel) in row.iter_mut().enumerate() {
            let samples = sample_points(x, y, options.samples).map(&radiance);
            *pixel = (samples.sum::<Vec3>() / options.samples as f32).to_array();
        }
        tick();
    });
    Picture { size: [width, rows.len()], pixels }
}

/// Radiance along a ray, from what a patch is made of and how that reflects.
fn radiance<T: Copy>(
    stage: &Stage,
    at: [f64; 2],
    material: impl Fn(&Patch) -> T,
    reflecting: impl Fn(T, DVec3, DVec3) -> Vec3,
) -> Vec3 {
    let patch = match stage.seen(at) {
        Seen::Paint(patch) => patch,
        Seen::Surroundings(direction) => return stage.seen_beyond(direction),
        Seen::Back => return Vec3::ZERO,
    };
    let (material, wo) = (material(&patch), patch.seen_from.as_dvec3());
    let lamps = stage.incidences(&patch).map(|lamp| {
        let wi = patch.to_surface * lamp.direction;
        let irradiance = luminance(lamp.irradiance) * wi.z.max(0.0);
        if irradiance > 0.0 { reflecting(material, wi, wo) * irradiance as f32 } else { Vec3::ZERO }
    });
    lamps.sum()
}

/// The scene with a dim lamp opposite to each of its lamps, of this share of its light: what shines through a sheet, about (the
/// paper, Figs 8, 9).
#[must_use]
pub fn lit_from_behind(mut scene: Scene, share: f64) -> Scene {
    let opposite = |v: [f64; 3]| v.map(|c| -c);
    let dim = |v: [f64; 3]| v.map(|c| c * share);
    let near = |lamp: PointLight| PointLight {
        position_mm: opposite(lamp.position_mm),
        irradiance: dim(lamp.irradiance),
        ..lamp
    };
    let behind: Vec<Light> = (scene.lights.iter())
        .map(|light| match *light {
            Light::Directional(light) => Light::Directional(DirectionalLight {
                direction: opposite(light.direction),
                irradiance: dim(light.irradiance),
                ..light
            }),
            Light::Point(light) => Light::Point(near(light)),
            Light::Spot(light) => Light::Spot(SpotLight {
                lamp: near(light.lamp),
                target_mm: opposite(light.target_mm),
                ..light
            }),
        })
        .collect();
    scene.lights.extend(behind);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::{Ink, LobeGeometry};
    use crate::color::{Illuminant, WHITE_XYZ, Wavelengths, bradford, rgb_from_xyz};
    use crate::math::half_difference::spherical;

    fn inks() -> Vec<Ink> {
        let grid = Wavelengths::even(41).unwrap();
        let ink = |name: &str, at: f64| {
            let wave = |k: usize| (-((k as f64 - at) / 6.0).powi(2)).exp();
            let rho = (0..41).map(|k| 0.05 + 0.8 * wave(k)).collect();
            let c = (0..41).map(|k| 3.0 - 4.0 * wave(k)).collect();
            Ink::new(name, 0.19, grid.clone(), rho, c).unwrap()
        };
        vec![ink("red", 26.0), ink("green", 15.0), ink("blue", 7.0)]
    }

    /// The f32 sum is the color of the f64 spectrum.
    #[test]
    fn an_ink_alone_has_the_color_of_its_spectrum() {
        let inks = inks();
        let to_rec_709 = bradford(Illuminant::D65.white(), WHITE_XYZ);
        for light in [Illuminant::D65.spectrum(), Illuminant::A.spectrum()] {
            let ready = PrintInks::new(&inks, InkModel::Goniochromatic, &light, false).unwrap();
            for (theta_i, theta_o, phi) in
                [(0.3, 0.3, 3.1), (0.9, 1.0, 3.0), (1.4, 0.2, 0.5), (0.0, 0.0, 0.0)]
            {
                let (wi, wo) = (spherical(theta_i, 0.0), spherical(theta_o, phi));
                for (k, ink) in inks.iter().enumerate() {
                    let xyz = ink.spectrum(&LobeGeometry::of(wi, wo)).xyz(&light);
                    let expected = rgb_from_xyz(to_rec_709 * xyz);
                    let found = ready.reflectance(Vec3::AXES[k], wi.as_vec3(), wo.as_vec3()).as_dvec3();
                    // Roundings of f32, of a narrow lobe's tangent, too.
                    assert!(found.distance(expected) < 3e-6 * expected.length() + 1e-7, "{found} {expected}");
                }
            }
        }
    }

    #[test]
    fn reflectance_is_linear_in_what_is_covered() {
        let light = Illuminant::D65.spectrum();
        for model in InkModel::ALL {
            let ready = PrintInks::new(&inks(), model, &light, true).unwrap();
            let (wi, wo) = (spherical(0.5, 0.0).as_vec3(), spherical(0.7, 3.0).as_vec3());
            let parts: Vec3 = Vec3::AXES.iter().map(|ink| ready.reflectance(*ink, wi, wo) * 0.25).sum();
            let whole = ready.reflectance(Vec3::splat(0.25), wi, wo);
            assert!(parts.distance(whole) < 1e-6 * whole.length(), "{model:?}");
            let swapped = ready.reflectance(Vec3::splat(0.25), wo, wi);
            assert!(swapped.distance(whole) < 1e-5 * whole.length(), "{model:?}");
            assert_eq!(ready.reflectance(Vec3::ONE, -wi, wo), Vec3::ZERO);
        }
    }

    #[test]
    fn adapted_white_is_white_under_every_light() {
        let inks = inks();
        for light in [Illuminant::D65.spectrum(), Illuminant::A.spectrum()] {
            let adapted = PrintInks::new(&inks, InkModel::Schlick, &light, true).unwrap().white;
            assert!(adapted.distance(Vec3::ONE) < 1e-5, "{adapted}");
        }
        let warm = PrintInks::new(&inks, InkModel::Schlick, &Illuminant::A.spectrum(), false).unwrap().white;
        assert!(warm.x > 1.5 && warm.z < 0.5, "{warm}");
    }

    #[test]
    fn lamps_behind_are_opposite_and_dim() {
        let lit = lit_from_behind(Scene::default(), 0.1);
        assert_eq!(lit.lights.len(), 2);
        let [front, back] = [0, 1].map(|k| lit.lights[k].at(DVec3::ZERO));
        assert!(front.direction.distance(-back.direction) < 1e-15);
        assert!((back.irradiance * 10.0).distance(front.irradiance) < 1e-12);
    }
}

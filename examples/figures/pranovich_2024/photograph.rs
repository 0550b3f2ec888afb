//! In place of the photograph of Fig. 8: a bent print on black paper beside a lamp, as the full simulation of each ink has it.
//!
//! Every place of the print shows its ink as simulated (read every five degrees, which takes seconds in place of minutes), and bare paper a dim diffuse gray. The paper lets some light through, diffusely,
//! which reaches the side that the lamp does not. None of the three is what a preview is made of: that has fitted inks, Phong's
//! highlight with single scattering for the paper, and a second lamp.

use super::inks::{Readings, fitted, measured, seen};
use super::prints::print;
use carpaint::color::{Illuminant, delta_e_2000, lab_from_rgb};
use carpaint::error::Result;
use carpaint::proof::Coverage;
use carpaint::render::{
    InkBand, InkModel, Options, Paper, Picture, Print, PrintInks, Reflecting, ToneMap, lit_from_behind,
    render_lit, render_print,
};
use carpaint::scene::{Camera, Environment, Light, PointLight, Scene, Shape};
use glam::{DVec3, Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;
use std::sync::{Arc, Mutex, PoisonError};

/// Reflectance of bare black paper.
const PAPER: f32 = 0.02;
/// Light that it lets through.
const TRANSMITTANCE: f32 = 0.02;
/// Directions do not change within a pixel: a ray each.
pub const OPTIONS: Options =
    Options { samples: 1, directions: 1, seed: 1, flakes: false, random: carpaint::render::Random::Hash };

/// A sheet bent by 115 degrees, lit from its left side, which its left half mirrors at some 40 degrees; the right half lies in its own
/// shadow.
pub fn scene() -> Scene {
    let lamp = PointLight { position_mm: [-230.0, -20.0, 50.0], irradiance: [3.0; 3], radius_mm: 4.0 };
    Scene {
        size: [480, 360],
        shape: Shape::Sheet { size_mm: [60.0, 45.0], radius_mm: 30.0 },
        camera: Camera { position_mm: [0.0, -220.0, 30.0], vertical_fov_deg: 14.0, ..Camera::default() },
        background: Some([0.0; 3]),
        environment: Environment::Constant { radiance: [0.0; 3] },
        lights: vec![Light::Point(lamp)],
        ..Scene::default()
    }
}

/// The scene with the lamp behind alone.
pub fn lit_through() -> Scene {
    let mut scene = lit_from_behind(scene(), 1.0);
    scene.lights.remove(0);
    scene
}

/// What a camera would see.
pub struct Photograph {
    pub picture: Picture,
    /// Exposure, stops.
    pub stops: f64,
    /// Pixels of the print that no light but that through the paper reaches.
    pub in_shadow: Vec<bool>,
    /// All pixels of the print.
    pub on_print: Vec<bool>,
}

impl Photograph {
    /// The photograph, taken once a run.
    pub fn taken() -> Result<Arc<Self>> {
        static DONE: Mutex<Option<Arc<Photograph>>> = Mutex::new(None);
        let mut done = DONE.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(photograph) = &*done {
            return Ok(photograph.clone());
        }
        let photograph = Arc::new(Self::new()?);
        *done = Some(photograph.clone());
        Ok(photograph)
    }

    fn new() -> Result<Self> {
        let (front, behind) = (scene(), lit_through());
        let lit = |scene: &Scene, f: &Reflecting| render_lit(scene, &OPTIONS, f, &|| ());
        let paper = lit(&front, &|_, _| Vec3::splat(PAPER * FRAC_1_PI))?;
        let through = lit(&behind, &|_, _| Vec3::splat(TRANSMITTANCE * FRAC_1_PI))?;
        let inks = measured()?;
        let inked = inks.iter().map(|of| {
            let read = Readings::every_five_degrees(of)?;
            lit(&front, &|wi, wo| read.color(wi, wo))
        });
        let inked = inked.collect::<Result<Vec<_>>>()?;
        let covered = covered()?;
        let vec = |picture: &Picture, k: usize| Vec3::from(picture.pixels[k]);
        let pixel = |k: usize| {
            let dots: Vec3 = (0..3).map(|c| covered[k][c] * vec(&inked[c], k)).sum();
            (dots + (1.0 - covered[k].element_sum()) * vec(&paper, k) + vec(&through, k)).to_array()
        };
        let size = front.size;
        let picture = Picture { size, pixels: (0..size[0] * size[1]).map(pixel).collect() };
        let is_lit = |picture: &Picture| picture.pixels.iter().map(|p| *p != [0.0; 3]).collect::<Vec<_>>();
        let (front, behind) = (is_lit(&paper), is_lit(&through));
        let in_shadow: Vec<bool> =
            front.iter().zip(&behind).map(|(front, behind)| *behind && !front).collect();
        let on_print = front.iter().zip(&behind).map(|(front, behind)| *front || *behind).collect();
        Ok(Self { stops: picture.exposure(Picture::WHITE_SHARE), picture, in_shadow, on_print })
    }

    /// Root mean square error of sRGB codes, 0 to 1, and mean Delta-E 2000, over these pixels.
    pub fn errors(&self, preview: &Picture, counts: &[bool]) -> [f64; 2] {
        let [a, b] = [&self.picture, preview].map(|picture| picture.encode(self.stops, &ToneMap::InGamut));
        let lab = |p: &[f32; 3]| lab_from_rgb(DVec3::from(p.map(f64::from)) * self.stops.exp2());
        let (mut squares, mut apart, mut count) = (0.0, 0.0, 0.0);
        for k in (0..counts.len()).filter(|k| counts[*k]) {
            squares +=
                (0..3).map(|c| ((f64::from(a[k][c]) - f64::from(b[k][c])) / 255.0).powi(2)).sum::<f64>()
                    / 3.0;
            apart += delta_e_2000(lab(&self.picture.pixels[k]), lab(&preview.pixels[k]));
            count += 1.0;
        }
        [(squares / count).sqrt(), apart / count]
    }
}

/// Share of every pixel that each ink covers: what three inks of pure colors, alike in all else, reflect over what one would that
/// covers all; 0 where no lamp shines.
fn covered() -> Result<Vec<Vec3>> {
    let band = |axis: Vec3| InkBand { reflectance: axis, growth: Vec3::ZERO, index: Vec2::X, color: axis };
    let inks = PrintInks {
        model: InkModel::Goniochromatic,
        roughness: Vec3::ONE,
        bands: Vec3::AXES.map(band).into(),
        white: Vec3::ONE,
    };
    let (_, dots) = print(3)?;
    let print = Print { inks: &inks, coverage: &Coverage::new(dots), paper: Paper::NONE };
    let some = render_print(&scene(), &print, &OPTIONS, &|| ())?;
    let all = render_lit(
        &scene(),
        &OPTIONS,
        &|wi, wo| inks.reflectance(Vec3::ONE, wi.as_vec3(), wo.as_vec3()),
        &|| (),
    )?;
    let share = |(some, all): (&[f32; 3], &[f32; 3])| {
        let all = Vec3::from(*all);
        if all.min_element() > 0.0 { Vec3::from(*some) / all } else { Vec3::ZERO }
    };
    Ok(some.pixels.iter().zip(&all.pixels).map(share).collect())
}

/// Previews by a model: inks on black paper beside the lamp, and what a lamp behind as bright as that would add.
pub struct Preview {
    front: Picture,
    behind: Picture,
}

impl Preview {
    pub fn by(model: InkModel) -> Result<Self> {
        let inks = seen(&fitted()?, model, Illuminant::D65)?;
        let (_, dots) = print(3)?;
        let print = Print { inks: &inks, coverage: &Coverage::new(dots), paper: Paper::BLACK };
        let lit = |scene: &Scene| render_print(scene, &print, &OPTIONS, &|| ());
        Ok(Self { front: lit(&scene())?, behind: lit(&lit_through())? })
    }

    /// The preview with a share of that lamp: light adds up.
    pub fn with(&self, share: f64) -> Picture {
        let pixels = self.front.pixels.iter().zip(&self.behind.pixels);
        let sum =
            |(front, behind): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|c| front[c] + share as f32 * behind[c]);
        Picture { size: self.front.size, pixels: pixels.map(sum).collect() }
    }

    /// The share with which the shadow is nearest to the photograph, as one would set it by eye.
    pub fn share_behind(&self, photograph: &Photograph) -> f64 {
        let apart = |share: f64| photograph.errors(&self.with(share), &photograph.in_shadow)[1];
        let shares = (0..=40).map(|k| 1e-3 * f64::from(k)).map(|share| (apart(share), share));
        shares.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, share)| share)
    }
}

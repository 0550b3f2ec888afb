//! Fig. 2: plain interpolation between measured directions blurs the highlight; a fitted BRDF does not. Under one lamp, flakes
//! left out: the paint, the separated model, plain interpolation.

use super::{brdf, glossy};
use crate::mosaic::{beside, write};
use crate::plots::{self, BLACK, BLUE, Curve, Mark, Plot, Span, VERMILION};
use crate::{Figure, Finding};
use carpaint::brdf::{Bands, BrdfSample, SampleSet};
use carpaint::color::luminance;
use carpaint::error::Result;
use carpaint::fit::{FitOptions, SmoothFit, fit_samples};
use carpaint::math::half_difference::spherical;
use carpaint::render::Picture;
use carpaint::scene::{Bodies, Camera, DirectionalLight, Scene, Shape};
use carpaint::simulate::Model;
use glam::DVec3;
use plotters::chart::SeriesLabelPosition;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "rump-2008-2",
    claim: "interpolation between measured directions blurs the highlight by far; separated from the rest it keeps its width",
    draw,
};

/// Between measured directions, degrees: 151 of them spread over a hemisphere have 11.7.
const STEP_DEG: f64 = 11.25;
/// Polar angles, 0 to 78.75 degrees, and azimuths, 0 to 180.
const NODES: [usize; 2] = [8, 17];
/// Half way between two measured directions.
const INCIDENCE_DEG: f64 = 3.5 * STEP_DEG;

type Brdf<'a> = &'a (dyn Fn(DVec3, DVec3) -> DVec3 + Sync);

fn draw(name: &Path) -> Result<Finding> {
    let model = glossy()?;
    let plain = Plain::measure(&model);
    let separated = separate(&model)?;
    let truth = |wi: DVec3, wo: DVec3| brdf(&model, wi, wo);
    let fitted = |wi: DVec3, wo: DVec3| separated.eval(wi, wo);
    let blurred = |wi: DVec3, wo: DVec3| plain.eval(wi, wo);
    let all: [Brdf; 3] = [&truth, &fitted, &blurred];
    let tiles = all.into_iter().map(ball).collect::<Result<Vec<_>>>()?;
    write(&name.with_added_extension("balls"), &beside(&tiles))?;

    let looks = [("paint", BLACK), ("BRDF and BTF apart", BLUE), ("plain interpolation", VERMILION)];
    let curves: Vec<Curve> = looks
        .into_iter()
        .zip(all)
        .map(|((name, ink), f)| Curve { name: name.into(), ink, mark: Mark::Line, points: highlight(f) })
        .collect();
    let plot = Plot {
        title: "Highlight of light at 39.4 degrees, half way between two measured directions".into(),
        axes: ["angle from the mirror direction, degrees", "luminance, 1/sr"],
        across: Span::Linear(-30.0..30.0),
        up: Span::Logarithmic(0.05..50.0),
        legend: SeriesLabelPosition::UpperRight,
        curves,
    };
    plots::write(name, std::slice::from_ref(&plot), 1)?;
    let [paint, ours, theirs] = [0, 1, 2].map(|k| width(&plot.curves[k].points));
    Ok(Finding {
        holds: theirs > 3.0 * paint && (ours / paint - 1.0).abs() < 0.2,
        says: format!(
            "full width at half maximum of the highlight: paint {paint:.1} degrees, separated {ours:.1}, plain interpolation {theirs:.1}"
        ),
    })
}

/// Luminance over the angle from the mirror direction, degrees, in the plane of incidence.
fn highlight(f: Brdf) -> Vec<(f64, f64)> {
    let wi = spherical(INCIDENCE_DEG.to_radians(), 0.0);
    let angles = (-300..=300).map(|k| 0.1 * f64::from(k));
    angles.map(|off| (off, luminance(f(wi, spherical((INCIDENCE_DEG + off).to_radians(), PI))))).collect()
}

/// Full width at half maximum of an evenly sampled curve.
fn width(points: &[(f64, f64)]) -> f64 {
    let peak = points.iter().map(|p| p.1).fold(0.0, f64::max);
    let above = points.iter().filter(|p| p.1 >= 0.5 * peak).count();
    above as f64 * (points[1].0 - points[0].0)
}

/// Measured directions, and nothing between them.
struct Plain(Vec<DVec3>);

impl Plain {
    fn measure(model: &Model) -> Self {
        let [n, m] = NODES;
        let node = |k: usize| {
            let [wi, wo] = node_directions([k / m / n, k / m % n, k % m]);
            brdf(model, wi, wo)
        };
        Self((0..n * n * m).into_par_iter().map(node).collect())
    }

    /// Linear in both polar angles and in the azimuth between them.
    fn eval(&self, wi: DVec3, wo: DVec3) -> DVec3 {
        let [n, m] = NODES;
        let (a, b) = (wi.truncate(), wo.truncate());
        let azimuth = if a.length() * b.length() > 0.0 { a.angle_to(b).abs() } else { PI };
        let polar = |w: DVec3| w.truncate().length().atan2(w.z);
        let at = [(polar(wi), n), (polar(wo), n), (azimuth, m)].map(|(angle, count)| {
            let place = (angle.to_degrees() / STEP_DEG).clamp(0.0, (count - 1) as f64);
            let low = (place as usize).min(count - 2);
            (low, place - low as f64)
        });
        let corner = |k: usize| {
            let side = |axis: usize| k >> axis & 1;
            let weight = |axis: usize| if side(axis) == 1 { at[axis].1 } else { 1.0 - at[axis].1 };
            let [i, o, phi] = [0, 1, 2].map(|axis| at[axis].0 + side(axis));
            weight(0) * weight(1) * weight(2) * self.0[(i * n + o) * m + phi]
        };
        (0..8).map(corner).sum()
    }
}

fn node_directions([i, o, phi]: [usize; 3]) -> [DVec3; 2] {
    let angle = |k: usize| (k as f64 * STEP_DEG).to_radians();
    [spherical(angle(i), 0.0), spherical(angle(o), angle(phi))]
}

/// The model of eq. 6 from the same directions, and from the images that hold a mirrored lamp, across which the angle changes
/// (section 5.1.1).
fn separate(model: &Model) -> Result<SmoothFit> {
    let [mut base, mut gloss] = [SampleSet::new(Bands::Rgb)?, SampleSet::new(Bands::Rgb)?];
    let [n, m] = NODES;
    let push = |set: &mut SampleSet, wi: DVec3, wo: DVec3| {
        let weight = |w: DVec3| w.truncate().length().max(0.05);
        set.push(BrdfSample::new(wi, wo, weight(wi) * weight(wo)), &brdf(model, wi, wo).to_array())
    };
    for k in 0..n * n * m {
        let [wi, wo] = node_directions([k / m / n, k / m % n, k % m]);
        push(&mut base, wi, wo)?;
    }
    for i in 1..n - 1 {
        for off in -12..=12 {
            let theta = i as f64 * STEP_DEG;
            let eye = theta + 0.5 * f64::from(off);
            push(&mut gloss, spherical(theta.to_radians(), 0.0), spherical(eye.to_radians(), PI))?;
        }
    }
    Ok(fit_samples(&base, Some(&gloss), &FitOptions::default(), &|| ())?.0)
}

/// A ball under one lamp, every pixel the BRDF of its middle.
fn ball(f: Brdf) -> Result<Picture> {
    let light = DirectionalLight {
        direction: [-0.6, -0.75, 0.45],
        irradiance: [4.0; 3],
        ..DirectionalLight::default()
    };
    let scene = Scene {
        size: [280, 280],
        camera: Camera { vertical_fov_deg: 13.0, ..Camera::default() },
        shape: Shape::Sphere { radius_mm: 22.0 },
        lights: vec![light.into()],
        ..Scene::default()
    };
    let (bodies, view) = (Bodies::new(&scene)?, scene.camera.view(scene.size));
    let lamp = scene.lights[0].at(DVec3::ZERO);
    let point = |x: f64, y: f64| {
        let direction = view.direction(x, y);
        let Some(hit) = bodies.intersect(view.origin, direction) else { return DVec3::splat(0.1) };
        let to_local = view.frame(hit.normal).transpose();
        let (wi, wo) = (to_local * lamp.direction, to_local * -direction);
        if wi.z > 0.0 && wo.z > 0.0 { f(wi, wo) * lamp.irradiance * wi.z } else { DVec3::ZERO }
    };
    let pixel = |k: usize| {
        let corner = [k % scene.size[0], k / scene.size[0]].map(|n| n as f64);
        let quarters = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]];
        let sum: DVec3 = quarters.iter().map(|q| point(corner[0] + q[0], corner[1] + q[1])).sum();
        (0.25 * sum).as_vec3().to_array()
    };
    let pixels = (0..scene.size[0] * scene.size[1]).into_par_iter().map(pixel).collect();
    Ok(Picture { size: scene.size, pixels })
}

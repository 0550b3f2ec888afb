//! What an instrument would read of a paint, and what is under the pointer.

use super::shelf::Ready;
use crate::color::{lab_from_rgb, rgb_from_lab};
use crate::math::half_difference::HalfDifference;
use crate::render::{RenderPaint, shade_mean};
use crate::scene::{Bodies, Scene};
use crate::simulate::{Reading, flop_index};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// Light at 45 degrees, as multi-angle instruments have it.
const INCIDENCE_DEG: f64 = 45.0;
/// Aspecular angles, degrees, that are read.
pub const ASPECULAR_DEG: [f64; 5] = [15.0, 25.0, 45.0, 75.0, 110.0];
/// Those of the flop index among them.
const FLOP: [usize; 3] = [0, 2, 4];

/// L*a*b* (D65) of the mean reflectance factor pi f, gloss left out.
fn lab(paint: &RenderPaint, wi: DVec3, wo: DVec3) -> DVec3 {
    lab_from_rgb(shade_mean(paint, wi.as_vec3(), wo.as_vec3()).as_dvec3() * PI)
}

/// Readings of a multi-angle instrument.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instrument {
    /// L*a*b* at each of [`ASPECULAR_DEG`].
    pub labs: [DVec3; 5],
    /// Where it is defined.
    pub flop_index: Option<f64>,
}

impl Instrument {
    /// Reads a paint.
    pub fn read(paint: &RenderPaint) -> Self {
        let labs = ASPECULAR_DEG.map(|aspecular_deg| {
            let (wi, wo) = Reading { incidence_deg: INCIDENCE_DEG, aspecular_deg }.directions();
            lab(paint, wi, wo)
        });
        Self { labs, flop_index: flop_index(FLOP.map(|k| labs[k].x)) }
    }

    /// The paint's color in the face, linear Rec.709 within [0, 1], for a swatch.
    pub fn face(&self) -> [f64; 3] {
        rgb_from_lab(self.labs[FLOP[1]]).clamp(DVec3::ZERO, DVec3::ONE).to_array()
    }
}

/// A point of the paint under the pointer, lit by the first lamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// L*a*b* (D65) of the mean reflectance factor there, gloss left out.
    pub lab: DVec3,
    /// Angle between half vector and normal, degrees.
    pub theta_h_deg: f64,
    /// Angle between half vector and light, degrees.
    pub theta_i_deg: f64,
    /// From the mirror direction, degrees.
    pub aspecular_deg: f64,
}

impl Spot {
    /// What is at a pixel; none beside the object, on its back or in the lamp's shadow side, and where `paint` does not know the
    /// values of the paint of this number.
    pub fn at(
        scene: &Scene,
        bodies: &Bodies,
        paint: impl FnOnce(usize) -> Option<Arc<Ready>>,
        [x, y]: [f64; 2],
    ) -> Option<Self> {
        let view = scene.camera.view(scene.size);
        let direction = view.direction(x, y);
        let hit = bodies.intersect(view.origin, direction)?;
        let to_surface = bodies.frame(&hit).transpose();
        let wi = to_surface * scene.lights.first()?.at(hit.point).direction;
        let wo = to_surface * -direction;
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return None;
        }
        let angles = HalfDifference::of(wi, wo);
        let mirror = DVec3::new(-wi.x, -wi.y, wi.z);
        Some(Self {
            lab: lab(&paint(bodies.paint(hit.object))?.paint, wi, wo),
            theta_h_deg: angles.theta_h.to_degrees(),
            theta_i_deg: angles.theta_i.to_degrees(),
            aspecular_deg: mirror.dot(wo).clamp(-1.0, 1.0).acos().to_degrees(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::{ClearCoat, ColorTable};
    use crate::paint::Paint;
    use crate::scene::{DirectionalLight, Shape};

    fn diffuser(diffuse: f64) -> Arc<Ready> {
        let (coat, lobes) = (ClearCoat::NONE, Vec::new());
        let provenance = serde_json::Value::Null;
        let colors = ColorTable::white();
        Ready::new(&Paint { coat, diffuse, lobes, colors, flakes: None, provenance }).unwrap()
    }

    #[test]
    fn a_diffuser_reads_alike_everywhere() {
        let read = diffuser(1.0).instrument;
        for lab in read.labs {
            // f32 arithmetic of the renderer.
            assert!((lab - DVec3::new(100.0, 0.0, 0.0)).length() < 1e-3, "{lab}");
        }
        assert!(read.flop_index.is_none_or(|flop| flop < 1e-3));
        assert!(diffuser(0.2).instrument.face().iter().all(|c| (c - 0.2).abs() < 1e-6));
    }

    #[test]
    fn angles_under_the_pointer_are_those_of_the_scene() {
        let scene = Scene {
            size: [100, 100],
            shape: Shape::Panel { size_mm: [40.0, 40.0], normal: [0.0, -1.0, 0.0] },
            lights: vec![DirectionalLight { direction: [0.0, -1.0, 1.0], ..Default::default() }.into()],
            camera: crate::scene::Camera { position_mm: [0.0, -200.0, 0.0], ..Default::default() },
            ..Scene::default()
        };
        let (bodies, paint) = (Bodies::new(&scene).unwrap(), diffuser(1.0));
        let at = |place| Spot::at(&scene, &bodies, |k| [&paint].get(k).map(|p| (*p).clone()), place);
        let spot = at([50.0, 50.0]).unwrap();
        // Seen along the normal, lit at 45 degrees; arc cosines.
        assert!((spot.theta_h_deg - 22.5).abs() < 1e-6 && (spot.theta_i_deg - 22.5).abs() < 1e-6, "{spot:?}");
        assert!((spot.aspecular_deg - 45.0).abs() < 1e-6, "{spot:?}");
        assert!(at([1.0, 1.0]).is_none(), "beside the panel");
        assert!(Spot::at(&scene, &bodies, |_| None, [50.0, 50.0]).is_none(), "values that are on their way");
    }
}

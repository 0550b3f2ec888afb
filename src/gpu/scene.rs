//! A scene in the layout of `shaders/shared/scene.wgsl`.

use crate::render::{Options, Random};
use crate::scene::{self, DirectionalLight, PointLight, SpotLight};
use encase::ShaderType;
use glam::{DVec3, Vec2, Vec3};
use std::array::from_fn;

/// Twins of the structs of the shader; what their fields mean is said there.
#[derive(Debug, Clone, ShaderType)]
pub(super) struct Scene {
    view: View,
    shape: Shape,
    ground: Vec3,
    softbox_count: u32,
    horizon: Vec3,
    light_count: u32,
    zenith: Vec3,
    has_background: u32,
    background: Vec3,
    samples: u32,
    directions: u32,
    seed: u32,
    random: u32,
    lights: [Light; scene::Scene::MAX_LIGHTS],
    softboxes: [Softbox; scene::Environment::MAX_SOFTBOXES],
}

#[derive(Debug, Clone, ShaderType)]
struct View {
    foot: Vec3,
    reach: f32,
    forward: Vec3,
    right: Vec3,
    down: Vec3,
    middle: Vec2,
}

#[derive(Debug, Clone, ShaderType)]
struct Shape {
    right: Vec3,
    kind: u32,
    up: Vec3,
    radius: f32,
    normal: Vec3,
    half_height: f32,
    half_size: Vec2,
}

#[derive(Debug, Clone, Copy, Default, ShaderType)]
struct Light {
    place: Vec3,
    nearness: f32,
    power: Vec3,
    radius: f32,
    axis: Vec3,
    cone: f32,
    edge: f32,
}

#[derive(Debug, Clone, Copy, Default, ShaderType)]
struct Softbox {
    right: Vec3,
    edge: f32,
    up: Vec3,
    reach: f32,
    middle: Vec3,
    share: f32,
    radiance: Vec3,
    half_size: Vec2,
    tangents: Vec2,
    extent: Vec2,
}

/// Cells a side of the random texture; 0: none, a hash.
pub(super) fn random_side(random: Random) -> u32 {
    match random {
        Random::Hash => 0,
        Random::Texture(side) => side,
    }
}

impl Scene {
    /// A valid scene.
    pub fn new(scene: &scene::Scene, options: &Options) -> Self {
        let surroundings = scene.environment.surroundings();
        let [ground, horizon, zenith] = surroundings.gradient;
        Self {
            view: View::new(&scene.camera.view(scene.size)),
            shape: Shape::new(&scene.shape),
            ground,
            softbox_count: surroundings.lamps.len() as u32,
            horizon,
            light_count: scene.lights.len() as u32,
            zenith,
            has_background: u32::from(scene.background.is_some()),
            background: DVec3::from(scene.background.unwrap_or_default()).as_vec3(),
            samples: options.samples as u32,
            directions: options.directions as u32,
            seed: options.seed,
            random: random_side(options.random),
            lights: from_fn(|k| scene.lights.get(k).map_or_else(Light::default, Light::new)),
            softboxes: from_fn(|k| {
                let lamp = surroundings.lamps.get(k);
                lamp.map_or_else(Softbox::default, |lamp| Softbox {
                    right: lamp.axes[0],
                    edge: lamp.edge,
                    up: lamp.axes[1],
                    reach: lamp.reach,
                    middle: lamp.axes[2],
                    share: lamp.share(),
                    radiance: lamp.radiance,
                    half_size: lamp.half.into(),
                    tangents: lamp.tangents.into(),
                    extent: Vec2::new(lamp.extent(0), lamp.extent(1)),
                })
            }),
        }
    }
}

impl View {
    fn new(view: &scene::View) -> Self {
        let reach = -view.origin.dot(view.forward);
        Self {
            foot: (view.origin + view.forward * reach).as_vec3(),
            reach: reach as f32,
            forward: view.forward.as_vec3(),
            right: view.right.as_vec3(),
            down: view.down.as_vec3(),
            middle: Vec2::new(view.middle[0] as f32, view.middle[1] as f32),
        }
    }
}

impl Shape {
    fn new(shape: &scene::Shape) -> Self {
        let [right, up, normal] = shape.panel_axes().map(|axis| axis.as_vec3());
        let any = Self { right, kind: 0, up, radius: 1.0, normal, half_height: 0.0, half_size: Vec2::ZERO };
        match *shape {
            scene::Shape::Capsule { radius_mm, height_mm } => {
                Self { radius: radius_mm as f32, half_height: (height_mm / 2.0 - radius_mm) as f32, ..any }
            }
            scene::Shape::Sphere { radius_mm } => Self { kind: 1, radius: radius_mm as f32, ..any },
            scene::Shape::Panel { size_mm: [width, height], .. } => {
                Self { kind: 2, half_size: 0.5 * Vec2::new(width as f32, height as f32), ..any }
            }
        }
    }
}

impl Light {
    fn new(light: &scene::Light) -> Self {
        match light {
            scene::Light::Directional(light) => Self::far(light),
            scene::Light::Point(light) => Self::near(light),
            scene::Light::Spot(light) => Self::spot(light),
        }
    }

    fn far(light: &DirectionalLight) -> Self {
        let direction = DVec3::from(light.direction).normalize();
        Self {
            place: direction.as_vec3(),
            nearness: 0.0,
            power: DVec3::from(light.irradiance).as_vec3(),
            radius: light.angular_radius_deg.to_radians().sin() as f32,
            axis: -direction.as_vec3(),
            cone: 4.0,
            edge: 0.0,
        }
    }

    fn near(light: &PointLight) -> Self {
        let center = DVec3::from(light.position_mm);
        Self {
            place: center.as_vec3(),
            nearness: 1.0,
            power: (DVec3::from(light.irradiance) * center.length_squared()).as_vec3(),
            radius: light.radius_mm as f32,
            axis: -center.normalize().as_vec3(),
            cone: 4.0,
            edge: 0.0,
        }
    }

    fn spot(light: &SpotLight) -> Self {
        let axis = DVec3::from(light.target_mm) - DVec3::from(light.lamp.position_mm);
        Self {
            axis: axis.normalize().as_vec3(),
            cone: light.cone_deg.to_radians() as f32,
            edge: light.edge_deg.to_radians() as f32,
            ..Self::near(&light.lamp)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::reflection::assert_same_layout;
    use super::*;

    #[test]
    fn structs_lie_as_the_shader_reads_them() {
        assert_same_layout::<View, _>("View");
        assert_same_layout::<Shape, _>("Shape");
        assert_same_layout::<Light, _>("Light");
        assert_same_layout::<Softbox, _>("Softbox");
        assert_same_layout::<Scene, _>("Scene");
    }
}

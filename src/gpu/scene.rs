//! A scene in the layout of `shaders/shared/scene.wgsl`.

use super::device::Gpu;
use crate::error::Result;
use crate::render::{Random, Stage};
use crate::scene::{self, Body, Convex, DirectionalLight, Form, PointLight, SpotLight};
use encase::ShaderType;
use glam::{DVec3, Mat3, UVec2, UVec4, Vec2, Vec3};
use std::array::from_fn;
use std::sync::Arc;

/// Twins of the structs of the shader; what their fields mean is said there.
#[derive(Debug, Clone, ShaderType)]
pub(super) struct Scene {
    view: View,
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
    object_count: u32,
    panorama: Panorama,
    lamp_level: f32,
    lamp_power: f32,
    lamp_group_count: u32,
    lamp_groups: [LampGroup; scene::LampGroup::MOST],
    objects: [Object; scene::Scene::MAX_OBJECTS],
    lights: [Light; scene::Scene::MAX_LIGHTS],
    softboxes: [Softbox; scene::Environment::MAX_SOFTBOXES],
}

#[derive(Debug, Clone, Default, ShaderType)]
struct Object {
    view: View,
    shape: Shape,
    axes: Mat3,
    position: Vec3,
    paint: u32,
}

#[derive(Debug, Clone, Default, ShaderType)]
struct Panorama {
    size: UVec2,
    first_texel: u32,
    first_row: u32,
    turn: Vec2,
    is_bright: u32,
}

#[derive(Debug, Clone, Copy, Default, ShaderType)]
struct LampGroup {
    direction: Vec3,
    luminance: f32,
    light: Vec3,
    solid_angle: f32,
    alone: f32,
    own: f32,
}

#[derive(Debug, Clone, Default, ShaderType)]
struct View {
    foot: Vec3,
    reach: f32,
    forward: Vec3,
    right: Vec3,
    down: Vec3,
    middle: Vec2,
}

#[derive(Debug, Clone, Default, ShaderType)]
struct Shape {
    right: Vec3,
    kind: u32,
    up: Vec3,
    radius: f32,
    normal: Vec3,
    half_height: f32,
    half_size: Vec2,
    first_node: u32,
    nodes: u32,
    first_triangle: u32,
    first_vertex: u32,
    size: f32,
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

/// The buffers of a scene that is ready for rays: the scene, and its tables.
///
/// # Errors
/// More than the GPU has room for, what the driver complains about.
pub(super) fn upload(gpu: &Gpu, stage: &Stage) -> Result<[wgpu::Buffer; 2]> {
    Tables::new(gpu, stage)?.with(gpu, stage)
}

/// Meshes and a panorama on the GPU, which may outlast a scene: camera, lamps and places of objects are elsewhere.
#[derive(Debug)]
pub(super) struct Tables {
    places: Places,
    buffer: wgpu::Buffer,
}

/// What lies where in tables. It is the same as long as it is one allocation, which is kept here.
#[derive(Debug, Default)]
struct Places {
    meshes: Vec<(Arc<scene::Mesh>, Shape)>,
    panorama: Option<(Arc<scene::Panorama>, Panorama)>,
}

impl Tables {
    /// Those of a scene.
    ///
    /// # Errors
    /// More than the GPU has room for, what the driver complains about.
    pub fn new(gpu: &Gpu, stage: &Stage) -> Result<Self> {
        // Never empty: no buffer may be.
        let mut words = vec![UVec4::ZERO];
        let places = Places::new(stage, &mut words);
        Ok(Self { places, buffer: gpu.storage("tables of the scene", &words)? })
    }

    /// Whether they are those of a scene.
    pub fn are_of(&self, stage: &Stage) -> bool {
        self.places.are_of(stage)
    }

    /// The buffers of a scene that these are the tables of: the scene, and they.
    ///
    /// # Errors
    /// What the driver complains about.
    pub fn with(&self, gpu: &Gpu, stage: &Stage) -> Result<[wgpu::Buffer; 2]> {
        Ok([gpu.uniform("scene", &Scene::new(stage, &self.places))?, self.buffer.clone()])
    }
}

impl Places {
    /// Writes what a scene has for tables behind `words`.
    fn new(stage: &Stage, words: &mut Vec<UVec4>) -> Self {
        let panorama = stage.surroundings.panorama.as_ref().map(|p| (p.clone(), Panorama::new(p, words)));
        let mut places = Self { meshes: Vec::new(), panorama };
        for mesh in meshes(stage) {
            if places.mesh(mesh).is_none() {
                places.meshes.push((mesh.clone(), Shape::mesh(mesh, words)));
            }
        }
        places
    }

    fn mesh(&self, mesh: &Arc<scene::Mesh>) -> Option<&Shape> {
        self.meshes.iter().find(|(other, _)| Arc::ptr_eq(other, mesh)).map(|(_, shape)| shape)
    }

    /// Whether they are those of a scene: there is all that it has, and nothing else.
    fn are_of(&self, stage: &Stage) -> bool {
        let is_seen = |known: &Arc<scene::Mesh>| meshes(stage).any(|mesh| Arc::ptr_eq(mesh, known));
        let has_panorama = match (&self.panorama, &stage.surroundings.panorama) {
            (Some((known, _)), Some(panorama)) => Arc::ptr_eq(known, panorama),
            (None, None) => true,
            _ => false,
        };
        has_panorama
            && meshes(stage).all(|mesh| self.mesh(mesh).is_some())
            && self.meshes.iter().all(|(known, _)| is_seen(known))
    }
}

/// The meshes of a scene, one as often as objects have it.
fn meshes<'a>(stage: &'a Stage) -> impl Iterator<Item = &'a Arc<scene::Mesh>> {
    stage.bodies.iter().filter_map(|body| match &body.form {
        Form::Mesh(mesh) => Some(mesh),
        Form::Convex(_) => None,
    })
}

impl Scene {
    fn new(stage: &Stage, places: &Places) -> Self {
        let Stage { scene, options, view, bodies, surroundings, .. } = stage;
        let [ground, horizon, zenith] = surroundings.gradient;
        let lamps = surroundings.lamp_points();
        let objects = from_fn(|k| {
            bodies.iter().nth(k).map_or_else(Object::default, |body| Object::new(body, view, places))
        });
        Self {
            view: View::new(view),
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
            object_count: bodies.iter().count() as u32,
            panorama: places.panorama.as_ref().map_or_else(Panorama::default, |(_, there)| there.clone()),
            lamp_level: lamps.level,
            lamp_power: lamps.power,
            lamp_group_count: lamps.groups.len() as u32,
            lamp_groups: from_fn(|k| lamps.groups.get(k).map_or_else(LampGroup::default, LampGroup::new)),
            objects,
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

impl Object {
    /// `meshes`: those that lie in the tables already.
    fn new(body: &Body, view: &scene::View, places: &Places) -> Self {
        let shape = match &body.form {
            Form::Convex(convex) => Shape::convex(convex),
            Form::Mesh(mesh) => places.mesh(mesh).cloned().unwrap_or_default(),
        };
        Self {
            view: View::new(&view.seen_from(&body.placement)),
            shape,
            axes: body.placement.axes.as_mat3(),
            position: body.placement.position.as_vec3(),
            paint: body.paint as u32,
        }
    }
}

impl Panorama {
    fn new(panorama: &scene::Panorama, tables: &mut Vec<UVec4>) -> Self {
        let first_texel = tables.len() as u32;
        let bits = |[x, y, z]: [f32; 3], w: f32| UVec4::from([x, y, z, w].map(f32::to_bits));
        tables.extend(panorama.texels.iter().map(|(radiance, upto)| bits(*radiance, *upto)));
        let first_row = tables.len() as u32;
        tables.extend(panorama.rows.iter().map(|(upto, end)| bits([*upto, *end, 0.0], 0.0)));
        let [width, height] = panorama.size.map(|n| n as u32);
        Self {
            size: UVec2::new(width, height),
            first_texel,
            first_row,
            turn: panorama.turn,
            is_bright: u32::from(panorama.is_bright()),
        }
    }
}

impl LampGroup {
    fn new(group: &scene::LampGroup) -> Self {
        let scene::LampGroup { direction, luminance, light, solid_angle, alone, own } = *group;
        Self { direction, luminance, light, solid_angle, alone, own }
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
    fn convex(convex: &Convex) -> Self {
        let [right, up, normal] = convex.axes().map(|axis| axis.as_vec3());
        let any = Self { right, up, normal, radius: 1.0, ..Self::default() };
        match *convex {
            Convex::Capsule { radius, half } => {
                Self { radius: radius as f32, half_height: half as f32, ..any }
            }
            Convex::Sphere { radius } => Self { kind: 1, radius: radius as f32, ..any },
            Convex::Panel { size: [width, height], .. } => {
                Self { kind: 2, half_size: 0.5 * Vec2::new(width as f32, height as f32), ..any }
            }
        }
    }

    fn mesh(mesh: &scene::Mesh, tables: &mut Vec<UVec4>) -> Self {
        let bits = |v: Vec3, w: u32| UVec4::new(v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w);
        let first_node = tables.len() as u32;
        tables.extend(mesh.nodes.iter().flat_map(|n| [bits(n.low, n.next), bits(n.high, n.leaf)]));
        let first_triangle = tables.len() as u32;
        tables.extend(mesh.triangles.iter().map(|([a, b, c], chart)| UVec4::new(*a, *b, *c, *chart)));
        let first_vertex = tables.len() as u32;
        // Behind place and normal there is room for a place in a picture; one far away is none.
        let uv = |k: usize| mesh.uvs.get(k).filter(|uv| uv.is_finite()).copied().unwrap_or(Vec2::splat(1e30));
        let vertex = |(k, (place, normal)): (usize, &(Vec3, Vec3))| {
            let [u, v] = uv(k).to_array().map(f32::to_bits);
            [bits(*place, u), bits(*normal, v)]
        };
        tables.extend(mesh.vertices.iter().enumerate().flat_map(vertex));
        let nodes = mesh.nodes.len() as u32;
        Self { kind: 3, first_node, nodes, first_triangle, first_vertex, size: mesh.size, ..Self::default() }
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
    use crate::render::Options;

    #[test]
    fn structs_lie_as_the_shader_reads_them() {
        assert_same_layout::<View, _>("View");
        assert_same_layout::<Shape, _>("Shape");
        assert_same_layout::<Object, _>("Object");
        assert_same_layout::<Panorama, _>("Panorama");
        assert_same_layout::<Light, _>("Light");
        assert_same_layout::<Softbox, _>("Softbox");
        assert_same_layout::<Scene, _>("Scene");
    }

    #[test]
    fn tables_outlast_a_scene_of_the_same_meshes_and_surroundings() {
        let options = Options::default();
        let object = |x: f64, length_mm: f64| scene::Object {
            shape: scene::Shape::SpeedShape { length_mm },
            position_mm: [x, 0.0, 0.0],
            ..scene::Object::default()
        };
        let first = scene::Scene {
            environment: scene::Environment::Sky { sun: [0.0, 0.0, 1.0], zenith: [0.2; 3], ground: [0.1; 3] },
            objects: vec![object(0.0, 60.0), object(80.0, 40.0), object(-80.0, 60.0)],
            ..scene::Scene::default()
        };
        let before = Stage::new(&first, &options).unwrap();
        let places = Places::new(&before, &mut vec![UVec4::ZERO]);
        assert_eq!(places.meshes.len(), 2, "one of two objects is there once");
        let changed = |scene: &scene::Scene, surroundings: &scene::Surroundings| {
            let bodies = before.bodies.changed(scene).unwrap();
            let stage = Stage::with(scene, &options, bodies, surroundings.clone());
            let fresh = Scene::new(&stage, &Places::new(&stage, &mut vec![UVec4::ZERO]));
            (places.are_of(&stage), format!("{:?}", Scene::new(&stage, &places)) == format!("{fresh:?}"))
        };
        let mut moved = first.clone();
        moved.camera.position_mm = [-90.0, -120.0, 70.0];
        moved.objects[1].position_mm = [70.0, 20.0, 0.0];
        moved.lights.clear();
        assert_eq!(changed(&moved, &before.surroundings), (true, true));
        let mut others = moved.clone();
        others.objects[1] = object(70.0, 50.0);
        assert_eq!(changed(&others, &before.surroundings), (false, false));
        others.objects.truncate(1);
        assert!(!changed(&others, &before.surroundings).0, "what is not seen any more goes");
        let dark = scene::Environment::Constant { radiance: [0.0; 3] }.surroundings().unwrap();
        assert_eq!(changed(&moved, &dark), (false, false));
        let brighter = first.environment.surroundings().unwrap();
        assert!(!changed(&moved, &brighter).0, "another panorama");
    }
}

// A scene as it is drawn, and how: filled by gpu/scene.rs.

struct Scene {
    view: View,
    ground: vec3<f32>,
    softbox_count: u32,
    horizon: vec3<f32>,
    light_count: u32,
    zenith: vec3<f32>,
    // 0: the surroundings themselves are seen.
    has_background: u32,
    background: vec3<f32>,
    samples: u32,
    directions: u32,
    seed: u32,
    // Cells a side of the random texture; 0: none, a hash.
    random: u32,
    object_count: u32,
    panorama: Panorama,
    // Luminance beyond which light of the surroundings counts as a lamp's, the integral of what is beyond, and its groups.
    lamp_level: f32,
    lamp_power: f32,
    lamp_group_count: u32,
    lamp_groups: array<LampGroup, 24>,
    objects: array<Object, 16>,
    lights: array<Light, 64>,
    softboxes: array<Softbox, 64>,
}

// Twin of the struct of scene/lamp_groups.rs.
struct LampGroup {
    direction: vec3<f32>,
    luminance: f32,
    light: vec3<f32>,
    solid_angle: f32,
    alone: f32,
    own: f32,
}

@group(1) @binding(0) var<uniform> scene: Scene;
// What has no fixed size: panorama and meshes.
@group(1) @binding(3) var<storage, read> tables: array<vec4<u32>>;

// Twin of scene/softbox.rs.

const RIM: f32 = 1.00001;

struct Softbox {
    right: vec3<f32>,
    edge: f32,
    up: vec3<f32>,
    reach: f32,
    middle: vec3<f32>,
    // Share of the power of all.
    share: f32,
    radiance: vec3<f32>,
    half_size: vec2<f32>,
    tangents: vec2<f32>,
    // Half the angles that it covers, its edge included.
    extent: vec2<f32>,
}

fn softbox_radiance(box: Softbox, direction: vec3<f32>) -> vec3<f32> {
    let z = dot(box.middle, direction);
    if z < 0.999 * box.reach {
        return vec3<f32>(0.0);
    }
    let x = angle(abs(dot(box.right, direction)), z);
    let y = angle(abs(dot(box.up, direction)), z);
    let low = box.half_size - box.edge;
    let high = box.half_size + box.edge;
    return box.radiance * ((1.0 - smoothstep(low.x, high.x, x)) * (1.0 - smoothstep(low.y, high.y, y)));
}

fn softbox_sample(box: Softbox, at: vec2<f32>) -> vec3<f32> {
    let angles = box.extent * (2.0 * at - 1.0);
    let x = circle(angles.x * FRAC_1_TAU);
    let y = circle(angles.y * FRAC_1_TAU);
    return normalize(box.right * (x.y / x.x) + box.up * (y.y / y.x) + box.middle);
}

fn softbox_density(box: Softbox, direction: vec3<f32>) -> f32 {
    let z = dot(box.middle, direction);
    if z < 0.999 * box.reach || z <= 0.0 {
        return 0.0;
    }
    let at = vec2<f32>(dot(box.right, direction), dot(box.up, direction)) / z;
    if any(abs(at) > RIM * box.tangents) {
        return 0.0;
    }
    let angles = 4.0 * box.extent.x * box.extent.y;
    return 1.0 / (angles * (1.0 + at.x * at.x) * (1.0 + at.y * at.y) * z * z * z);
}

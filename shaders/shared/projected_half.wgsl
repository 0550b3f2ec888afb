// Twin of brdf/projected_half.rs.

const LACQUER_INDEX: f32 = 1.5;

fn projected_half(wi: vec3<f32>, wo: vec3<f32>) -> vec2<f32> {
    let sum = inside_lacquer(wi) + inside_lacquer(wo);
    let half = sum * (1.0 / length(sum));
    return half.xy * sqrt(2.0 / (1.0 + half.z));
}

// Area of projected half vectors over the solid angle of the directions `wi` that they belong to, `wo` held.
fn half_stretch(wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let inside = inside_lacquer(wi);
    return wi.z / (LACQUER_INDEX * LACQUER_INDEX * inside.z * 2.0 * length(inside + inside_lacquer(wo)));
}

fn inside_lacquer(w: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(w.xy / LACQUER_INDEX, refracted_cosine(w.z, LACQUER_INDEX));
}

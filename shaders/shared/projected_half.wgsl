// Twin of brdf/projected_half.rs.

const LACQUER_INDEX: f32 = 1.5;

fn projected_half(wi: vec3<f32>, wo: vec3<f32>) -> vec2<f32> {
    let sum = inside_lacquer(wi) + inside_lacquer(wo);
    let half = sum * (1.0 / length(sum));
    return half.xy * sqrt(2.0 / (1.0 + half.z));
}

fn inside_lacquer(w: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(w.xy / LACQUER_INDEX, refracted_cosine(w.z, LACQUER_INDEX));
}

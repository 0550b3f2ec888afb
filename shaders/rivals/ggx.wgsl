// Entry point: a plain shader to measure beside, Lambert's law and one GGX lobe (Walter et al. 2007) with Smith's masking.

const GGX_COLOR: vec3<f32> = vec3<f32>(0.3, 0.1, 0.05);
const GGX_F0: f32 = 0.04;
const GGX_ROUGHNESS: f32 = 0.2;

@fragment
fn ggx_frame(corner: Corner) -> @location(0) vec4<f32> {
    let kept = kept_of_paint(corner);
    let hit = kept_hit(frame_offset(corner.place), kept);
    let wo = -normalize(hit.ray.along);
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < scene.light_count; k++) {
        let seen = light_at(scene.lights[k], hit.point);
        let cos_i = dot(hit.normal, seen.direction);
        if cos_i > 0.0 {
            sum += ggx_shade(hit.normal, seen.direction, wo, cos_i) * seen.irradiance * cos_i;
        }
    }
    return encoded(sum * frame.exposure);
}

fn ggx_shade(normal: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>, cos_i: f32) -> vec3<f32> {
    let half = normalize(wi + wo);
    let cos_o = max(dot(normal, wo), 1e-4);
    let cos_h = dot(normal, half);
    let a2 = GGX_ROUGHNESS * GGX_ROUGHNESS;
    let d = cos_h * cos_h * (a2 - 1.0) + 1.0;
    let masked = cos_o * sqrt(a2 + (1.0 - a2) * cos_i * cos_i) + cos_i * sqrt(a2 + (1.0 - a2) * cos_o * cos_o);
    let lobe = a2 * FRAC_1_PI / (d * d) * (0.5 / masked) * schlick(GGX_F0, dot(half, wo));
    return GGX_COLOR * FRAC_1_PI + lobe;
}

// Entry point: a plain shader to measure beside, Lambert's law and one GGX lobe (Walter et al. 2007) with Smith's masking.

const GGX_COLOR: vec3<f32> = vec3<f32>(0.3, 0.1, 0.05);
const GGX_F0: f32 = 0.04;
const GGX_ROUGHNESS: f32 = 0.2;

@fragment
fn ggx_frame(corner: Corner) -> @location(0) vec4<f32> {
    let kept = kept_of_paint(corner);
    let seen = kept_seen(corner, kept);
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < scene.light_count; k++) {
        let light = light_at(scene.lights[k], seen.point);
        let wi = seen.to_surface * light.direction;
        if wi.z > 0.0 {
            sum += ggx_shade(wi, seen.wo) * light.irradiance * wi.z;
        }
    }
    return encoded(sum * frame.exposure);
}

fn ggx_shade(wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let half = normalize(wi + wo);
    let cos_i = wi.z;
    let cos_o = max(wo.z, 1e-4);
    let cos_h = half.z;
    let a2 = GGX_ROUGHNESS * GGX_ROUGHNESS;
    let d = cos_h * cos_h * (a2 - 1.0) + 1.0;
    let masked = cos_o * sqrt(a2 + (1.0 - a2) * cos_i * cos_i) + cos_i * sqrt(a2 + (1.0 - a2) * cos_o * cos_o);
    let lobe = a2 * FRAC_1_PI / (d * d) * (0.5 / masked) * schlick(GGX_F0, dot(half, wo));
    return GGX_COLOR * FRAC_1_PI + lobe;
}

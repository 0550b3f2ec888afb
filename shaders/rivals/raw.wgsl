// Entry point: car paint as AxF renderers draw it, to measure beside: the same smooth part; the flakes' slices are textures with
// levels, of which a light takes the four about its angles.

// A layer a slice.
@group(3) @binding(1) var raw_slices: texture_2d_array<f32>;
@group(3) @binding(2) var raw_sampler: sampler;

@fragment
fn raw_frame(corner: Corner) -> @location(0) vec4<f32> {
    let kept = kept_of_paint(corner);
    let seen = kept_seen(corner, kept);
    let wo = seen.wo;
    let side = f32(textureDimensions(raw_slices).x) * paint.flakes.texel_mm;
    let uv = seen.surface.uv_mm / side;
    let a = seen.surface.footprint[0] / side;
    let b = seen.surface.footprint[1] / side;
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < scene.light_count; k++) {
        let light = light_at(scene.lights[k], seen.point);
        let wi = seen.to_surface * light.direction;
        if wi.z > 0.0 && wo.z > 0.0 {
            let g = geometry(coat_inner(wi), coat_inner(wo));
            let taps = flake_slices(g.theta_h, g.theta_i);
            var xi = vec3<f32>(0.0);
            for (var tap = 0u; tap < 4u; tap++) {
                // A slice that is not there: any, with no weight.
                let layer = select(taps.slice[tap], 0u, taps.slice[tap] == NO_SLICE);
                let weight = select(taps.weight[tap], 0.0, taps.slice[tap] == NO_SLICE);
                xi += textureSampleGrad(raw_slices, raw_sampler, uv, layer, a, b).xyz * weight;
            }
            let widening = light.angular_radius * light.angular_radius / 8.0 + seen.widening;
            sum += row_under_coat(g, xi, wi, wo, widening) * light.irradiance * wi.z;
        }
        if MIRRORS {
            sum += lamp_mirrored(light, footprint(kept_hit(corner, kept), 1.0), wo);
        }
    }
    return encoded(sum * frame.exposure);
}

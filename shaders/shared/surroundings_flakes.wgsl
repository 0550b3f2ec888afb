// Twin of render/surroundings_flakes.rs.

const SHINING: u32 = 24u;
const ROUGHNESS: f32 = 0.27;
const COSINE: u32 = 4u;
const LAMPS: u32 = 12u;
const LUMINANCE: vec3<f32> = vec3<f32>(0.2126, 0.7152, 0.0722);

struct SurroundingsTap {
    wi: vec3<f32>,
    // 0: below the horizon, or dark.
    solid_angle: f32,
    light: vec3<f32>,
}

fn surroundings_tap_count() -> u32 {
    return SHINING + COSINE + select(0u, LAMPS, environment_has_lamps());
}

fn surroundings_tap(to_world: mat3x3<f32>, wo: vec3<f32>, k: u32) -> SurroundingsTap {
    var wi: vec3<f32>;
    if k < SHINING {
        wi = mirrored(wo, shining(k));
    } else if k < SHINING + COSINE {
        let at = disc_point(k - SHINING, COSINE);
        wi = vec3<f32>(at, sqrt(1.0 - dot(at, at)));
    } else {
        wi = environment_sample(lamp_point(k - SHINING - COSINE)) * to_world;
    }
    let world = to_world * wi;
    let light = environment_radiance(world);
    if wi.z <= 0.0 || all(light == vec3<f32>(0.0)) {
        return SurroundingsTap(wi, 0.0, light);
    }
    var density = f32(SHINING) * half_vector_density(lobe_geometry(wi, wo), ROUGHNESS)
        + f32(COSINE) * FRAC_1_PI * wi.z;
    if environment_has_lamps() {
        density += f32(LAMPS) * environment_density(world);
    }
    return SurroundingsTap(wi, 1.0 / density, light);
}

fn shining(k: u32) -> vec3<f32> {
    return half_vector(ROUGHNESS, vec2<f32>((f32(k) + 0.5) / f32(SHINING), golden(k)));
}

fn golden(k: u32) -> f32 {
    return unit(k * 2654435769u);
}

fn lamp_point(k: u32) -> vec2<f32> {
    return vec2<f32>((f32(k) + 0.5) / f32(LAMPS), golden(k));
}

// Radiance that the flakes of a point add to their mean towards `wo` under the surroundings, of the footprint's taps `first` to `end`.
// `to_world`: columns are the local
// axes. `to_surface`: from the world to the frame that is fixed to the surface.
fn surroundings_sparkle(
    surface: Surface,
    to_world: mat3x3<f32>,
    to_surface: mat3x3<f32>,
    wo: vec3<f32>,
    first: u32,
    end: u32,
) -> vec3<f32> {
    if wo.z <= 0.0 || paint.flakes.levels == 0u || first >= end {
        return vec3<f32>(0.0);
    }
    let turn = to_surface * to_world;
    let d = detail(surface.footprint);
    let count = surroundings_tap_count();
    var fluctuation = vec3<f32>(0.0);
    var patches: array<LightPatch, MOST_PATCHES>;
    for (var k = first; k < min(end, d.count); k++) {
        let draw = flake_draw(surface, d, k);
        for (var l = 0u; l < count; l++) {
            let tap = surroundings_tap(to_world, wo, l);
            if tap.solid_angle == 0.0 {
                continue;
            }
            let weight = transmittance(tap.wi.z, wo.z) * tap.wi.z * tap.solid_angle;
            let half = projected_half(turn * tap.wi, turn * wo);
            let seen = flake_view(geometry(coat_inner(tap.wi), coat_inner(wo)), half);
            fluctuation += tap.light * fluctuation_of_draw(draw, d, seen) * weight;
            if k == first {
                let area = tap.solid_angle * half_stretch(tap.wi, wo);
                patches[l] = flake_patch(d, seen, area, weight * dot(tap.light, LUMINANCE));
            }
        }
    }
    return fluctuation * (kept(&patches, count) / f32(d.count));
}

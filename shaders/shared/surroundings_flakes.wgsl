// Twin of render/surroundings_flakes.rs.

const SHINING: u32 = 24u;
const ROUGHNESS: f32 = 0.27;
const COSINE: u32 = 4u;
const GROUP_LOOKS: f32 = 400.0;
const LUMINANCE: vec3<f32> = vec3<f32>(0.2126, 0.7152, 0.0722);

struct SurroundingsTap {
    wi: vec3<f32>,
    // 0: below the horizon, or dark.
    solid_angle: f32,
    light: vec3<f32>,
    alone: f32,
    own: f32,
}

fn surroundings_tap_count() -> u32 {
    return SHINING + COSINE + scene.lamp_group_count;
}

fn surroundings_tap(to_world: mat3x3<f32>, wo: vec3<f32>, k: u32) -> SurroundingsTap {
    if k >= SHINING + COSINE {
        return group_tap(scene.lamp_groups[k - SHINING - COSINE], to_world, wo);
    }
    var wi: vec3<f32>;
    if k < SHINING {
        wi = mirrored(wo, shining(k));
    } else {
        let at = disc_point(k - SHINING, COSINE);
        wi = vec3<f32>(at, sqrt(1.0 - dot(at, at)));
    }
    if wi.z <= 0.0 {
        return SurroundingsTap(wi, 0.0, vec3<f32>(0.0), 0.0, 1.0);
    }
    let density = shining_density(wi, wo);
    let seen = environment_radiance(to_world * wi);
    let luminance = dot(seen, LUMINANCE);
    let dim = dim_share(luminance);
    let kept = 1.0 - (1.0 - dim) * groups_share(luminance * (1.0 - dim), density);
    let solid_angle = 1.0 / density;
    let light = seen * (kept * solid_angle);
    return SurroundingsTap(wi, select(solid_angle, 0.0, all(light == vec3<f32>(0.0))), light, 0.0, 1.0);
}

fn group_tap(group: LampGroup, to_world: mat3x3<f32>, wo: vec3<f32>) -> SurroundingsTap {
    let wi = group.direction * to_world;
    if wi.z <= 0.0 {
        return SurroundingsTap(wi, 0.0, vec3<f32>(0.0), 0.0, 1.0);
    }
    let light = group.light * groups_share(group.luminance, shining_density(wi, wo));
    return SurroundingsTap(wi, group.solid_angle, light, group.alone, group.own);
}

fn shining_density(wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    return f32(SHINING) * half_vector_density(lobe_geometry(wi, wo), ROUGHNESS) + f32(COSINE) * FRAC_1_PI * wi.z;
}

fn groups_share(luminance: f32, density: f32) -> f32 {
    if luminance <= 0.0 {
        return 0.0;
    }
    let groups = GROUP_LOOKS * luminance / scene.lamp_power;
    return groups / (groups + density);
}

fn shining(k: u32) -> vec3<f32> {
    return half_vector(ROUGHNESS, vec2<f32>((f32(k) + 0.5) / f32(SHINING), golden(k)));
}

fn golden(k: u32) -> f32 {
    return unit(k * 2654435769u);
}

// Radiance that the flakes of a point add to their mean towards `wo` under the surroundings, of the footprint's taps `first` to
// `end`. `to_world`: columns are the local axes. `to_surface`: from the world to the frame that is fixed to the surface.
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
            let weight = transmittance(tap.wi.z, wo.z) * tap.wi.z;
            let half = projected_half(turn * tap.wi, turn * wo);
            let seen = flake_view(geometry(coat_inner(tap.wi), coat_inner(wo)), half);
            fluctuation += tap.light * fluctuation_of_draw(draw, d, seen) * weight;
            if k == first {
                let area = tap.solid_angle * half_stretch(tap.wi, wo);
                patches[l] = flake_patch(d, seen, area, weight * dot(tap.light, LUMINANCE));
                patches[l].alone = tap.alone;
                patches[l].own_variance = tap.own * patches[l].variance;
            }
        }
    }
    return fluctuation * (kept(&patches, count) / f32(d.count));
}

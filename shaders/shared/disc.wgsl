// Twin of render/disc.rs.

const WIDE: vec2<f32> = vec2<f32>(0.0227, 0.0958);
const RINGS: vec2<f32> = vec2<f32>(0.467707, 0.831039);
const FRAC_1_SQRT_2: f32 = 0.70710677;

struct Disc {
    direction: vec3<f32>,
    sine: f32,
}

struct DiscTap {
    wi: vec3<f32>,
    weight: f32,
    solid_angle: f32,
}

fn disc_tap_count(disc: Disc) -> u32 {
    return select(select(1u, 4u, disc.sine > WIDE.x), 16u, disc.sine > WIDE.y);
}

fn disc_tap(disc: Disc, k: u32, count: u32) -> DiscTap {
    let axis = disc.direction;
    var across = vec3<f32>(0.0, axis.z, -axis.y);
    let l = length(across);
    across = select(vec3<f32>(0.0, 1.0, 0.0), across / l, l > 0.0);
    let at = disc_point(k, count) * disc.sine;
    let along = sqrt(max(1.0 - dot(at, at), 0.0));
    let share = 1.0 / (f32(count) * along);
    var wi = axis;
    if count > 1u {
        wi = across * at.x + cross(axis, across) * at.y + axis * along;
    }
    return DiscTap(wi, wi.z * share, 2.0 * FRAC_PI_2 * disc.sine * disc.sine * share);
}

fn disc_point(k: u32, count: u32) -> vec2<f32> {
    if count == 1u {
        return vec2<f32>(0.0);
    }
    if count == 4u {
        return FRAC_1_SQRT_2 * circle((f32(k) + 0.5) / 4.0);
    }
    if k == 0u {
        return vec2<f32>(0.0);
    }
    if k < 6u {
        return RINGS.x * circle((f32(k) - 1.0) / 5.0);
    }
    return RINGS.y * circle((f32(k) - 5.75) / 10.0);
}

// Radiance towards `wo` over the irradiance of a surface that faces the disc; the ideal mirror left out.
fn disc_radiance(surface: Surface, disc: Disc, wo: vec3<f32>, widening: f32, sparkles: bool) -> vec3<f32> {
    if wo.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    var sum = vec3<f32>(0.0);
    if disc.direction.z > 0.0 {
        sum += coat_gloss(disc.direction, wo, widening) * disc.direction.z;
    }
    var d = Detail(vec2<f32>(0.0), 1u, 0u, 0.0);
    if sparkles {
        d = detail(surface.footprint);
    }
    if !WIDE_DISCS {
        let part = disc_part(surface, d, disc_tap(disc, 0u, 1u), wo, 0.0, sparkles);
        return sum + part.smooth_part + part.fluctuation * kept_of_one(part.light);
    }
    let count = disc_tap_count(disc);
    let of_patch = select(disc.sine * disc.sine / (8.0 * f32(count)), 0.0, count == 1u);
    var fluctuation = vec3<f32>(0.0);
    var patches: array<LightPatch, MOST_PATCHES>;
    for (var k = 0u; k < count; k++) {
        let part = disc_part(surface, d, disc_tap(disc, k, count), wo, of_patch, sparkles);
        sum += part.smooth_part;
        fluctuation += part.fluctuation;
        patches[k] = part.light;
    }
    return sum + fluctuation * kept(&patches, count);
}

// What the light of one patch adds.
struct DiscPart {
    smooth_part: vec3<f32>,
    fluctuation: vec3<f32>,
    light: LightPatch,
}

// Of a patch above the horizon; `of_patch` widens the lobes of the base.
fn disc_part(surface: Surface, d: Detail, tap: DiscTap, wo: vec3<f32>, of_patch: f32, sparkles: bool) -> DiscPart {
    var part: DiscPart;
    if tap.wi.z <= 0.0 {
        return part;
    }
    let g = geometry(coat_inner(tap.wi), coat_inner(wo));
    let weight = transmittance(tap.wi.z, wo.z) * tap.weight;
    var mean = vec3<f32>(0.0);
    if sparkles {
        let seen = flake_view(g, projected_half(tap.wi, wo));
        mean = seen.mean;
        part.fluctuation = (xi_of_taps(surface, d, seen.slices, seen.half) - mean) * weight;
        part.light = flake_patch(d, seen, tap.solid_angle * half_stretch(tap.wi, wo), weight);
    }
    part.smooth_part = base(g, of_patch, mean) * weight;
    return part;
}

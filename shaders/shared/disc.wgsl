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
fn disc_radiance(surface: Surface, disc: Disc, wo: vec3<f32>, widening: f32) -> vec3<f32> {
    let sparkles = paint.flakes.levels > 0u;
    var d = Detail(vec2<f32>(0.0), 1u, 0u, 0.0);
    if sparkles {
        d = detail(surface.footprint);
    }
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < d.count; k++) {
        var draw: Draw;
        if sparkles {
            draw = flake_draw(surface, d, k);
        }
        sum += disc_part(disc, wo, widening, draw, d, sparkles, k == 0u);
    }
    return sum;
}

// The part of it that hangs on one draw of the flakes; with the first, what hangs on none.
fn disc_part(
    disc: Disc,
    wo: vec3<f32>,
    widening: f32,
    draw: Draw,
    d: Detail,
    sparkles: bool,
    first: bool,
) -> vec3<f32> {
    if wo.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    var sum = vec3<f32>(0.0);
    if first && disc.direction.z > 0.0 {
        sum += coat_gloss(disc.direction, wo, widening) * disc.direction.z;
    }
    let count = disc_tap_count(disc);
    let of_patch = select(disc.sine * disc.sine / (8.0 * f32(count)), 0.0, count == 1u);
    var fluctuation = vec3<f32>(0.0);
    var patches: array<LightPatch, MOST_PATCHES>;
    for (var k = 0u; k < count; k++) {
        let tap = disc_tap(disc, k, count);
        if tap.wi.z <= 0.0 {
            continue;
        }
        let g = geometry(coat_inner(tap.wi), coat_inner(wo));
        let weight = transmittance(tap.wi.z, wo.z) * tap.weight;
        var mean = vec3<f32>(0.0);
        if sparkles {
            let seen = flake_view(g, projected_half(tap.wi, wo));
            mean = seen.mean;
            fluctuation += fluctuation_of_draw(draw, d, seen) * weight;
            patches[k] = flake_patch(d, seen, tap.solid_angle * half_stretch(tap.wi, wo), weight);
        }
        if first {
            sum += base(g, of_patch, mean) * weight;
        }
    }
    if sparkles {
        sum += fluctuation * (kept(&patches, count) / f32(d.count));
    }
    return sum;
}

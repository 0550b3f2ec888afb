// Twin of render/flake_layout.rs.

const MAX_TAPS: u32 = 16u;
const SQRT_2: f32 = 1.4142135;

struct Detail {
    // Long side of the footprint, millimetres.
    long: vec2<f32>,
    count: u32,
    // The finer of two levels, and how far on the way to the next.
    level: u32,
    fraction: f32,
}

fn detail(footprint: array<vec2<f32>, 2>) -> Detail {
    let a = footprint[0];
    let b = footprint[1];
    let side = long_side(a, b);
    let taps = min(floor(side.ratio + 0.5), length(side.long) / paint.flakes.texel_mm);
    let count = clamp(u32(taps), 1u, MAX_TAPS);
    let area = abs(a.x * b.y - a.y * b.x) / f32(count);
    let about = levels_about(max(sqrt(area) / paint.flakes.texel_mm, 1.0));
    return Detail(side.long, count, about.level, about.fraction);
}

// The finer of two levels, and how far on the way to the next.
struct Levels {
    level: u32,
    fraction: f32,
}

fn levels_about(side: f32) -> Levels {
    let last = paint.flakes.levels - 1u;
    // The exponent is the whole part of the logarithm.
    let level = min((bitcast<u32>(side) >> 23u) - 127u, last);
    let left = sqrt(f32(1u << level) / side);
    return Levels(level, select(clamp((1.0 - left) * (2.0 + SQRT_2), 0.0, 1.0), 0.0, level == last));
}

fn flake_slices(theta_h: f32, theta_i: f32) -> SliceTaps {
    var taps = grid_taps(theta_h, theta_i);
    if paint.flakes.missing_is_nearest != 0u {
        let bin = vec2<u32>(grid_place(theta_h, theta_i));
        for (var corner = 0u; corner < 4u; corner++) {
            if taps.slice[corner] == NO_SLICE {
                taps.slice[corner] = nearest_slice(bin.x + (corner & 1u), bin.y + (corner >> 1u));
            }
        }
    }
    return taps;
}

fn nearest_slice(theta_h: u32, theta_i: u32) -> u32 {
    let row = min(theta_i, paint.flakes.rows - 1u);
    return grid_slice(min(theta_h, grid_row_length(row) - 1u), row);
}

struct LongSide {
    long: vec2<f32>,
    ratio: f32,
}

fn long_side(a: vec2<f32>, b: vec2<f32>) -> LongSide {
    let aa = dot(a, a);
    let bb = dot(b, b);
    let ab = dot(a, b);
    let mean = 0.5 * (aa + bb);
    let half_difference = 0.5 * (aa - bb);
    let spread = length(vec2<f32>(half_difference, ab));
    let long = sqrt(mean + spread);
    let short = sqrt(max(mean - spread, 0.0));
    if long == 0.0 {
        return LongSide(vec2<f32>(0.0), 1.0);
    }
    let turn = half_turn(half_difference, ab, spread);
    return LongSide(a * turn.x + b * turn.y, long / max(short, long * 1e-3));
}

// Cosine and sine of half the angle of (x, y), of that length, without the angle; (1, 0) for no length.
fn half_turn(x: f32, y: f32, hypotenuse: f32) -> vec2<f32> {
    if hypotenuse == 0.0 {
        return vec2<f32>(1.0, 0.0);
    }
    // Of the two forms the one without cancellation.
    let sign = select(1.0, -1.0, y < 0.0);
    let half = select(vec2<f32>(abs(y), sign * (hypotenuse - x)), vec2<f32>(hypotenuse + x, y), x >= 0.0);
    return normalize(half);
}

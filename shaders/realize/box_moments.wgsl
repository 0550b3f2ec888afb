// Mean and variance of the colors of a box: twin of cluster/mean.rs and cluster/deviation.rs, in f32.

struct BoxMoments {
    mean: vec3<f32>,
    variance: vec3<f32>,
}

const NODES: vec3<f32> = vec3<f32>(-0.7745967, 0.0, 0.7745967);
const NODE_WEIGHTS: vec3<f32> = vec3<f32>(0.2777778, 0.4444444, 0.2777778);

// Twin of `Moments::of` of cluster/deviation.rs.
fn box_moments(corners: LabBox) -> BoxMoments {
    let half = 0.5 * (corners.high - corners.low);
    let middle = 0.5 * (corners.high + corners.low);
    let of_x = vec3<f32>(RED_FROM_RELATIVE.x, GREEN_FROM_RELATIVE.x, BLUE_FROM_RELATIVE.x);
    let of_z = vec3<f32>(RED_FROM_RELATIVE.z, GREEN_FROM_RELATIVE.z, BLUE_FROM_RELATIVE.z);
    var mean = vec3<f32>(0.0);
    var rgb = array<vec3<f32>, 3>();
    var rest = vec3<f32>(0.0);
    for (var k = 0u; k < 3u; k++) {
        let y = (middle.x + half.x * NODES[k]) / 116.0;
        let x = spread(y + middle.y / 500.0, half.y / 500.0);
        let z = spread(y - middle.z / 200.0, half.z / 200.0);
        rgb[k] = rgb_from_relative(vec3<f32>(x.x, expand(y), z.x));
        mean += NODE_WEIGHTS[k] * rgb[k];
        rest += NODE_WEIGHTS[k] * (of_x * of_x * x.y + of_z * of_z * z.y);
    }
    for (var k = 0u; k < 3u; k++) {
        rest += NODE_WEIGHTS[k] * (rgb[k] - mean) * (rgb[k] - mean);
    }
    return BoxMoments(mean * FRAC_1_PI, rest * (FRAC_1_PI * FRAC_1_PI));
}

fn rgb_from_relative(relative: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        dot(RED_FROM_RELATIVE, relative),
        dot(GREEN_FROM_RELATIVE, relative),
        dot(BLUE_FROM_RELATIVE, relative),
    );
}

// Mean and variance of `expand` at mean + U(-half, half).
fn spread(mean: f32, half: f32) -> vec2<f32> {
    let reach = abs(half);
    let square = half * half;
    let joint = DELTA - ZERO;
    if abs(mean) - reach >= joint {
        let root = abs(mean) + ZERO;
        let power = root * root;
        let variance = square * (3.0 * power * power + square * (2.0 * power + square / 7.0));
        let value = root * (power + square);
        return vec2<f32>(select(value, -value, mean < 0.0), variance);
    }
    if abs(mean) + reach <= joint {
        return vec2<f32>(SLOPE * mean, SLOPE * SLOPE * square / 3.0);
    }
    let values = vec3<f32>(expand(mean + half * NODES.x), expand(mean), expand(mean + half * NODES.z));
    let first = dot(NODE_WEIGHTS, values);
    return vec2<f32>(first, dot(NODE_WEIGHTS, (values - first) * (values - first)));
}

// Twin of `mean_of_box` of cluster/mean.rs.
fn mean_of_box(corners: LabBox) -> vec3<f32> {
    let half = 0.5 * abs(corners.high - corners.low);
    let middle = 0.5 * (corners.high + corners.low);
    let y = middle.x / 116.0;
    let y_half = half.x / 116.0;
    let relative = vec3<f32>(
        mean_expanded(y + middle.y / 500.0, y_half, half.y / 500.0),
        mean_expanded(y, y_half, 0.0),
        mean_expanded(y - middle.z / 200.0, y_half, half.z / 200.0),
    );
    return rgb_from_relative(relative) * FRAC_1_PI;
}

// Expectation of `expand` at mean + U(-a, a) + U(-b, b).
fn mean_expanded(mean: f32, a: f32, b: f32) -> f32 {
    let joint = DELTA - ZERO;
    let reach = a + b;
    let root = abs(mean) + ZERO;
    let cube = root * root * root + root * (a * a + b * b);
    let is_cubic = abs(mean) - reach >= joint;
    let is_straight = abs(mean) + reach <= joint;
    // Few boxes lie across a joint. A loop ends early on a software renderer, a branch does not.
    let pieces = select(6u, 0u, is_cubic || is_straight);
    let plateau = abs(a - b);
    var beyond = 0.0;
    for (var piece = 0u; piece < pieces; piece++) {
        // Behind one joint, then the other: the straight line, and what the cube is above it.
        let sign = select(-1.0, 1.0, piece < 3u);
        let middle = sign * mean - joint;
        let k = piece % 3u;
        let start = max(middle + select(select(plateau, -plateau, k == 1u), -reach, k == 0u), 0.0);
        let stop = max(middle + select(select(reach, plateau, k == 1u), -plateau, k == 0u), 0.0);
        let half = 0.5 * (stop - start);
        var gauss = 0.0;
        for (var node = 0u; node < 3u; node++) {
            let t = 0.5 * (start + stop) + half * NODES[node];
            gauss += NODE_WEIGHTS[node] * density_of_sum(abs(t - middle), a, b) * t * t * (3.0 * DELTA + t);
        }
        beyond += sign * 2.0 * half * gauss;
    }
    return select(SLOPE * mean + beyond, select(cube, -cube, mean < 0.0), is_cubic);
}

// Density of U(-a, a) + U(-b, b) at a distance from its middle.
fn density_of_sum(distance: f32, a: f32, b: f32) -> f32 {
    if distance <= abs(a - b) || min(a, b) == 0.0 {
        return 0.5 / max(a, b);
    }
    return 0.25 * max(a + b - distance, 0.0) / (a * b);
}

// Entry points: a mix at given weights becomes a paint, in place; twin of mix/realization.rs, of cluster/bands.rs, deviation.rs and
// mean.rs and of sampler/exact.rs, in f32. A workgroup a slice.
//
// Every arc keeps as many places in its slice as it has groups of paints, so that nothing moves when weights change; where
// fewer are there, the last are of no probability, and are never drawn. Probabilities before an arc do not hang on weights: they
// come summed in f64.

struct Blend {
    // Per paint: weight; share of the probability; what the weight is beyond the share.
    weights: array<vec4<f32>, 8>,
    paints: u32,
    // The paint that keeps what does not go.
    source: u32,
    // Below: 1: probability goes over between groups.
    is_hybrid: u32,
    channels: u32,
    gain: u32,
    // Texels of the color table; as they are where only the flakes' lightness goes.
    colors: u32,
    slices: u32,
    // Words of an arc.
    arc_words: u32,
    // First slice of the coarsest level, whose means all levels have.
    coarsest: u32,
}

const LIGHTNESS: u32 = 1u;
const ALL_BUT_LIGHTNESS: u32 = 2u;
const WHITE_FLAKES: u32 = 3u;

// The source's gain; the blend of all; the one that keeps the contrast.
const SOURCES_GAIN: u32 = 0u;
const OWN_GAIN: u32 = 1u;

struct MixSlice {
    first_arc: u32,
    arcs: u32,
    first_cluster: u32,
    clusters: u32,
    first_part: u32,
    parts: u32,
    first_box: u32,
    // Of its moments, a paint after the other.
    first_moments: u32,
}

// In `arcs` as words: `before`, `before_rest`, `probability`, `groups`; then, two a word, `place` and the number of the box of
// every paint.
struct Arc {
    // Probability of all arcs before it, in two parts, and its own.
    before: f32,
    before_rest: f32,
    probability: f32,
    // Four bits a paint.
    groups: u32,
    // Its first place among the clusters of the slice.
    place: u32,
}

struct Corners {
    low: vec3<f32>,
    high: vec3<f32>,
}

// Mean and standard deviation of a paint's slice, 1/sr, its gain, and how it remembers the half vector.
struct PaintMoments {
    mean: array<f32, 3>,
    deviation: array<f32, 3>,
    gain: array<f32, 3>,
    lasting: f32,
    fading: array<f32, 4>,
}

@group(0) @binding(0) var<uniform> blend: Blend;
@group(0) @binding(1) var<storage, read> mix_slices: array<MixSlice>;
@group(0) @binding(2) var<storage, read> moments: array<PaintMoments>;

@group(1) @binding(0) var<storage, read> arcs: array<u32>;
// Two corners a box.
@group(1) @binding(1) var<storage, read> boxes: array<array<f32, 6>>;
@group(1) @binding(2) var<storage, read_write> realized_slices: array<Slice>;
@group(1) @binding(3) var<storage, read_write> realized_clusters: array<Cluster>;
@group(1) @binding(4) var<storage, read_write> realized_guide: array<u32>;
@group(1) @binding(5) var<storage, read_write> realized_ramps: array<Ramp>;

// Color tables of all paints, signed Lab, one after the other.
@group(1) @binding(0) var<storage, read> color_labs: array<array<f32, 3>>;
// The color table, then the mean of every slice.
@group(1) @binding(1) var<storage, read_write> realized_colors: array<array<f32, 3>>;

const THREADS: u32 = 64u;
const GROUPS: u32 = 16u;
const MOST_PAINTS: u32 = 8u;
// As in mix/realization.rs.
const FADE: f32 = 0.2;
// As in cluster/bands.rs.
const LEAST_BAND: f32 = 1e-8;
// Shares that sum to 1 up to rounding.
const ALL: f32 = 0.999999;

var<workgroup> mean_sums: array<vec3<f32>, 64>;
var<workgroup> mean_rests: array<vec3<f32>, 64>;

@compute @workgroup_size(64)
fn realize_slice(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32) {
    let number = group.y * groups.x + group.x;
    if number >= blend.slices {
        return;
    }
    let slice = mix_slices[number];
    if slice.arcs == 0u {
        return;
    }
    for (var k = thread; k < slice.arcs; k += THREADS) {
        realize_arc(slice, slice.first_arc + k);
    }
    storageBarrier();
    // Until their sums take that place, clusters hold their own probability.
    let mean = mean_of_slice(slice, thread);
    let square = square_of_slice(slice, mean, thread);
    if thread == 0u {
        let gain = gain_of_slice(slice, mean, sqrt(max(square, vec3<f32>(0.0))));
        realized_slices[number].gain = gain;
        realized_slices[number].offset = mean_of_paints(slice) - gain * mean;
        realized_slices[number].has_ramps = blend.is_hybrid;
        remember(number, slice);
    }
    for (var k = thread; k < slice.arcs; k += THREADS) {
        sum_arc(slice, slice.first_arc + k);
    }
    storageBarrier();
    // Two parts a word.
    for (var k = thread; k < (slice.parts + 1u) / 2u; k += THREADS) {
        let first = first_candidate(slice, 2u * k);
        let second = first_candidate(slice, 2u * k + 1u);
        realized_guide[slice.first_part / 2u + k] = first | (second << 16u);
    }
}

@compute @workgroup_size(64)
fn realize_colors(@builtin(global_invocation_id) id: vec3<u32>) {
    let number = id.x - blend.colors + blend.coarsest;
    if id.x >= blend.colors && number < blend.slices {
        let slice = mix_slices[number];
        realized_colors[id.x] = components(select(mean_of_paints(slice), vec3<f32>(0.0), slice.arcs == 0u));
    }
    if id.x < blend.colors {
        var lab = vec3<f32>(0.0);
        for (var k = 0u; k < blend.paints; k++) {
            let weight = select(blend.weights[k].x, f32(k == blend.source), blend.channels == LIGHTNESS);
            lab += weight * vector(color_labs[k * blend.colors + id.x]);
        }
        realized_colors[id.x] = components(rgb_from_lab_f32(lab));
    }
}

fn components(v: vec3<f32>) -> array<f32, 3> {
    return array<f32, 3>(v.x, v.y, v.z);
}

fn group_of(groups: u32, paint: u32) -> u32 {
    return (groups >> (4u * paint)) & 15u;
}

fn arc_at(arc: u32) -> Arc {
    let first = arc * blend.arc_words;
    return Arc(
        bitcast<f32>(arcs[first]),
        bitcast<f32>(arcs[first + 1u]),
        bitcast<f32>(arcs[first + 2u]),
        arcs[first + 3u],
        arc_half(arc, 0u),
    );
}

// One of the half words at the end of an arc.
fn arc_half(arc: u32, k: u32) -> u32 {
    return (arcs[arc * blend.arc_words + 4u + (k >> 1u)] >> (16u * (k & 1u))) & 0xffffu;
}

fn box_of(slice: MixSlice, arc: u32, paint: u32) -> Corners {
    let b = boxes[slice.first_box + arc_half(arc, 1u + paint)];
    return Corners(vec3<f32>(b[0], b[1], b[2]), vec3<f32>(b[3], b[4], b[5]));
}

// Clusters and ramps of an arc.
fn realize_arc(slice: MixSlice, arc: u32) {
    let a = arc_at(arc);
    let first = slice.first_cluster + a.place;
    if blend.is_hybrid == 0u || a.groups == 0u {
        write_cluster(first, a.probability, colored(slice, arc, traveled(slice, arc, 0u, 0.0)), Ramp(0.0, 0.0));
        fill_places(first + 1u, end_of_arc(slice, arc));
        return;
    }
    var shares = array<f32, 16>();
    for (var k = 0u; k < blend.paints; k++) {
        shares[group_of(a.groups, k)] += blend.weights[k].y;
    }
    var count = 0u;
    for (var g = 0u; g < GROUPS; g++) {
        count += u32(a.probability * shares[g] > 0.0);
    }
    let half_width = FADE * a.probability;
    let is_linked = count > 1u && half_width > LEAST_BAND;
    var before = 0.0;
    var done = 0u;
    for (var g = 0u; g < GROUPS; g++) {
        if a.probability * shares[g] > 0.0 {
            before += shares[g];
            done++;
            var ramp = Ramp(0.0, 0.0);
            if is_linked && done < count {
                let sides = a.probability * vec2<f32>(before, max(1.0 - before, 0.0));
                ramp = Ramp(0.5 / half_width, middle_of(sides, half_width));
            }
            let corners = colored(slice, arc, traveled(slice, arc, g, shares[g]));
            write_cluster(first + done - 1u, a.probability * shares[g], corners, ramp);
        }
    }
    fill_places(first + done, end_of_arc(slice, arc));
}

// Behind its last place.
fn end_of_arc(slice: MixSlice, arc: u32) -> u32 {
    if arc + 1u == slice.first_arc + slice.arcs {
        return slice.first_cluster + slice.clusters;
    }
    return slice.first_cluster + arc_half(arc + 1u, 0u);
}

fn write_cluster(at: u32, probability: f32, corners: Corners, ramp: Ramp) {
    realized_clusters[at].cumulative = probability;
    realized_clusters[at].min = components(corners.low);
    realized_clusters[at].max = components(corners.high);
    realized_ramps[at] = ramp;
}

// Places that are left, of no probability.
fn fill_places(first: u32, end: u32) {
    for (var k = first; k < end; k++) {
        write_cluster(k, 0.0, Corners(vec3<f32>(0.0), vec3<f32>(0.0)), Ramp(0.0, 0.0));
    }
}

// The clusters of an arc: from probabilities to their sums.
fn sum_arc(slice: MixSlice, arc: u32) {
    let a = arc_at(arc);
    let end = end_of_arc(slice, arc);
    var sum = 0.0;
    for (var k = slice.first_cluster + a.place; k < end; k++) {
        sum += realized_clusters[k].cumulative;
        // The last of the slice, and what fills up behind it, end at 1 whatever the rounding.
        let is_end = sum >= a.probability * ALL && arc + 1u == slice.first_arc + slice.arcs;
        realized_clusters[k].cumulative = select(a.before + (a.before_rest + sum), 1.0, is_end);
    }
}

// The box of a group of paints of a share; a share of 0: of all paints by their weights.
fn traveled(slice: MixSlice, arc: u32, group: u32, share: f32) -> Corners {
    let groups = arc_at(arc).groups;
    var is_first = true;
    var start: Corners;
    var corners: Corners;
    for (var k = 0u; k < blend.paints; k++) {
        var weight = blend.weights[k].x;
        if share > 0.0 {
            weight = select(0.0, blend.weights[k].y / share, group_of(groups, k) == group) + blend.weights[k].z;
        }
        if weight != 0.0 {
            let own = box_of(slice, arc, k);
            if is_first {
                start = own;
                corners = own;
                is_first = false;
            } else {
                corners.low += weight * (own.low - start.low);
                corners.high += weight * (own.high - start.high);
            }
        }
    }
    // Past the narrower paint a box would turn inside out: it stays flat.
    let flat = 0.5 * (corners.low + corners.high);
    let inverted = corners.low > corners.high;
    return Corners(select(corners.low, flat, inverted), select(corners.high, flat, inverted));
}

// A box with the channels that do not go taken from the source.
fn colored(slice: MixSlice, arc: u32, corners: Corners) -> Corners {
    let kept = box_of(slice, arc, blend.source);
    switch blend.channels {
        case LIGHTNESS: {
            return Corners(vec3<f32>(corners.low.x, kept.low.yz), vec3<f32>(corners.high.x, kept.high.yz));
        }
        case ALL_BUT_LIGHTNESS: {
            return Corners(vec3<f32>(kept.low.x, corners.low.yz), vec3<f32>(kept.high.x, corners.high.yz));
        }
        case WHITE_FLAKES: {
            return Corners(vec3<f32>(corners.low.x, 0.0, 0.0), vec3<f32>(corners.high.x, 0.0, 0.0));
        }
        default: { return corners; }
    }
}

// First cluster for a part of u.
fn first_candidate(slice: MixSlice, part: u32) -> u32 {
    let at = f32(part) / f32(slice.parts);
    var low = 0u;
    var high = slice.clusters;
    while low < high {
        let middle = (low + high) / 2u;
        if realized_clusters[slice.first_cluster + middle].cumulative <= at {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return min(low, slice.clusters - 1u);
}

fn corners_of(slice: MixSlice, k: u32) -> Corners {
    let c = realized_clusters[slice.first_cluster + k];
    return Corners(vector(c.min), vector(c.max));
}

// Mean of the boxes, 1/sr.
fn mean_of_slice(slice: MixSlice, thread: u32) -> vec3<f32> {
    var sum = Compensated(vec3<f32>(0.0), vec3<f32>(0.0));
    for (var k = thread; k < slice.clusters; k += THREADS) {
        sum = plus(sum, realized_clusters[slice.first_cluster + k].cumulative * mean_of_box(corners_of(slice, k)));
    }
    return sum_of_threads(sum, thread);
}

// A sum and what rounding has left out of it.
struct Compensated {
    sum: vec3<f32>,
    rest: vec3<f32>,
}

// Neumaier's.
fn plus(a: Compensated, b: vec3<f32>) -> Compensated {
    let sum = a.sum + b;
    let rest = select((b - sum) + a.sum, (a.sum - sum) + b, abs(a.sum) >= abs(b));
    return Compensated(sum, a.rest + rest);
}

fn sum_of_threads(own: Compensated, thread: u32) -> vec3<f32> {
    workgroupBarrier();
    mean_sums[thread] = own.sum;
    mean_rests[thread] = own.rest;
    for (var stride = THREADS / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if thread < stride {
            let sum = plus(Compensated(mean_sums[thread], mean_rests[thread]), mean_sums[thread + stride]);
            mean_sums[thread] = sum.sum;
            mean_rests[thread] = sum.rest + mean_rests[thread + stride];
        }
    }
    workgroupBarrier();
    return mean_sums[0] + mean_rests[0];
}

// Twin of `deviation_of_draws`, squared.
fn square_of_slice(slice: MixSlice, mean: vec3<f32>, thread: u32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var k = thread; k < slice.clusters; k += THREADS) {
        let m = box_moments(corners_of(slice, k));
        sum += realized_clusters[slice.first_cluster + k].cumulative * (m.variance + (m.mean - mean) * (m.mean - mean));
    }
    if blend.is_hybrid != 0u {
        for (var k = thread; k < slice.arcs; k += THREADS) {
            sum -= lost_in_bands(slice, slice.first_arc + k);
        }
    }
    return sum_of_threads(Compensated(sum, vec3<f32>(0.0)), thread);
}

// What the bands of an arc take from the mean square.
fn lost_in_bands(slice: MixSlice, arc: u32) -> vec3<f32> {
    let a = arc_at(arc);
    let first = slice.first_cluster + a.place;
    var count = 1u;
    while count < MOST_PAINTS && realized_ramps[first + count - 1u].slope > 0.0 {
        count++;
    }
    var sum = vec3<f32>(0.0);
    if count == 1u {
        return sum;
    }
    let total = a.probability;
    let half_width = FADE * total;
    // Ends of ramps, from the start of the arc.
    var knots = array<f32, 16>();
    var bounds = array<f32, 8>();
    var bound = 0.0;
    for (var j = 0u; j + 1u < count; j++) {
        bound += realized_clusters[first + j].cumulative;
        bounds[j] = bound;
        let middle = realized_ramps[first + j].middle;
        knots[2u * j] = clamp(bounds[j] - 2.0 * half_width * middle, 0.0, total);
        knots[2u * j + 1u] = clamp(bounds[j] + 2.0 * half_width * (1.0 - middle), 0.0, total);
    }
    let last = 2u * (count - 1u);
    knots[last] = 0.0;
    knots[last + 1u] = total;
    for (var j = 1u; j < last + 2u; j++) {
        let value = knots[j];
        var at = j;
        while at > 0u && knots[at - 1u] > value {
            knots[at] = knots[at - 1u];
            at--;
        }
        knots[at] = value;
    }
    for (var j = 1u; j < count; j++) {
        let mine = box_moments(corners_of(slice, first + j - slice.first_cluster));
        for (var l = 0u; l < j; l++) {
            // Products of straight lines are parabolas: Simpson's rule is exact.
            var overlap = 0.0;
            for (var piece = 0u; piece < last + 1u; piece++) {
                let start = knots[piece];
                let stop = knots[piece + 1u];
                var sides = array<f32, 3>(start, 0.5 * (start + stop), stop);
                var simpson = 0.0;
                for (var s = 0u; s < 3u; s++) {
                    let product = share_of(first, count, j, sides[s], &bounds) * share_of(first, count, l, sides[s], &bounds);
                    simpson += select(product, 4.0 * product, s == 1u);
                }
                overlap += (stop - start) / 6.0 * simpson;
            }
            let other = box_moments(corners_of(slice, first + l - slice.first_cluster));
            let mean = mine.mean - other.mean;
            let deviation = sqrt(mine.variance) - sqrt(other.variance);
            sum += overlap * (mean * mean + deviation * deviation);
        }
    }
    return sum;
}

// Share of cluster j of an arc of `count` that starts at cluster `first`, at a distance from the arc's start.
fn share_of(first: u32, count: u32, j: u32, at: f32, bounds: ptr<function, array<f32, 8>>) -> f32 {
    var share = 1.0;
    if j > 0u {
        let ramp = realized_ramps[first + j - 1u];
        share = clamp(ramp.middle + ramp.slope * (at - (*bounds)[j - 1u]), 0.0, 1.0);
    }
    if j + 1u < count {
        let ramp = realized_ramps[first + j];
        share -= clamp(ramp.middle + ramp.slope * (at - (*bounds)[j]), 0.0, 1.0);
    }
    return share;
}

// Twin of `Boundary::middle`.
fn middle_of(sides: vec2<f32>, half_width: f32) -> f32 {
    let nearer = min(sides.x, sides.y);
    if nearer >= half_width {
        return 0.5;
    }
    let short = 1.0 - sqrt(nearer / half_width);
    let cut = 0.5 - 0.5 * short * short;
    return select(1.0 - cut, cut, sides.y < half_width);
}

struct BoxMoments {
    mean: vec3<f32>,
    variance: vec3<f32>,
}

const NODES: vec3<f32> = vec3<f32>(-0.7745967, 0.0, 0.7745967);
const NODE_WEIGHTS: vec3<f32> = vec3<f32>(0.2777778, 0.4444444, 0.2777778);

// Twin of `Moments::of` of cluster/deviation.rs.
fn box_moments(corners: Corners) -> BoxMoments {
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
fn mean_of_box(corners: Corners) -> vec3<f32> {
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
    // Few boxes lie across the joint. A loop ends early on a software renderer, a branch does not.
    let pieces = select(5u, 0u, is_cubic || is_straight);
    let plateau = abs(a - b);
    var knots = array<f32, 6>(mean - reach, mean - plateau, mean + plateau, mean + reach, -joint, joint);
    for (var j = 1u; j < pieces + 1u; j++) {
        let value = knots[j];
        var at = j;
        while at > 0u && knots[at - 1u] > value {
            knots[at] = knots[at - 1u];
            at--;
        }
        knots[at] = value;
    }
    var sum = 0.0;
    for (var j = 0u; j < pieces; j++) {
        let start = max(knots[j], mean - reach);
        let stop = min(knots[j + 1u], mean + reach);
        if stop > start {
            let center = 0.5 * (start + stop);
            let half = 0.5 * (stop - start);
            var gauss = 0.0;
            for (var k = 0u; k < 3u; k++) {
                let x = center + half * NODES[k];
                gauss += NODE_WEIGHTS[k] * density_of_sum(abs(x - mean), a, b) * expand(x);
            }
            sum += 2.0 * half * gauss;
        }
    }
    let smooth_value = select(SLOPE * mean, select(cube, -cube, mean < 0.0), is_cubic);
    return select(sum, smooth_value, pieces == 0u);
}

// Density of U(-a, a) + U(-b, b) at a distance from its middle.
fn density_of_sum(distance: f32, a: f32, b: f32) -> f32 {
    if distance <= abs(a - b) || min(a, b) == 0.0 {
        return 0.5 / max(a, b);
    }
    return 0.25 * max(a + b - distance, 0.0) / (a * b);
}

// What the mean of the slice is to be.
// Amplitudes of what draws remember, blended linearly: those of the realized clusters would take an expansion of each slice anew.
fn remember(number: u32, slice: MixSlice) {
    var lasting = 0.0;
    var fading = vec4<f32>(0.0);
    for (var k = 0u; k < blend.paints; k++) {
        let of_paint = moments[slice.first_moments + k];
        let f = of_paint.fading;
        lasting += blend.weights[k].x * of_paint.lasting;
        fading += blend.weights[k].x * vec4<f32>(f[0], f[1], f[2], f[3]);
    }
    realized_slices[number].lasting = max(lasting, 0.0);
    realized_slices[number].fading = max(fading, vec4<f32>(0.0));
}

fn mean_of_paints(slice: MixSlice) -> vec3<f32> {
    if blend.channels == LIGHTNESS {
        return vector(moments[slice.first_moments + blend.source].mean);
    }
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < blend.paints; k++) {
        sum += blend.weights[k].x * vector(moments[slice.first_moments + k].mean);
    }
    return sum;
}

fn gain_of_slice(slice: MixSlice, mean: vec3<f32>, deviation: vec3<f32>) -> vec3<f32> {
    if blend.gain == SOURCES_GAIN {
        return vector(moments[slice.first_moments + blend.source].gain);
    }
    var own = vec3<f32>(0.0);
    var roots = vec3<f32>(0.0);
    var beyond = vec3<f32>(0.0);
    for (var k = 0u; k < blend.paints; k++) {
        let m = moments[slice.first_moments + k];
        own += blend.weights[k].x * vector(m.gain);
        let wide = vector(m.gain) * vector(m.deviation);
        roots += blend.weights[k].y * cube_root(wide);
        beyond += blend.weights[k].z * wide;
    }
    own = clamp(own, vec3<f32>(0.0), vec3<f32>(1e3));
    if blend.gain == OWN_GAIN {
        return own;
    }
    let wanted = max(roots * roots * roots + beyond, vec3<f32>(0.0));
    // Scatter below the rounding of the mean is none.
    let none = deviation <= 3e-6 * abs(mean) + 1e-30;
    let gain = min(wanted / max(deviation, vec3<f32>(1e-30)), vec3<f32>(1e3));
    return select(gain, own, none | (abs(gain - own) <= 1e-5 * own));
}

// Of numbers that are 0 or more: by the exponent, then Newton's rule.
fn cube_root(x: vec3<f32>) -> vec3<f32> {
    let safe = max(x, vec3<f32>(1e-30));
    var root = bitcast<vec3<f32>>(bitcast<vec3<u32>>(safe) / 3u + 709921077u);
    for (var k = 0u; k < 4u; k++) {
        root = (2.0 * root + safe / (root * root)) / 3.0;
    }
    return select(root, vec3<f32>(0.0), x <= vec3<f32>(0.0));
}

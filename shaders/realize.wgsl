// Entry points: a mix at given weights becomes a paint, in place; twin of mix/realization.rs, of cluster/bands.rs, deviation.rs and
// mean.rs and of sampler/exact.rs, in f32. A workgroup a slice.
//
// Every arc keeps as many places in its slice as it has groups of paints, so that nothing moves when weights change; where
// fewer are there, the last are of no probability, and are never drawn. What weights make of groups is the same for all arcs with
// the same groups, and comes from the CPU.

struct Blend {
    // Per paint: weight; share of the probability; what the weight is beyond the share.
    weights: array<vec4<f32>, 8>,
    paints: u32,
    // The paint that keeps what does not go.
    source: u32,
    // 1: probability goes over between groups.
    is_hybrid: u32,
    // Below.
    channels: u32,
    gain: u32,
    // Texels of the color table; as they are where only the flakes' lightness goes.
    colors: u32,
    slices: u32,
    // First slice of the coarsest level, whose means all levels have.
    coarsest: u32,
    // Slices to be realized or left out.
    planned: u32,
    // Where patterns and arcs begin in `arcs`, and the words of each.
    first_pattern: u32,
    pattern_words: u32,
    first_arc: u32,
    arc_words: u32,
    // Bits of the numbers of an arc.
    place_bits: u32,
    pattern_bits: u32,
    box_bits: u32,
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
    // Of its moments, a paint after the other.
    first_moments: u32,
}

// Mean and standard deviation of a paint's slice, 1/sr, its gain, and how it remembers the half vector.
struct PaintMoments {
    mean: array<f32, 3>,
    deviation: array<f32, 3>,
    gain: array<f32, 3>,
    lasting: f32,
    fading: array<f32, 4>,
    // The first of its boxes.
    first_box: u32,
}

@group(0) @binding(0) var<uniform> blend: Blend;
@group(0) @binding(1) var<storage, read> mix_slices: array<MixSlice>;
@group(0) @binding(2) var<storage, read> moments: array<PaintMoments>;

// What is planned: the number of a slice, and `LEAVE_OUT`; then what weights make of patterns of groups; then arcs.
@group(1) @binding(0) var<storage, read> arcs: array<u32>;
// Clusters of the paints, as they lie in memory, like those that are realized.
@group(1) @binding(1) var<storage, read> boxes: array<vec4<u32>>;
@group(1) @binding(2) var<storage, read_write> realized_slices: array<Slice>;
@group(1) @binding(3) var<storage, read_write> realized_clusters: array<vec4<u32>>;
@group(1) @binding(4) var<storage, read_write> realized_guide: array<u32>;
@group(1) @binding(5) var<storage, read_write> realized_ramps: array<u32>;

// Color tables of all paints, signed Lab, one after the other.
@group(1) @binding(0) var<storage, read> color_labs: array<array<f32, 3>>;
// The color table, then the mean of every slice.
@group(1) @binding(1) var<storage, read_write> realized_colors: array<array<f32, 3>>;

const LEAVE_OUT: u32 = 0x80000000u;
const THREADS: u32 = 64u;
// Threads that sum what the others have seen.
const ROOTS: u32 = 8u;

var<workgroup> scatters: array<Scatter, 64>;

@compute @workgroup_size(64)
fn realize_slice(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32) {
    let plan = group.y * groups.x + group.x;
    if plan >= blend.planned {
        return;
    }
    let number = arcs[plan] & ~LEAVE_OUT;
    if (arcs[plan] & LEAVE_OUT) != 0u {
        if thread == 0u {
            leave_out(number);
        }
        return;
    }
    let slice = mix_slices[number];
    var own: Scatter;
    for (var k = thread; k < slice.arcs; k += THREADS) {
        realize_arc(slice, k, &own);
    }
    storageBarrier();
    // Two parts a word.
    for (var k = thread; k < (slice.parts + 1u) / 2u; k += THREADS) {
        let first = first_candidate(slice, 2u * k);
        let second = first_candidate(slice, 2u * k + 1u);
        realized_guide[slice.first_part / 2u + k] = first | (second << 16u);
    }
    let all = scatter_of_threads(own, thread);
    if thread == 0u {
        let mean = all.sum.sum + all.sum.rest;
        let gain = gain_of_slice(slice, mean, sqrt(max(all.squares, vec3<f32>(0.0))));
        realized_slices[number].gain = gain;
        realized_slices[number].offset = mean_of_paints(slice) - gain * mean;
        realized_slices[number].guide = guide_word(slice.first_part, slice.parts);
        remember(number, slice);
    }
}

// A slice that is not there is not drawn.
fn leave_out(number: u32) {
    realized_slices[number].guide = 0u;
    realized_slices[number].lasting = 0.0;
    realized_slices[number].fading = vec4<f32>(0.0);
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

// First cluster for a part of u: with bands, the first whose color has not gone over at its start.
fn first_candidate(slice: MixSlice, part: u32) -> u32 {
    let at = f32(part) / f32(slice.parts);
    var low = 0u;
    var high = slice.clusters;
    while low < high {
        let middle = (low + high) / 2u;
        if end_of(slice, middle) <= at {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    var first = min(low, slice.clusters - 1u);
    while first > 0u && share_behind(slice, first - 1u, at) < 1.0 {
        first--;
    }
    return first;
}

// Share at u of what lies behind a cluster; 1 without a band.
fn share_behind(slice: MixSlice, k: u32, u: f32) -> f32 {
    let word = realized_ramps[slice.first_cluster + k];
    return select(share(unpack_ramp(word), u - end_of(slice, k)), 1.0, word == 0u);
}

fn end_of(slice: MixSlice, k: u32) -> f32 {
    return cluster_of(realized_clusters[slice.first_cluster + k]).cumulative;
}

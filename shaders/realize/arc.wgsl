// An arc at given weights: its clusters, their bands, and how they scatter. Twin of mix/realization.rs and cluster/bands.rs.
//
// An arc in `arcs`: a word, the probability of all arcs before it in steps of 2^-32; then, bit after bit, its first place among
// the clusters of the slice, the number of its pattern, and the number of every paint's box.

const STEPS_OF_ONE: f32 = 4294967296.0;
// As in mix/realization.rs.
const FADE: f32 = 0.2;
// As in cluster/bands.rs.
const LEAST_BAND: f32 = 1e-8;
const MOST_GROUPS: u32 = 8u;

// Some bits behind the first word of an arc, up to 32.
fn arc_bits(first: u32, offset: u32, width: u32) -> u32 {
    let word = first + 1u + (offset >> 5u);
    let shift = offset & 31u;
    var bits = arcs[word] >> shift;
    if shift + width > 32u {
        bits |= arcs[word + 1u] << (32u - shift);
    }
    return bits & ((1u << width) - 1u);
}

fn number_at(word: u32) -> f32 {
    return bitcast<f32>(arcs[word]);
}

// A group of a pattern in `arcs`: its share of the probability; that of all groups up to its end; the middle of the ramp behind it;
// the weights of all paints' boxes.
fn group_words() -> u32 {
    return 3u + blend.paints;
}

// Clusters and ramps of arc number `k` of a slice; adds them to the scatter.
fn realize_arc(slice: MixSlice, k: u32, scatter: ptr<function, Scatter>) {
    let arc = blend.first_arc + (slice.first_arc + k) * blend.arc_words;
    let is_last = k + 1u == slice.arcs;
    let before = arcs[arc];
    var next = 0u;
    var end = slice.clusters;
    if !is_last {
        next = arcs[arc + blend.arc_words];
        end = arc_bits(arc + blend.arc_words, 0u, blend.place_bits);
    }
    let probability = select(f32(next - before) / STEPS_OF_ONE, 1.0, is_last && before == 0u);
    // In two parts, so that their sum is rounded once.
    let high = f32(before & 0xffffff00u) / STEPS_OF_ONE;
    let rest = f32(before & 0xffu) / STEPS_OF_ONE;
    var place = slice.first_cluster + arc_bits(arc, 0u, blend.place_bits);
    let pattern = blend.first_pattern + blend.pattern_words * arc_bits(arc, blend.place_bits, blend.pattern_bits);
    let count = arcs[pattern];
    let is_linked = count > 1u && FADE * probability > LEAST_BAND;
    let slope = 0.5 / max(FADE * probability, LEAST_BAND);
    var means: array<vec3<f32>, MOST_GROUPS>;
    var deviations: array<vec3<f32>, MOST_GROUPS>;
    var lost = vec3<f32>(0.0);
    var cumulative = 0.0;
    for (var g = 0u; g < count; g++) {
        let group = pattern + 1u + g * group_words();
        let is_end = g + 1u == count;
        let packed = pack_box(box_of_group(slice, arc, group + 3u));
        cumulative = select(high + (rest + probability * number_at(group + 1u)), 1.0, is_last && is_end);
        let ramp = pack_ramp(Ramp(select(slope, 0.0, is_end || !is_linked), number_at(group + 2u)));
        write_cluster(place, cumulative, packed, ramp);
        place++;
        let corners = unpack_box(packed);
        let share = probability * number_at(group);
        let seen = box_moments(corners);
        var own = Scatter(share, seen.mean, share * seen.variance, Compensated(share * mean_of_box(corners), vec3<f32>(0.0)));
        *scatter = joined(*scatter, own);
        if is_linked {
            let deviation = sqrt(seen.variance);
            let overlaps = pattern + 1u + blend.paints * group_words() + g * (g - 1u) / 2u;
            for (var l = 0u; l < g; l++) {
                let apart = seen.mean - means[l];
                let wider = deviation - deviations[l];
                lost += number_at(overlaps + l) * (apart * apart + wider * wider);
            }
            means[g] = seen.mean;
            deviations[g] = deviation;
        }
    }
    (*scatter).squares -= probability * lost;
    // Places that are left are never drawn.
    for (; place < slice.first_cluster + end; place++) {
        write_cluster(place, cumulative, array<u32, 3>(0u, 0u, 0u), 0u);
    }
}

fn write_cluster(at: u32, cumulative: f32, corners: array<u32, 3>, ramp: u32) {
    realized_clusters[at] = vec4<u32>(bitcast<u32>(cumulative), corners[0], corners[1], corners[2]);
    realized_ramps[at] = ramp;
}

fn box_of(slice: MixSlice, arc: u32, paint: u32) -> LabBox {
    let number = arc_bits(arc, blend.place_bits + blend.pattern_bits + paint * blend.box_bits, blend.box_bits);
    return unpack_box(cluster_of(boxes[moments[slice.first_moments + paint].first_box + number]).corners);
}

// The box of a group whose weights begin there, the channels that do not go taken from the source.
fn box_of_group(slice: MixSlice, arc: u32, weights: u32) -> LabBox {
    var corners: LabBox;
    var kept: LabBox;
    for (var k = 0u; k < blend.paints; k++) {
        let own = box_of(slice, arc, k);
        let weight = number_at(weights + k);
        let kept_weight = f32(k == blend.source);
        corners = LabBox(corners.low + weight * own.low, corners.high + weight * own.high);
        kept = LabBox(kept.low + kept_weight * own.low, kept.high + kept_weight * own.high);
    }
    // Past the narrower paint a box would turn inside out: it stays flat.
    let flat = 0.5 * (corners.low + corners.high);
    let inverted = corners.low > corners.high;
    let low = select(corners.low, flat, inverted);
    let high = select(corners.high, flat, inverted);
    if blend.channels == WHITE_FLAKES {
        return LabBox(vec3<f32>(low.x, 0.0, 0.0), vec3<f32>(high.x, 0.0, 0.0));
    }
    let of_lightness = vec3<bool>(true, false, false);
    let stays = (vec3<bool>(blend.channels == LIGHTNESS) & !of_lightness)
        | (vec3<bool>(blend.channels == ALL_BUT_LIGHTNESS) & of_lightness);
    return LabBox(select(low, kept.low, stays), select(high, kept.high, stays));
}

// Twin of sampler/draw.rs and of the ramps of cluster/bands.rs.

fn lab_in_box(cluster: u32, random: vec3<f32>) -> vec3<f32> {
    let corners = unpack_box(clusters[cluster].corners);
    return corners.low + (corners.high - corners.low) * random;
}

// The color drawn by u and `random` from a slice that was not left out: linear Rec.709, 1/sr.
fn color(slice: Slice, u: f32, random: vec3<f32>) -> vec3<f32> {
    let k = lookup(slice, u);
    var reflectance: vec3<f32>;
    if RAMPS && slice.has_ramps != 0u {
        reflectance = faded(slice, k - slice.first_cluster, u, random);
    } else {
        reflectance = rgb_from_lab_f32(lab_in_box(k, random));
    }
    return reflectance * FRAC_1_PI * slice.gain + slice.offset;
}

// The color at u, in cluster `first` of a slice, of the clusters linked to it, each with its share.
fn faded(slice: Slice, first: u32, u: f32, random: vec3<f32>) -> vec3<f32> {
    var k = first;
    while k > 0u && is_linked(slice, k - 1u) && share_behind(slice, k - 1u, u) < 1.0 {
        k--;
    }
    var last = rgb_from_lab_f32(lab_in_box(slice.first_cluster + k, random));
    var sum = last;
    while is_linked(slice, k) && share_behind(slice, k, u) > 0.0 {
        let next = rgb_from_lab_f32(lab_in_box(slice.first_cluster + k + 1u, random));
        sum += share_behind(slice, k, u) * (next - last);
        last = next;
        k++;
    }
    return sum;
}

fn is_linked(slice: Slice, k: u32) -> bool {
    return ramps[slice.first_ramp + k] != 0u;
}

fn share_behind(slice: Slice, k: u32, u: f32) -> f32 {
    let ramp = unpack_ramp(ramps[slice.first_ramp + k]);
    return clamp(ramp.middle + ramp.slope * (u - clusters[slice.first_cluster + k].cumulative), 0.0, 1.0);
}

// Twin of sampler/draw.rs. A software renderer takes as long for a cluster as for all that is made of it, and runs through a loop at
// least once: there is one loop only.

fn lab_in_box(cluster: Cluster, random: vec3<f32>) -> vec3<f32> {
    let corners = unpack_box(cluster.corners);
    return corners.low + (corners.high - corners.low) * random;
}

// The color drawn by u and `random` from a slice that was not left out: linear Rec.709, 1/sr.
fn color(slice: Slice, u: f32, random: vec3<f32>) -> vec3<f32> {
    let first = first_candidate(slice, u);
    var reflectance: vec3<f32>;
    if RAMPS {
        reflectance = faded(first, u, random);
    } else {
        reflectance = rgb_from_lab_f32(lab_in_box(lookup(first, u), random));
    }
    return reflectance * FRAC_1_PI * slice.gain + slice.offset;
}

// The cluster at u, which is `first` or one behind it.
fn lookup(first: u32, u: f32) -> Cluster {
    var k = first;
    var cluster: Cluster;
    loop {
        cluster = cluster_of(clusters[k]);
        if u < cluster.cumulative || cluster.cumulative >= 1.0 {
            break;
        }
        k++;
    }
    return cluster;
}

// The color at u of the cluster there and those linked to it, each with its share, all of them `first` or behind it.
fn faded(first: u32, u: f32, random: vec3<f32>) -> vec3<f32> {
    var k = first;
    // Of what lies behind the cluster before.
    var behind = 1.0;
    var last = vec3<f32>(0.0);
    var sum = vec3<f32>(0.0);
    while behind > 0.0 {
        let cluster = cluster_of(clusters[k]);
        let word = ramps[k - paint.flakes.first_cluster];
        let next = rgb_from_lab_f32(lab_in_box(cluster, random));
        // Nothing is left of the clusters before where all has gone over.
        sum = select(sum + behind * (next - last), next, behind >= 1.0);
        let is_beyond = u >= cluster.cumulative && cluster.cumulative < 1.0;
        let in_band = share(unpack_ramp(word), u - cluster.cumulative);
        behind = select(in_band, select(0.0, 1.0, is_beyond), word == 0u);
        last = next;
        k++;
    }
    return sum;
}

// Entry points: the BRDF of many queries at once.

// Discs have any size, random numbers may repeat, and boxes may have bands.
const WIDE_DISCS: bool = true;
const TEXTURED: bool = true;
const RAMPS: bool = true;

struct Query {
    wi: vec3<f32>,
    widening: f32,
    wo: vec3<f32>,
    surface: Surface,
}

// A query whose flakes are given: one tap, u and the place in the box the same for all half vectors.
struct GivenQuery {
    wi: vec3<f32>,
    widening: f32,
    wo: vec3<f32>,
    u: f32,
    inside: vec3<f32>,
    // Side of the tap, texels, 1 or more.
    side: f32,
}

// A query lit by a disc.
struct DiscQuery {
    disc: Disc,
    wo: vec3<f32>,
    widening: f32,
    surface: Surface,
}

@group(1) @binding(0) var<storage, read> queries: array<Query>;
@group(1) @binding(0) var<storage, read> given_queries: array<GivenQuery>;
@group(1) @binding(0) var<storage, read> disc_queries: array<DiscQuery>;
@group(1) @binding(1) var<storage, read_write> results: array<array<f32, 3>>;

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&queries) {
        let q = queries[id.x];
        let f = shade(q.surface, q.wi, q.wo, q.widening);
        results[id.x] = array<f32, 3>(f.x, f.y, f.z);
    }
}

@compute @workgroup_size(64)
fn evaluate_given(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&given_queries) {
        let f = shade_given(given_queries[id.x]);
        results[id.x] = array<f32, 3>(f.x, f.y, f.z);
    }
}

@compute @workgroup_size(64)
fn evaluate_disc(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&disc_queries) {
        let q = disc_queries[id.x];
        let f = disc_radiance(q.surface, q.disc, q.wo, q.widening, paint.flakes.levels > 0u);
        results[id.x] = array<f32, 3>(f.x, f.y, f.z);
    }
}

fn shade_given(q: GivenQuery) -> vec3<f32> {
    if q.wi.z <= 0.0 || q.wo.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let g = geometry(coat_inner(q.wi), coat_inner(q.wo));
    var flakes = vec3<f32>(0.0);
    if paint.flakes.levels > 0u {
        let at = levels_about(q.side);
        let taps = flake_slices(g.theta_h, g.theta_i);
        flakes = xi_of_draw(fixed_draw(q.u, q.inside), at.level, at.fraction, taps, vec2<f32>(0.0));
    }
    return under_coat(g, flakes, q.wi, q.wo, q.widening);
}

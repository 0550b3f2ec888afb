// Twin of scene/mesh.rs, scene/hierarchy.rs and scene/triangle.rs. Of the tables, boxes are two entries each (low, next; high,
// leaf), triangles one (vertices, chart), vertices two (place; normal).

const LEAST_COSINE: f32 = 0.02;
const SHADE_GAP: f32 = 2e-3;

// The three places of a triangle, or its three normals.
struct Corners {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
}

// A ray in a frame in which it goes along z.
struct Sheared {
    origin: vec3<f32>,
    // Which axis it is closest to.
    axis: u32,
    shear: vec3<f32>,
}

// The first triangle that a ray whose eye is at `eye` meets behind that.
fn mesh_meet(mesh: Shape, ray: Ray, eye: f32) -> Entry {
    let sheared = shear(ray);
    let inverse = select(
        1.0 / ray.along,
        select(vec3<f32>(1e20), vec3<f32>(-1e20), ray.along < vec3<f32>(0.0)),
        abs(ray.along) < vec3<f32>(1e-20),
    );
    var first = entry_at(false, 3e38);
    var k = 0u;
    while k < mesh.nodes {
        let low = tables[mesh.first_node + 2u * k];
        let high = tables[mesh.first_node + 2u * k + 1u];
        let a = (bitcast<vec3<f32>>(low.xyz) - ray.base) * inverse;
        let b = (bitcast<vec3<f32>>(high.xyz) - ray.base) * inverse;
        let near = min(a, b);
        let far = max(a, b);
        let enters = max(near.x, max(near.y, near.z));
        // Roundings, so that a ray along an edge is not lost.
        let leaves = min(far.x, min(far.y, far.z));
        let slack = 4e-7 * max(abs(enters), abs(leaves));
        if enters > leaves + slack || leaves + slack < eye || enters - slack > first.at {
            k = low.w;
            continue;
        }
        let start = high.w >> 3u;
        for (var t = start; t < start + (high.w & 7u); t++) {
            let crossing = triangle_crossing(sheared, mesh_places(mesh, t));
            if crossing.met && crossing.at > eye && crossing.at < first.at {
                first = Entry(true, crossing.at, t, crossing.weights);
            }
        }
        k++;
    }
    return first;
}

fn shear(ray: Ray) -> Sheared {
    let size = abs(ray.along);
    let axis = select(select(1u, 2u, size.z >= size.y), 0u, size.x > size.y && size.x > size.z);
    let along = turned_axes(ray.along, axis);
    return Sheared(ray.base, axis, vec3<f32>(along.xy / along.z, 1.0 / along.z));
}

// The components of a vector so that this one is the last.
fn turned_axes(v: vec3<f32>, axis: u32) -> vec3<f32> {
    switch axis {
        case 0u: { return v.yzx; }
        case 1u: { return v.zxy; }
        default: { return v; }
    }
}

// Where a line crosses a triangle, if it does, from either side.
fn triangle_crossing(ray: Sheared, corners: Corners) -> Entry {
    let a = sheared_point(ray, corners.a);
    let b = sheared_point(ray, corners.b);
    let c = sheared_point(ray, corners.c);
    let u = c.x * b.y - c.y * b.x;
    let v = a.x * c.y - a.y * c.x;
    let w = b.x * a.y - b.y * a.x;
    let total = u + v + w;
    if total == 0.0 {
        return entry_at(false, 0.0);
    }
    let met = min(u, min(v, w)) >= 0.0 || max(u, max(v, w)) <= 0.0;
    return Entry(met, (u * a.z + v * b.z + w * c.z) / total, 0u, vec2<f32>(v, w) / total);
}

fn sheared_point(ray: Sheared, point: vec3<f32>) -> vec3<f32> {
    let q = turned_axes(point - ray.origin, ray.axis);
    return vec3<f32>(q.xy - ray.shear.xy * q.z, ray.shear.z * q.z);
}

fn mesh_places(mesh: Shape, triangle: u32) -> Corners {
    return mesh_corners(mesh, triangle, 0u);
}

fn mesh_normals(mesh: Shape, triangle: u32) -> Corners {
    return mesh_corners(mesh, triangle, 1u);
}

fn mesh_corners(mesh: Shape, triangle: u32, what: u32) -> Corners {
    let at = mesh.first_vertex + 2u * tables[mesh.first_triangle + triangle].xyz + what;
    return Corners(
        bitcast<vec3<f32>>(tables[at.x].xyz),
        bitcast<vec3<f32>>(tables[at.y].xyz),
        bitcast<vec3<f32>>(tables[at.z].xyz),
    );
}

fn mesh_chart(mesh: Shape, triangle: u32) -> u32 {
    return tables[mesh.first_triangle + triangle].w;
}

// Across a triangle, to the side from which it is counterclockwise.
fn mesh_across(mesh: Shape, triangle: u32) -> vec3<f32> {
    let places = mesh_places(mesh, triangle);
    return cross(places.b - places.a, places.c - places.a);
}

// The smooth normal of a triangle where its second and third vertex have these weights, of a length near 1.
fn mesh_smooth(mesh: Shape, triangle: u32, weights: vec2<f32>) -> vec3<f32> {
    let normals = mesh_normals(mesh, triangle);
    let sum = normals.a + (normals.b - normals.a) * weights.x + (normals.c - normals.a) * weights.y;
    // Opposite normals cancel.
    if dot(sum, sum) > 1e-12 {
        return sum;
    }
    return normalize(mesh_across(mesh, triangle));
}

// The smooth unit normal on the side that a ray comes from, bent where it would look away.
fn mesh_facing(mesh: Shape, triangle: u32, weights: vec2<f32>, direction: vec3<f32>) -> vec3<f32> {
    let across = mesh_across(mesh, triangle);
    let side = select(across, -across, dot(across, direction) > 0.0);
    let smooth_normal = normalize(mesh_smooth(mesh, triangle, weights));
    let normal = select(smooth_normal, -smooth_normal, dot(smooth_normal, side) < 0.0);
    let missing = LEAST_COSINE + dot(normal, direction);
    if missing <= 0.0 {
        return normal;
    }
    return normalize(normal - direction * missing);
}

// Change of the weights of a triangle's second and third vertex on a step along it.
fn mesh_weights_step(mesh: Shape, triangle: u32, step: vec3<f32>) -> vec2<f32> {
    let places = mesh_places(mesh, triangle);
    let across = cross(places.b - places.a, places.c - places.a);
    let area = length(across);
    let up = across / area;
    return vec2<f32>(dot(cross(places.a - places.c, step), up), dot(cross(places.b - places.a, step), up)) / area;
}

// Change of the unit normal on a step along the surface from a hit, whose normal is given.
fn mesh_normal_step(mesh: Shape, triangle: u32, weights: vec2<f32>, normal: vec3<f32>, step: vec3<f32>) -> vec3<f32> {
    let more = mesh_weights_step(mesh, triangle, step);
    let normals = mesh_normals(mesh, triangle);
    let here = mesh_smooth(mesh, triangle, weights);
    let change = unit_step(here, (normals.b - normals.a) * more.x + (normals.c - normals.a) * more.y);
    return unit_step(normal, select(change, -change, dot(here, normal) < 0.0));
}

// Change of the surface coordinates on a step along the surface, its true length kept.
fn mesh_uv_step_mm(chart: u32, frame: mat3x3<f32>, step: vec3<f32>) -> vec2<f32> {
    let local = frame * step;
    // The frame is right-handed seen from outside, the chart only on one side of the body.
    var second = frame[2].y;
    switch chart >> 1u {
        case 0u: { second = frame[2].y; }
        case 1u: { second = frame[0].y; }
        default: { second = frame[1].y; }
    }
    return vec2<f32>(local.x, select(local.y, -local.y, second < 0.0));
}

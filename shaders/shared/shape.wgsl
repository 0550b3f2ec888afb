// Twin of scene/convex.rs and scene/chart.rs. What changes from a point to its neighbour is computed as a change: a difference of two f32 would
// be mostly rounding.

const CAPSULE: u32 = 0u;
const SPHERE: u32 = 1u;
const PANEL: u32 = 2u;
const MESH: u32 = 3u;

// Charts that a shape may have.
const CHARTS: u32 = 16u;
const CYLINDER_CHART: u32 = 6u;
const PANEL_CHART: u32 = 7u;

struct Shape {
    // Axes of a panel.
    right: vec3<f32>,
    kind: u32,
    up: vec3<f32>,
    radius: f32,
    normal: vec3<f32>,
    // Half the height of a capsule's cylinder.
    half_height: f32,
    // Of a panel.
    half_size: vec2<f32>,
    // Of a mesh: where in the tables its boxes begin, their number, where triangles and vertices begin.
    first_node: u32,
    nodes: u32,
    first_triangle: u32,
    first_vertex: u32,
    // Length of the diagonal of its box.
    size: f32,
}

// Where a line enters the object.
struct Entry {
    met: bool,
    at: f32,
    // Triangle of a mesh, and the weights of its second and third vertex.
    primitive: u32,
    weights: vec2<f32>,
}

fn entry_at(met: bool, at: f32) -> Entry {
    return Entry(met, at, 0u, vec2<f32>(0.0));
}

// Where a ray whose eye is at `eye` meets the shape first.
fn shape_meet(shape: Shape, ray: Ray, eye: f32) -> Entry {
    if shape.kind == MESH {
        return mesh_meet(shape, ray, eye);
    }
    var entry = shape_entry(shape, ray);
    if entry.met && entry.at <= eye {
        // From inside: a convex body is left where the reversed ray enters it.
        entry = shape_entry(shape, Ray(ray.base, -ray.along));
        entry.at = -entry.at;
    }
    return entry_at(entry.met && entry.at > eye, entry.at);
}

fn shape_entry(shape: Shape, ray: Ray) -> Entry {
    switch shape.kind {
        case SPHERE: { return sphere_entry(shape, ray.base, ray.along); }
        case CAPSULE: { return capsule_entry(shape, ray); }
        default: { return panel_entry(shape, ray); }
    }
}

// A ball around the origin, by the point nearest to its center.
fn sphere_entry(shape: Shape, base: vec3<f32>, along: vec3<f32>) -> Entry {
    let square = dot(along, along);
    let nearest = -dot(base, along) / square;
    let height = length(base + along * nearest);
    let half_chord = (shape.radius - height) * (shape.radius + height) / square;
    return entry_at(half_chord >= 0.0, nearest - sqrt(max(half_chord, 0.0)));
}

fn capsule_entry(shape: Shape, ray: Ray) -> Entry {
    let o = ray.base.xy;
    let d = ray.along.xy;
    let a = dot(d, d);
    let moment = abs(o.x * d.y - o.y * d.x);
    let reach = shape.radius * sqrt(a);
    let square = (reach - moment) * (reach + moment);
    if square < 0.0 || (a == 0.0 && length(o) > shape.radius) {
        return entry_at(false, 0.0);
    }
    var z = -ray.along.z * 1e30;
    if a > 0.0 {
        let at = (-dot(o, d) - sqrt(square)) / a;
        z = ray.base.z + at * ray.along.z;
        if abs(z) <= shape.half_height {
            return entry_at(true, at);
        }
    }
    return sphere_entry(shape, ray.base - ball(shape, vec3<f32>(0.0, 0.0, z)), ray.along);
}

fn panel_entry(shape: Shape, ray: Ray) -> Entry {
    let facing = dot(ray.along, shape.normal);
    if facing == 0.0 {
        return entry_at(false, 0.0);
    }
    let at = -dot(ray.base, shape.normal) / facing;
    let uv = shape_uv_mm(shape, PANEL_CHART, ray.base + ray.along * at);
    return entry_at(all(abs(uv) <= shape.half_size), at);
}

// Center of curvature of the spherical part that `point` belongs to.
fn ball(shape: Shape, point: vec3<f32>) -> vec3<f32> {
    if shape.kind != CAPSULE {
        return vec3<f32>(0.0);
    }
    return vec3<f32>(0.0, 0.0, select(shape.half_height, -shape.half_height, point.z < 0.0));
}

fn shape_chart(shape: Shape, point: vec3<f32>) -> u32 {
    if shape.kind == PANEL {
        return PANEL_CHART;
    }
    if shape.kind == CAPSULE && abs(point.z) <= shape.half_height {
        return CYLINDER_CHART;
    }
    let n = point - ball(shape, point);
    let size = abs(n);
    if size.z > max(size.x, size.y) {
        return select(4u, 5u, n.z < 0.0);
    }
    if size.y > size.x {
        return select(2u, 3u, n.y < 0.0);
    }
    return select(0u, 1u, n.x < 0.0);
}

// What the normal is along, of any length.
fn outward(shape: Shape, chart: u32, point: vec3<f32>) -> vec3<f32> {
    switch chart {
        case PANEL_CHART: { return shape.normal; }
        case CYLINDER_CHART: { return vec3<f32>(point.xy, 0.0); }
        default: { return point - ball(shape, point); }
    }
}

fn shape_normal(shape: Shape, chart: u32, point: vec3<f32>) -> vec3<f32> {
    return normalize(outward(shape, chart, point));
}

// Change of the normal on the way from a point to one near it.
fn shape_normal_step(shape: Shape, chart: u32, point: vec3<f32>, step: vec3<f32>) -> vec3<f32> {
    switch chart {
        case PANEL_CHART: { return vec3<f32>(0.0); }
        case CYLINDER_CHART: { return unit_step(outward(shape, chart, point), vec3<f32>(step.xy, 0.0)); }
        default: { return unit_step(outward(shape, chart, point), step + ball(shape, point) - ball(shape, point + step)); }
    }
}

// Change of the unit vector along `start` when that moves by `step`.
fn unit_step(start: vec3<f32>, step: vec3<f32>) -> vec3<f32> {
    let end = start + step;
    let before = length(start);
    let after = length(end);
    let growth = dot(start + end, step) / (before + after);
    return (step - start * (growth / before)) / after;
}

// Rows tangent, bitangent, `normal` of the frame that is fixed to the surface.
fn shape_frame(shape: Shape, chart: u32, normal: vec3<f32>) -> mat3x3<f32> {
    var along = shape.right;
    switch chart {
        case PANEL_CHART: {}
        case CYLINDER_CHART: { along = vec3<f32>(-normal.y, normal.x, 0.0); }
        case 0u, 1u: { along = vec3<f32>(0.0, 1.0, 0.0); }
        case 2u, 3u: { along = vec3<f32>(0.0, 0.0, 1.0); }
        default: { along = vec3<f32>(1.0, 0.0, 0.0); }
    }
    var across = along - normal * dot(along, normal);
    if dot(across, across) < 1e-12 {
        across = cross(normal, along.yzx);
    }
    let tangent = normalize(across);
    return transpose(mat3x3<f32>(tangent, cross(normal, tangent), normal));
}

fn shape_uv_mm(shape: Shape, chart: u32, point: vec3<f32>) -> vec2<f32> {
    switch chart {
        case PANEL_CHART: { return vec2<f32>(dot(point, shape.right), dot(point, shape.up)); }
        case CYLINDER_CHART: {
            return vec2<f32>(shape.radius * full_angle(point.x, -point.y), point.z);
        }
        default: {
            let n = in_chart(chart, shape_normal(shape, chart, point));
            return n.xy * (shape.radius * sqrt(2.0 / (1.0 + n.z)));
        }
    }
}

// The axes of a chart of the sphere: two across, and the one around which it lies.
fn in_chart(chart: u32, v: vec3<f32>) -> vec3<f32> {
    var turned = v;
    switch chart >> 1u {
        case 0u: { turned = v.yzx; }
        case 1u: { turned = v.zxy; }
        default: {}
    }
    return vec3<f32>(turned.xy, select(turned.z, -turned.z, (chart & 1u) == 1u));
}

// Change of the surface coordinates on the way from a point to one near it on the same chart.
fn shape_uv_step_mm(shape: Shape, chart: u32, point: vec3<f32>, step: vec3<f32>) -> vec2<f32> {
    switch chart {
        case PANEL_CHART: { return vec2<f32>(dot(step, shape.right), dot(step, shape.up)); }
        case CYLINDER_CHART: {
            let across = point.x * step.y - point.y * step.x;
            let swing = full_angle(across, dot(point.xy, point.xy + step.xy));
            return vec2<f32>(shape.radius * swing, step.z);
        }
        default: { return lambert_step(shape, chart, point, step) * shape.radius; }
    }
}

// The same on a sphere of radius 1, of p sqrt(g) with g = 2 / e, e = 1 + height.
fn lambert_step(shape: Shape, chart: u32, point: vec3<f32>, step: vec3<f32>) -> vec2<f32> {
    let n = in_chart(chart, shape_normal(shape, chart, point));
    let change = in_chart(chart, shape_normal_step(shape, chart, point, step));
    let e = 1.0 + n.z;
    let rise = max(change.z, 1e-3 - e);
    let before = sqrt(2.0 / e);
    let after = sqrt(2.0 / (e + rise));
    let growth = -rise * before * before * after * after / (2.0 * (before + after));
    return change.xy * after + n.xy * growth;
}

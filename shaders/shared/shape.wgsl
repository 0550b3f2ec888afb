// Twin of scene/shape.rs. What changes from a point to its neighbour is computed as a change: a difference of two f32 would
// be mostly rounding.

const CAPSULE: u32 = 0u;
const SPHERE: u32 = 1u;
const PANEL: u32 = 2u;

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
}

struct Hit {
    met: bool,
    // Where on the ray.
    at: f32,
    point: vec3<f32>,
    normal: vec3<f32>,
    chart: u32,
}

// Where a line enters the object.
struct Entry {
    met: bool,
    at: f32,
}

fn intersect(ray: Ray) -> Hit {
    var hit: Hit;
    let eye = -scene.view.reach;
    var entry = shape_entry(ray);
    if entry.met && entry.at <= eye {
        // From inside: a convex body is left where the reversed ray enters it.
        entry = shape_entry(Ray(ray.base, -ray.along));
        entry.at = -entry.at;
    }
    if !entry.met || entry.at <= eye {
        return hit;
    }
    let point = ray.base + ray.along * entry.at;
    let chart = shape_chart(point);
    return Hit(true, entry.at, point, shape_normal(chart, point), chart);
}

fn shape_entry(ray: Ray) -> Entry {
    switch scene.shape.kind {
        case SPHERE: { return sphere_entry(ray.base, ray.along); }
        case CAPSULE: { return capsule_entry(ray); }
        default: { return panel_entry(ray); }
    }
}

// A ball around the origin, by the point nearest to its center.
fn sphere_entry(base: vec3<f32>, along: vec3<f32>) -> Entry {
    let square = dot(along, along);
    let nearest = -dot(base, along) / square;
    let height = length(base + along * nearest);
    let half_chord = (scene.shape.radius - height) * (scene.shape.radius + height) / square;
    return Entry(half_chord >= 0.0, nearest - sqrt(max(half_chord, 0.0)));
}

fn capsule_entry(ray: Ray) -> Entry {
    let o = ray.base.xy;
    let d = ray.along.xy;
    let a = dot(d, d);
    let moment = abs(o.x * d.y - o.y * d.x);
    let reach = scene.shape.radius * sqrt(a);
    let square = (reach - moment) * (reach + moment);
    if square < 0.0 || (a == 0.0 && length(o) > scene.shape.radius) {
        return Entry(false, 0.0);
    }
    var z = -ray.along.z * 1e30;
    if a > 0.0 {
        let at = (-dot(o, d) - sqrt(square)) / a;
        z = ray.base.z + at * ray.along.z;
        if abs(z) <= scene.shape.half_height {
            return Entry(true, at);
        }
    }
    return sphere_entry(ray.base - ball(vec3<f32>(0.0, 0.0, z)), ray.along);
}

fn panel_entry(ray: Ray) -> Entry {
    let facing = dot(ray.along, scene.shape.normal);
    if facing == 0.0 {
        return Entry(false, 0.0);
    }
    let at = -dot(ray.base, scene.shape.normal) / facing;
    let uv = shape_uv_mm(PANEL_CHART, ray.base + ray.along * at);
    return Entry(all(abs(uv) <= scene.shape.half_size), at);
}

// Center of curvature of the spherical part that `point` belongs to.
fn ball(point: vec3<f32>) -> vec3<f32> {
    if scene.shape.kind != CAPSULE {
        return vec3<f32>(0.0);
    }
    return vec3<f32>(0.0, 0.0, select(scene.shape.half_height, -scene.shape.half_height, point.z < 0.0));
}

fn shape_chart(point: vec3<f32>) -> u32 {
    if scene.shape.kind == PANEL {
        return PANEL_CHART;
    }
    if scene.shape.kind == CAPSULE && abs(point.z) <= scene.shape.half_height {
        return CYLINDER_CHART;
    }
    let n = point - ball(point);
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
fn outward(chart: u32, point: vec3<f32>) -> vec3<f32> {
    switch chart {
        case PANEL_CHART: { return scene.shape.normal; }
        case CYLINDER_CHART: { return vec3<f32>(point.xy, 0.0); }
        default: { return point - ball(point); }
    }
}

fn shape_normal(chart: u32, point: vec3<f32>) -> vec3<f32> {
    return normalize(outward(chart, point));
}

// Change of the normal on the way from a point to one near it.
fn shape_normal_step(chart: u32, point: vec3<f32>, step: vec3<f32>) -> vec3<f32> {
    switch chart {
        case PANEL_CHART: { return vec3<f32>(0.0); }
        case CYLINDER_CHART: { return unit_step(outward(chart, point), vec3<f32>(step.xy, 0.0)); }
        default: { return unit_step(outward(chart, point), step + ball(point) - ball(point + step)); }
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
fn shape_frame(chart: u32, normal: vec3<f32>) -> mat3x3<f32> {
    var along = scene.shape.right;
    switch chart {
        case PANEL_CHART: {}
        case CYLINDER_CHART: { along = vec3<f32>(-normal.y, normal.x, 0.0); }
        case 0u, 1u: { along = vec3<f32>(0.0, 1.0, 0.0); }
        case 2u, 3u: { along = vec3<f32>(0.0, 0.0, 1.0); }
        default: { along = vec3<f32>(1.0, 0.0, 0.0); }
    }
    let tangent = normalize(along - normal * dot(along, normal));
    return transpose(mat3x3<f32>(tangent, cross(normal, tangent), normal));
}

fn shape_uv_mm(chart: u32, point: vec3<f32>) -> vec2<f32> {
    switch chart {
        case PANEL_CHART: { return vec2<f32>(dot(point, scene.shape.right), dot(point, scene.shape.up)); }
        case CYLINDER_CHART: {
            return vec2<f32>(scene.shape.radius * full_angle(point.x, -point.y), point.z);
        }
        default: {
            let n = in_chart(chart, shape_normal(chart, point));
            return n.xy * (scene.shape.radius * sqrt(2.0 / (1.0 + n.z)));
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
fn shape_uv_step_mm(chart: u32, point: vec3<f32>, step: vec3<f32>) -> vec2<f32> {
    switch chart {
        case PANEL_CHART: { return vec2<f32>(dot(step, scene.shape.right), dot(step, scene.shape.up)); }
        case CYLINDER_CHART: {
            let across = point.x * step.y - point.y * step.x;
            let swing = full_angle(across, dot(point.xy, point.xy + step.xy));
            return vec2<f32>(scene.shape.radius * swing, step.z);
        }
        default: { return lambert_step(chart, point, step) * scene.shape.radius; }
    }
}

// The same on a sphere of radius 1, of p sqrt(g) with g = 2 / e, e = 1 + height.
fn lambert_step(chart: u32, point: vec3<f32>, step: vec3<f32>) -> vec2<f32> {
    let n = in_chart(chart, shape_normal(chart, point));
    let change = in_chart(chart, shape_normal_step(chart, point, step));
    let e = 1.0 + n.z;
    let rise = max(change.z, 1e-3 - e);
    let before = sqrt(2.0 / e);
    let after = sqrt(2.0 / (e + rise));
    let growth = -rise * before * before * after * after / (2.0 * (before + after));
    return change.xy * after + n.xy * growth;
}

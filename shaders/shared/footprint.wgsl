// Twin of render/footprint.rs.

struct Footprint {
    surface: Surface,
    // Its sides on the tangent plane, in the object's frame.
    sides: array<vec3<f32>, 2>,
    // Unit direction of the mirrored ray in the world, and its change from one side of the patch to the other.
    mirrored: vec3<f32>,
    mirrored_sides: array<vec3<f32>, 2>,
}

fn footprint(hit: Hit, side: f32) -> Footprint {
    let view = scene.objects[hit.object].view;
    let axes = scene.objects[hit.object].axes;
    let direction = normalize(hit.ray.along);
    var covered: Footprint;
    covered.mirrored = axes * (direction - hit.normal * (2.0 * dot(direction, hit.normal)));
    covered.surface.chart = hit.object * CHARTS + hit.chart;
    covered.surface.uv_mm = surface_uv_mm(hit);
    covered.surface.seed = scene.seed;
    covered.surface.random = scene.random;
    for (var k = 0u; k < 2u; k++) {
        let aside = select(view.down, view.right, k == 0u) * side;
        let step = step_on_plane(view, hit, aside);
        covered.sides[k] = step;
        covered.surface.footprint[k] = surface_uv_step_mm(hit, step);
        let turned = unit_step(hit.ray.along, aside);
        let tilted = surface_normal_step(hit, step);
        covered.mirrored_sides[k] = axes * mirror_step(direction, turned, hit.normal, tilted);
    }
    return covered;
}

// From the hit to where the ray that goes `aside` meets the tangent plane.
fn step_on_plane(view: View, hit: Hit, aside: vec3<f32>) -> vec3<f32> {
    let depth = hit.at + view.reach;
    let along = hit.ray.along + aside;
    let distance = depth * length(hit.ray.along);
    // The neighbour's point of the same depth, and how much deeper the plane lies.
    let across = aside * depth;
    let farthest = 2.0 * distance / length(along) - depth;
    let deeper = -dot(across, hit.normal) / dot(along, hit.normal);
    let step = across + along * select(farthest, min(deeper, farthest), depth + deeper > 0.0);
    let limit = 0.1 * distance;
    return step * min(1.0, limit / max(length(step), 1e-30));
}

// Change of the mirrored direction when direction and normal change.
fn mirror_step(direction: vec3<f32>, turned: vec3<f32>, normal: vec3<f32>, tilted: vec3<f32>) -> vec3<f32> {
    let there = normal + tilted;
    let cosine = dot(direction + turned, there);
    return turned - 2.0 * (tilted * cosine + normal * (dot(turned, there) + dot(direction, tilted)));
}

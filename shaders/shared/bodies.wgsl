// Twin of scene/bodies.rs. Places are those of the object's own frame: there f32 rounds them by a share of the object's size.

struct Object {
    // The camera as the object sees it.
    view: View,
    shape: Shape,
    // Columns: the axes of the object's frame.
    axes: mat3x3<f32>,
    position: vec3<f32>,
    // Number of the paint that it wears.
    paint: u32,
}

struct Hit {
    met: bool,
    // The ray in the object's frame, and where on it.
    ray: Ray,
    at: f32,
    point: vec3<f32>,
    normal: vec3<f32>,
    chart: u32,
    object: u32,
    // What `hit_on` asks for; of a mesh, also the weights of the triangle's second and third vertex.
    part: u32,
    weights: vec2<f32>,
}

// What the ray through the point of the picture so many pixels from its middle meets first.
fn intersect(offset: vec2<f32>) -> Hit {
    var nearest = 3e38;
    var object = 0u;
    var first = entry_at(false, 0.0);
    for (var k = 0u; k < scene.object_count; k++) {
        let view = scene.objects[k].view;
        let entry = shape_meet(scene.objects[k].shape, view_ray(view, offset), -view.reach);
        let depth = entry.at + view.reach;
        if entry.met && depth < nearest {
            nearest = depth;
            object = k;
            first = entry;
        }
    }
    if !first.met {
        var none: Hit;
        return none;
    }
    let shape = scene.objects[object].shape;
    if shape.kind == MESH {
        return hit_on(offset, object, first.at, first.primitive);
    }
    let ray = view_ray(scene.objects[object].view, offset);
    return hit_on(offset, object, first.at, shape_chart(shape, ray.base + ray.along * first.at));
}

// All of the hit on an object at a place on its ray. `part`: the triangle of a mesh, the chart of another shape.
fn hit_on(offset: vec2<f32>, object: u32, at: f32, part: u32) -> Hit {
    let shape = scene.objects[object].shape;
    let ray = view_ray(scene.objects[object].view, offset);
    let point = ray.base + ray.along * at;
    if shape.kind == MESH {
        let weights = triangle_crossing(shear(ray), mesh_places(shape, part)).weights;
        let normal = mesh_facing(shape, part, weights, normalize(ray.along));
        return Hit(true, ray, at, point, normal, mesh_chart(shape, part), object, part, weights);
    }
    return Hit(true, ray, at, point, shape_normal(shape, part, point), part, object, part, vec2<f32>(0.0));
}

// A point of the object's own frame in the world.
fn world_point(hit: Hit) -> vec3<f32> {
    return scene.objects[hit.object].axes * hit.point + scene.objects[hit.object].position;
}

// Rows tangent, bitangent, normal of the frame that is fixed to the surface, in the object's frame.
fn surface_frame(hit: Hit) -> mat3x3<f32> {
    return shape_frame(scene.objects[hit.object].shape, hit.chart, hit.normal);
}

fn surface_uv_mm(hit: Hit) -> vec2<f32> {
    let shape = scene.objects[hit.object].shape;
    if shape.kind == MESH {
        return in_chart(hit.chart, hit.point).xy;
    }
    return shape_uv_mm(shape, hit.chart, hit.point);
}

// Change of the surface coordinates on a step along the surface.
fn surface_uv_step_mm(hit: Hit, step: vec3<f32>) -> vec2<f32> {
    let shape = scene.objects[hit.object].shape;
    if shape.kind == MESH {
        return mesh_uv_step_mm(hit.chart, surface_frame(hit), step);
    }
    return shape_uv_step_mm(shape, hit.chart, hit.point, step);
}

// Change of the normal on a step along the surface.
fn surface_normal_step(hit: Hit, step: vec3<f32>) -> vec3<f32> {
    let shape = scene.objects[hit.object].shape;
    if shape.kind == MESH {
        return mesh_normal_step(shape, hit.part, hit.weights, hit.normal, step);
    }
    return shape_normal_step(shape, hit.chart, hit.point, step);
}

// Whether something stands between a hit and the middle of a lamp: another object, or a mesh itself. Convex bodies do not shade
// themselves. No return from inside the loop: where all of its lanes take one, Mesa's software renderer leaves the loop over lamps, too.
fn is_shaded(hit: Hit, lamp: Incidence) -> bool {
    let point = world_point(hit);
    var shaded = false;
    for (var k = 0u; k < scene.object_count && !shaded; k++) {
        let shape = scene.objects[k].shape;
        let axes = scene.objects[k].axes;
        var base = (point - scene.objects[k].position) * axes;
        if k == hit.object {
            base = hit.point + hit.normal * (SHADE_GAP * shape.size);
        }
        if k != hit.object || shape.kind == MESH {
            let entry = shape_meet(shape, Ray(base, lamp.direction * axes), 0.0);
            shaded = entry.met && entry.at < lamp.distance;
        }
    }
    return shaded;
}

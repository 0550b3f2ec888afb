// Entry point: adds a part of what its pixels see of a print to a block of a picture. Terms of a sample are its lamps.

@compute @workgroup_size(8, 8)
fn print_picture(@builtin(global_invocation_id) id: vec3<u32>) {
    if all(id.xy < block.size) {
        let at = id.y * block.size.x + id.x;
        let corner = vec2<f32>(block.first + id.xy) - scene.view.middle;
        var sum = vec3<f32>(0.0);
        for (var k = block.part.samples.x; k < block.part.samples.y; k++) {
            sum += print_radiance(corner + sample_point(k), block.part.terms);
        }
        let radiance = vector(pixels[at]) + sum / f32(scene.samples);
        pixels[at] = array<f32, 3>(radiance.x, radiance.y, radiance.z);
    }
}

// What these lamps show along a ray; what is not printed belongs to the first.
fn print_radiance(offset: vec2<f32>, lamps: vec2<u32>) -> vec3<f32> {
    let hit = intersect(offset);
    if !hit.met {
        let direction = normalize(view_ray(scene.view, offset).along);
        return select(vec3<f32>(0.0), seen_beyond(direction), lamps.x == 0u);
    }
    let to_eye = -normalize(hit.ray.along);
    if dot(to_eye, hit.normal) <= 0.0 {
        return vec3<f32>(0.0);
    }
    let covered = coverage_sample(print_place(hit, footprint(hit, 1.0 / sqrt(f32(scene.samples)))));
    let to_surface = surface_frame(hit);
    let world_to_surface = to_surface * transpose(scene.objects[hit.object].axes);
    let wo = to_surface * to_eye;
    let point = world_point(hit);
    var sum = vec3<f32>(0.0);
    for (var k = lamps.x; k < lamps.y; k++) {
        let seen = light_at(scene.lights[k], point);
        let wi = world_to_surface * seen.direction;
        let power = dot(seen.irradiance, vec3<f32>(0.212639, 0.71516868, 0.07219232)) * max(wi.z, 0.0);
        if power > 0.0 && !is_shaded(hit, seen) {
            sum += print_reflectance(covered, wi, wo) * power;
        }
    }
    return sum;
}

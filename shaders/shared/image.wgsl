// Twin of render/image.rs.

// What an invocation adds up: terms of samples, a half-open range of each. The terms of a sample are its directions of the
// surroundings, then the taps of its flakes under them, then its lamps.
struct Part {
    samples: vec2<u32>,
    terms: vec2<u32>,
}

// A part of the mean over the samples of a pixel (box filter), at the points of Fibonacci's lattice: of those that see the
// paint of that number.
fn pixel(place: vec2<u32>, part: Part, worn: u32) -> vec3<f32> {
    let corner = vec2<f32>(place) - scene.view.middle;
    var sum = vec3<f32>(0.0);
    for (var k = part.samples.x; k < part.samples.y; k++) {
        sum += ray_radiance(corner + sample_point(k), k, part.terms, worn);
    }
    return sum / f32(scene.samples);
}

// Where in a pixel a ray goes. The golden ratio's multiples by integers: their fraction keeps its digits.
fn sample_point(k: u32) -> vec2<f32> {
    let down = k * 2654435769u + 0x80000000u;
    return vec2<f32>((f32(k) + 0.5) / f32(scene.samples), f32(down >> 8u) / 16777216.0);
}

// These terms of the radiance along a ray, the pixel's sample of that number; what has no terms belongs to the first, what is
// not painted to the first paint.
fn ray_radiance(offset: vec2<f32>, sample: u32, terms: vec2<u32>, worn: u32) -> vec3<f32> {
    let hit = intersect(offset);
    if !hit.met {
        let direction = normalize(view_ray(scene.view, offset).along);
        return select(vec3<f32>(0.0), seen_beyond(direction), terms.x == 0u && worn == 0u);
    }
    if scene.objects[hit.object].paint != worn {
        return vec3<f32>(0.0);
    }
    let axes = scene.objects[hit.object].axes;
    let to_eye = -normalize(hit.ray.along);
    // The inner side of a body and the back of a panel are not painted: black.
    if dot(to_eye, hit.normal) <= 0.0 {
        return vec3<f32>(0.0);
    }
    let covered = footprint(hit, 1.0 / sqrt(f32(scene.samples)));
    let turned = view_frame(scene.objects[hit.object].view, hit.normal);
    let to_world = axes * turned;
    let wo = to_eye * turned;
    var sum = surroundings_scattered(to_world, wo, sample, terms.x, terms.y);
    if terms.x == 0u {
        sum += surroundings_mirrored(to_world, wo, gloss_widening(0.0, covered.mirrored_sides), sample);
    }
    let to_surface = surface_frame(hit);
    let world_to_surface = to_surface * transpose(axes);
    let taps = clamp(terms, vec2<u32>(scene.directions), vec2<u32>(scene.directions + MAX_TAPS)) - scene.directions;
    sum += surroundings_sparkle(covered.surface, to_world, world_to_surface, wo, taps.x, taps.y);
    let seen_from = to_surface * to_eye;
    let point = world_point(hit);
    let lamps = scene.directions + MAX_TAPS;
    for (var k = max(terms.x, lamps); k < terms.y; k++) {
        let seen = light_at(scene.lights[k - lamps], point);
        if !is_shaded(hit, seen) {
            sum += lamp_radiance(seen, covered, world_to_surface, seen_from);
        }
    }
    return sum;
}

fn seen_beyond(direction: vec3<f32>) -> vec3<f32> {
    if scene.has_background != 0u {
        return scene.background;
    }
    return environment_radiance(direction);
}

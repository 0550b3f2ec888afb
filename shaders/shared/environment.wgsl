// Twin of scene/environment.rs.

fn environment_radiance(direction: vec3<f32>) -> vec3<f32> {
    if scene.panorama.size.x > 0u {
        return panorama_radiance(direction);
    }
    let end = select(scene.zenith, scene.ground, direction.z < 0.0);
    var sum = mix(scene.horizon, end, smoothstep(0.0, 1.0, abs(direction.z)));
    for (var k = 0u; k < scene.softbox_count; k++) {
        sum += softbox_radiance(scene.softboxes[k], direction);
    }
    return sum;
}

// The share of light of this luminance that is not a lamp's: twin of that in scene/lamp_points.rs.
fn dim_share(luminance: f32) -> f32 {
    if luminance <= scene.lamp_level {
        return 1.0;
    }
    return scene.lamp_level / luminance;
}

// Whether there are bright parts worth looking at by themselves.
fn environment_has_lamps() -> bool {
    return scene.softbox_count > 0u || scene.panorama.is_bright != 0u;
}

// A direction towards one of the bright parts, chosen by their power.
fn environment_sample(at: vec2<f32>) -> vec3<f32> {
    if scene.panorama.size.x > 0u {
        return panorama_sample(at);
    }
    var choice = at.x;
    for (var k = 0u; k < scene.softbox_count; k++) {
        let share = scene.softboxes[k].share;
        if choice < share {
            return softbox_sample(scene.softboxes[k], vec2<f32>(choice / share, at.y));
        }
        choice -= share;
    }
    return softbox_sample(scene.softboxes[scene.softbox_count - 1u], vec2<f32>(1.0, at.y));
}

fn environment_density(direction: vec3<f32>) -> f32 {
    if scene.panorama.size.x > 0u {
        return panorama_density(direction);
    }
    var sum = 0.0;
    for (var k = 0u; k < scene.softbox_count; k++) {
        sum += scene.softboxes[k].share * softbox_density(scene.softboxes[k], direction);
    }
    return sum;
}

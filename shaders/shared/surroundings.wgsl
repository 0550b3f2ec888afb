// Twin of render/surroundings.rs.

const GLOSS_DIRECTIONS: u32 = 4u;

// Point k of `count` of a pixel sample, in the open unit square.
fn share_point(sample: u32, k: u32, count: u32) -> vec2<f32> {
    let point = k * scene.samples + sample;
    return vec2<f32>((f32(point) + 0.5) / f32(count * scene.samples), unit(point * 2654435769u));
}

// Radiance of the surroundings towards the eye, of directions `first` to `end`. `to_world`: columns are the local axes.
fn surroundings_scattered(to_world: mat3x3<f32>, wo: vec3<f32>, sample: u32, first: u32, end: u32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var k = first; k < min(end, scene.directions); k++) {
        sum += scattered(to_world, wo, share_point(sample, k, scene.directions));
    }
    return sum / f32(scene.directions);
}

// The surroundings as the coat shows them.
fn surroundings_mirrored(to_world: mat3x3<f32>, wo: vec3<f32>, widening: f32, sample: u32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    let reflectance = mirror_reflectance(wo);
    if reflectance > 0.0 {
        sum += environment_radiance(to_world * vec3<f32>(-wo.xy, wo.z)) * reflectance;
    }
    if paint.coat.gloss.coefficient != 0.0 {
        for (var k = 0u; k < GLOSS_DIRECTIONS; k++) {
            sum += glossy(to_world, wo, widening, share_point(sample, k, GLOSS_DIRECTIONS)) / f32(GLOSS_DIRECTIONS);
        }
    }
    return sum;
}

// What one direction of the base's says about all.
fn scattered(to_world: mat3x3<f32>, wo: vec3<f32>, at: vec2<f32>) -> vec3<f32> {
    let towards_lamps = select(0.0, 0.5, environment_has_lamps());
    var wi: vec3<f32>;
    if at.x < towards_lamps {
        wi = environment_sample(vec2<f32>(at.x / towards_lamps, at.y)) * to_world;
    } else {
        wi = proposal_sample(wo, vec2<f32>((at.x - towards_lamps) / (1.0 - towards_lamps), at.y));
    }
    if wi.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let world = to_world * wi;
    let density = towards_lamps * environment_density(world)
        + (1.0 - towards_lamps) * proposal_density(wi, lobe_geometry(wi, wo));
    if density <= 0.0 {
        return vec3<f32>(0.0);
    }
    return shade_mean(wi, wo) * environment_radiance(world) * (wi.z / density);
}

// What one direction of the gloss lobe says about all.
fn glossy(to_world: mat3x3<f32>, wo: vec3<f32>, widening: f32, at: vec2<f32>) -> vec3<f32> {
    let roughness = sqrt(paint.coat.gloss.roughness * paint.coat.gloss.roughness + widening);
    let wi = mirrored(wo, half_vector(roughness, at));
    if wi.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let density = half_vector_density(lobe_geometry(wi, wo), roughness);
    if density <= 0.0 {
        return vec3<f32>(0.0);
    }
    return environment_radiance(to_world * wi) * (coat_gloss(wi, wo, widening) * wi.z / density);
}

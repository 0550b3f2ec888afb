// The surroundings in real time. Their radiance lies in cubes of ever coarser maps, so that few directions say much. What the
// base scatters of them is a function of normal and direction to the eye: for a few directions to the eye, spread over the
// picture, it is integrated for normals all over the visible hemisphere, and pixels look it up. No split of light and lobe: color
// table, coat, horizon and the flakes' mean are those of the reference.
// Coarse maps would smear a small bright lamp over normals that it does not reach. So the base looks up dim light only; what is
// brighter than that is known as points besides, and unsmeared.

// See `view_node`, `node_place`.
@group(2) @binding(1) var environment_map: texture_cube<f32>;
@group(2) @binding(2) var map_sampler: sampler;
@group(2) @binding(6) var dim_map: texture_cube<f32>;
// Direction and luminance, then radiance times solid angle, of points.
@group(2) @binding(7) var lamp_map: texture_2d<f32>;
@group(3) @binding(0) var scattered_map: texture_2d<f32>;

@group(2) @binding(0) var finer_map: texture_2d_array<f32>;
@group(2) @binding(1) var coarser_map: texture_storage_2d_array<rgba16float, write>;

// Normals a side of a node's tile.
const NORMALS: u32 = 40u;
// Directions a normal, and as how many the points of all lamps together count.
const LOOKS: u32 = 128u;
const LAMP_LOOKS: f32 = 256.0;
// A half float ends at 65504.
const MOST: f32 = 6e4;
// Radiance of the surroundings, the mean of four directions a texel.
@compute @workgroup_size(8, 8)
fn finest_environment(@builtin(global_invocation_id) id: vec3<u32>) {
    store_finest(id, false);
}

// The same of dim light.
@compute @workgroup_size(8, 8)
fn finest_dim(@builtin(global_invocation_id) id: vec3<u32>) {
    store_finest(id, true);
}

fn store_finest(id: vec3<u32>, is_dim: bool) {
    let side = f32(textureDimensions(coarser_map).x);
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < 4u; k++) {
        let at = (vec2<f32>(id.xy) + 0.25 + 0.5 * vec2<f32>(f32(k & 1u), f32(k >> 1u))) / side;
        let light = environment_radiance(normalize(cube_direction(id.z, 2.0 * at - 1.0)));
        sum += light * select(1.0, dim_share(dot(light, LUMINANCE)), is_dim);
    }
    textureStore(coarser_map, id.xy, id.z, vec4<f32>(bounded(sum * (0.25 * frame.map_scale)), 1.0));
}

// A map of half the side.
@compute @workgroup_size(8, 8)
fn coarser_environment(@builtin(global_invocation_id) id: vec3<u32>) {
    if all(id.xy < textureDimensions(coarser_map)) {
        var sum = vec4<f32>(0.0);
        for (var k = 0u; k < 4u; k++) {
            sum += textureLoad(finer_map, 2u * id.xy + vec2<u32>(k & 1u, k >> 1u), id.z, 0);
        }
        textureStore(coarser_map, id.xy, id.z, 0.25 * sum);
    }
}

// A tile a node, a normal a texel: what the base scatters there, over the coat's transmittance towards the eye, which changes fast
// where it grazes.
@fragment
fn scattered_frame(corner: Corner) -> @location(0) vec4<f32> {
    let place = vec2<u32>(corner.place.xy);
    let node = view_node(place / NORMALS);
    let at = vec2<f32>(place % NORMALS) / f32(NORMALS - 1u);
    let normal = node * hemisphere_direction(at);
    let to_eye = node[2];
    let axis = cross(to_eye, normal);
    let scale = 1.0 / (1.0 + dot(to_eye, normal));
    let to_world = mat3x3<f32>(turned(node[0], axis, scale), turned(node[1], axis, scale), normal);
    let wo = to_eye * to_world;
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < LOOKS; k++) {
        sum += looked_at(to_world, wo, share_point(0u, k, LOOKS));
    }
    for (var k = 0u; k < frame.lamp_points; k++) {
        sum += lit_by_point(to_world, wo, k);
    }
    return vec4<f32>(bounded(sum / transmitted(wo.z, paint.coat.ior)), 1.0);
}

// What one direction says about all: the dim light that lies about it, and the lamp's in it as far as no point stands for that.
fn looked_at(to_world: mat3x3<f32>, wo: vec3<f32>, at: vec2<f32>) -> vec3<f32> {
    let wi = proposal_sample(wo, at);
    if wi.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let density = proposal_density(wi, lobe_geometry(wi, wo));
    if density <= 0.0 {
        return vec3<f32>(0.0);
    }
    let world = to_world * wi;
    var light = around(dim_map, world, density, LOOKS);
    if frame.lamp_points > 0u {
        let all = environment_radiance(world);
        let lamp = all * (1.0 - dim_share(dot(all, LUMINANCE)));
        light += lamp * (frame.map_scale * (1.0 - points_share(dot(lamp, LUMINANCE), density)));
    }
    return shade_mean(wi, wo) * light * (wi.z / (f32(LOOKS) * density));
}

// What a point of a lamp adds.
fn lit_by_point(to_world: mat3x3<f32>, wo: vec3<f32>, k: u32) -> vec3<f32> {
    let lamp = textureLoad(lamp_map, vec2<u32>(k, 0u), 0);
    let wi = lamp.xyz * to_world;
    if wi.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let share = points_share(lamp.w, proposal_density(wi, lobe_geometry(wi, wo)));
    return shade_mean(wi, wo) * textureLoad(lamp_map, vec2<u32>(k, 1u), 0).xyz * (frame.map_scale * share * wi.z);
}

// The share of a lamp's light that its points bring, where the paint's directions have this density: the balance of both ways to
// find it (Veach and Guibas 1995).
fn points_share(luminance: f32, density: f32) -> f32 {
    let points = LAMP_LOOKS * luminance / scene.lamp_power;
    return points / max(points + f32(LOOKS) * density, 1e-30);
}

// What the base scatters towards the eye, where the eye sees the surface along `-to_eye` at a place of the picture, over the scale.
fn scattered_around(normal: vec3<f32>, to_eye: vec3<f32>, cosine: f32, place: vec2<f32>) -> vec3<f32> {
    let mirrored = normal * (2.0 * dot(normal, to_eye)) - to_eye;
    let at = place / (2.0 * scene.view.middle) * vec2<f32>(frame.nodes - 1u);
    let first = min(vec2<u32>(at), frame.nodes - 2u);
    let f = at - vec2<f32>(first);
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < 4u; k++) {
        let corner = vec2<u32>(k & 1u, k >> 1u);
        let node = view_node(first + corner);
        // The normal that mirrors the node's eye to where the pixel's is mirrored.
        let tile = hemisphere_place(normalize(node[2] + mirrored) * node);
        let texel = vec2<f32>((first + corner) * NORMALS) + 0.5 + tile * f32(NORMALS - 1u);
        let weight = select(1.0 - f, f, corner == vec2<u32>(1u));
        let size = vec2<f32>(frame.nodes * NORMALS);
        sum += textureSampleLevel(scattered_map, map_sampler, texel / size, 0.0).xyz * (weight.x * weight.y);
    }
    return sum * transmitted(cosine, paint.coat.ior);
}

// The surroundings as the coat shows them, over the scale: `surroundings_mirrored`, its gloss lobe by coarser maps.
fn mirrored_around(to_world: mat3x3<f32>, wo: vec3<f32>, widening: f32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    let reflectance = mirror_reflectance(wo);
    if reflectance > 0.0 {
        let seen = environment_radiance(to_world * vec3<f32>(-wo.xy, wo.z));
        sum += seen * (frame.map_scale * reflectance);
    }
    if paint.coat.gloss.coefficient != 0.0 {
        let roughness = sqrt(paint.coat.gloss.roughness * paint.coat.gloss.roughness + widening);
        for (var k = 0u; k < GLOSS_DIRECTIONS; k++) {
            let wi = mirrored(wo, half_vector(roughness, share_point(0u, k, GLOSS_DIRECTIONS)));
            let density = half_vector_density(lobe_geometry(wi, wo), roughness);
            if wi.z > 0.0 && density > 0.0 {
                let seen = around(environment_map, to_world * wi, density, GLOSS_DIRECTIONS);
                sum += seen * (coat_gloss(wi, wo, widening) * wi.z / (density * f32(GLOSS_DIRECTIONS)));
            }
        }
    }
    return sum;
}

// Radiance about a direction that is one of `count` of this density, 1/sr: the mean over its share of the sphere (Krivanek and
// Colbert 2008, eq. 5).
fn around(map: texture_cube<f32>, direction: vec3<f32>, density: f32, count: u32) -> vec3<f32> {
    let side = f32(textureDimensions(map).x);
    let texels = 6.0 * side * side * (0.5 * FRAC_1_TAU) / (f32(count) * density);
    return textureSampleLevel(map, map_sampler, direction, max(0.5 * log2(texels), 0.0)).xyz;
}

// The eye of a node: columns right, up, towards the eye, of the ray through that place of the picture.
fn view_node(node: vec2<u32>) -> mat3x3<f32> {
    let place = vec2<f32>(node) / vec2<f32>(frame.nodes - 1u);
    let to_eye = -normalize(view_ray(scene.view, (2.0 * place - 1.0) * scene.view.middle).along);
    let right = normalize(scene.view.right - to_eye * dot(scene.view.right, to_eye));
    return mat3x3<f32>(right, cross(to_eye, right), to_eye);
}

// From the unit square to the hemisphere, its rim short of the horizon; half of an octahedron (Cigolle et al. 2014).
fn hemisphere_direction(at: vec2<f32>) -> vec3<f32> {
    let e = at - 0.5;
    let p = vec2<f32>(e.x + e.y, e.x - e.y);
    return normalize(vec3<f32>(p, max(1.0 - abs(p.x) - abs(p.y), 2e-3)));
}

// And back.
fn hemisphere_place(direction: vec3<f32>) -> vec2<f32> {
    let p = direction.xy / (abs(direction.x) + abs(direction.y) + max(direction.z, 0.0));
    return 0.5 * vec2<f32>(p.x + p.y, p.x - p.y) + 0.5;
}

// Of a point of a face, -1 to 1 on both axes.
fn cube_direction(face: u32, at: vec2<f32>) -> vec3<f32> {
    switch face {
        case 0u: { return vec3<f32>(1.0, -at.y, -at.x); }
        case 1u: { return vec3<f32>(-1.0, -at.y, at.x); }
        case 2u: { return vec3<f32>(at.x, 1.0, at.y); }
        case 3u: { return vec3<f32>(at.x, -1.0, -at.y); }
        case 4u: { return vec3<f32>(at.x, -at.y, 1.0); }
        default: { return vec3<f32>(-at.x, -at.y, -1.0); }
    }
}

fn bounded(color: vec3<f32>) -> vec3<f32> {
    return clamp(color, vec3<f32>(-MOST), vec3<f32>(MOST));
}

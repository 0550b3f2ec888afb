// What is kept of a pixel as long as camera and objects stay: what it meets, how that lies, what stands between it and the lamps.
// Shading then knows nothing of shapes.

// Words of a hit: where on its ray, `hit_bits`, its surface coordinates.
@group(2) @binding(0) var hit_map: texture_2d<u32>;
// The normal in the object's frame, and what the pixel's width adds to the squared roughness of a gloss lobe.
@group(2) @binding(3) var normal_map: texture_2d<u32>;
// The two sides of its footprint.
@group(2) @binding(4) var footprint_map: texture_2d<u32>;
// A layer for every `frame.lamps_a_layer` lamps, a bit a lamp that does not reach it.
@group(2) @binding(5) var shadow_map: texture_2d_array<u32>;

// Whether there is one object only.
override ALONE: bool = false;

const NOTHING: u32 = 0u;
const BACK: u32 = 1u;
const PAINTED: u32 = 2u;

struct Kept {
    kind: u32,
    object: u32,
    chart: u32,
    // See `hit_on`.
    part: u32,
    at: f32,
    uv_mm: vec2<f32>,
}

// How the surface lies that a pixel shows.
struct Seen {
    surface: Surface,
    // In the world.
    point: vec3<f32>,
    // In the object's frame.
    to_eye: vec3<f32>,
    normal: vec3<f32>,
    // From the world to the frame that is fixed to the surface, and the direction to the eye there.
    to_surface: mat3x3<f32>,
    wo: vec3<f32>,
    // Of a gloss lobe.
    widening: f32,
}

// Parts are charts, or triangles of a mesh, a million of them at most.
fn hit_bits(kind: u32, hit: Hit) -> u32 {
    return kind | (hit.object << 2u) | (hit.chart << 6u) | (hit.part << 10u);
}

// What a pixel meets.
@fragment
fn hit_frame(corner: Corner) -> @location(0) vec4<u32> {
    let hit = intersect(frame_offset(corner.place));
    if !hit.met {
        return vec4<u32>(0u, NOTHING, 0u, 0u);
    }
    let kind = select(PAINTED, BACK, dot(hit.ray.along, hit.normal) >= 0.0);
    return vec4<u32>(bitcast<u32>(hit.at), hit_bits(kind, hit), bitcast<vec2<u32>>(surface_uv_mm(hit)));
}

struct Patch {
    @location(0) normal: vec4<u32>,
    @location(1) footprint: vec4<u32>,
}

// How it lies.
@fragment
fn patch_frame(corner: Corner) -> Patch {
    let kept = kept_at(corner);
    if kept.kind != PAINTED {
        discard;
    }
    let hit = kept_hit(corner, kept);
    let covered = footprint(hit, 1.0);
    let widening = gloss_widening(0.0, covered.mirrored_sides);
    let sides = vec4<f32>(covered.surface.footprint[0], covered.surface.footprint[1]);
    return Patch(bitcast<vec4<u32>>(vec4<f32>(hit.normal, widening)), bitcast<vec4<u32>>(sides));
}

// Which lamps of a layer do not reach it; `corner` has the layer's number.
@fragment
fn shadow_frame(corner: Corner) -> @location(0) vec4<u32> {
    let kept = kept_at(corner);
    if kept.kind != PAINTED {
        discard;
    }
    let hit = kept_hit(corner, kept);
    let point = world_point(hit);
    let first = corner.number * frame.lamps_a_layer;
    let end = min(first + frame.lamps_a_layer, scene.light_count);
    var shaded = 0u;
    for (var k = first; k < end; k++) {
        shaded |= select(0u, 1u, is_shaded(hit, light_at(scene.lights[k], point))) << (k - first);
    }
    return vec4<u32>(shaded, 0u, 0u, 0u);
}

fn kept_at(corner: Corner) -> Kept {
    let words = textureLoad(hit_map, vec2<u32>(corner.place.xy), 0);
    let bits = words.y;
    let object = select((bits >> 2u) & 15u, 0u, ALONE);
    let chart = (bits >> 6u) & 15u;
    return Kept(bits & 3u, object, chart, bits >> 10u, bitcast<f32>(words.x), bitcast<vec2<f32>>(words.zw));
}

// The whole hit.
fn kept_hit(corner: Corner, kept: Kept) -> Hit {
    return hit_on(frame_offset(corner.place), kept.object, kept.at, kept.part);
}

fn kept_seen(corner: Corner, kept: Kept) -> Seen {
    let place = vec2<u32>(corner.place.xy);
    let lies = bitcast<vec4<f32>>(textureLoad(normal_map, place, 0));
    let sides = bitcast<vec4<f32>>(textureLoad(footprint_map, place, 0));
    let axes = scene.objects[kept.object].axes;
    let ray = view_ray(scene.objects[kept.object].view, frame_offset(corner.place));
    let to_eye = -normalize(ray.along);
    let to_surface = shape_frame(scene.objects[kept.object].shape, kept.chart, lies.xyz);
    var seen: Seen;
    seen.surface.uv_mm = kept.uv_mm;
    seen.surface.chart = kept.object * CHARTS + kept.chart;
    seen.surface.seed = scene.seed;
    seen.surface.random = scene.random;
    seen.surface.footprint[0] = sides.xy;
    seen.surface.footprint[1] = sides.zw;
    seen.point = axes * (ray.base + ray.along * kept.at) + scene.objects[kept.object].position;
    seen.to_eye = to_eye;
    seen.normal = lies.xyz;
    seen.to_surface = to_surface * transpose(axes);
    seen.wo = to_surface * to_eye;
    seen.widening = lies.w;
    return seen;
}

// The bits of the layer that lamp `k` is in, if it is the first of that layer, else `bits`.
fn shadows_from(corner: Corner, k: u32, bits: u32) -> u32 {
    if k % frame.lamps_a_layer != 0u {
        return bits;
    }
    return textureLoad(shadow_map, vec2<u32>(corner.place.xy), k / frame.lamps_a_layer, 0).x;
}

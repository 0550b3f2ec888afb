// Entry points: a frame in real time, one sample a pixel. What a pixel meets is found once for a camera and a scene, and kept.

struct Frame {
    // What radiance is multiplied with.
    exposure: f32,
    // 0: flakes are seen with their mean only.
    sparkles: u32,
    // Columns and rows of the directions to the eye for which scattered light is kept, 2 or more.
    nodes: vec2<u32>,
    // What the radiance of maps has been multiplied with, so that half floats hold it.
    map_scale: f32,
}

// How the surroundings are known: not at all, by maps, or by as many directions a pixel as the scene says.
override SURROUNDINGS: u32 = 1u;
// Whether flakes are drawn from rows.
override ROWS: bool = false;
// Whether u of the paint's flakes follows the half vector; for rows.
override TURNING: bool = true;
// Whether objects may stand in each other's light.
override SHADES: bool = true;
// Whether flakes sparkle under the surroundings too.
override AROUND: bool = true;

@group(1) @binding(1) var<uniform> frame: Frame;
// See `geometry_frame`.
@group(2) @binding(0) var geometry_map: texture_2d<u32>;

const NOTHING: u32 = 0u;
const BACK: u32 = 1u;
const PAINTED: u32 = 2u;

struct Corner {
    @builtin(position) place: vec4<f32>,
    // The number of the paint that is shaded.
    @location(0) @interpolate(flat) paint: u32,
}

// A triangle around the whole picture; instance k shades what has paint k.
@vertex
fn whole(@builtin(vertex_index) k: u32, @builtin(instance_index) paint_number: u32) -> Corner {
    let place = vec2<f32>(f32((k & 1u) << 2u) - 1.0, f32((k & 2u) << 1u) - 1.0);
    return Corner(vec4<f32>(place, 0.0, 1.0), paint_number);
}

// What a pixel meets: where on its ray, its kind, the part that it has there (see `hit_on`), the object.
@fragment
fn geometry_frame(corner: Corner) -> @location(0) vec4<u32> {
    let hit = intersect(frame_offset(corner.place));
    if !hit.met {
        return vec4<u32>(0u, NOTHING, 0u, 0u);
    }
    let kind = select(PAINTED, BACK, dot(hit.ray.along, hit.normal) >= 0.0);
    return vec4<u32>(bitcast<u32>(hit.at), kind, hit.part, hit.object);
}

// Linear radiance times the exposure, of pixels that wear the paint.
@fragment
fn linear_frame(corner: Corner) -> @location(0) vec4<f32> {
    return vec4<f32>(painted_radiance(corner) * frame.exposure, 1.0);
}

// The same as eight bits want it: clipped, and encoded as sRGB.
@fragment
fn encoded_frame(corner: Corner) -> @location(0) vec4<f32> {
    return encoded(painted_radiance(corner) * frame.exposure);
}

// Of pixels that see no paint.
@fragment
fn linear_beyond(corner: Corner) -> @location(0) vec4<f32> {
    return vec4<f32>(radiance_beyond(corner) * frame.exposure, 1.0);
}

@fragment
fn encoded_beyond(corner: Corner) -> @location(0) vec4<f32> {
    return encoded(radiance_beyond(corner) * frame.exposure);
}

fn encoded(radiance: vec3<f32>) -> vec4<f32> {
    let linear = clamp(radiance, vec3<f32>(0.0), vec3<f32>(1.0));
    let bright = 1.055 * pow(linear, vec3<f32>(1.0 / 2.4)) - 0.055;
    return vec4<f32>(select(bright, 12.92 * linear, linear <= vec3<f32>(0.0031308)), 1.0);
}

// The middle of a pixel, from the middle of the picture.
fn frame_offset(place: vec4<f32>) -> vec2<f32> {
    return floor(place.xy) + 0.5 - scene.view.middle;
}

fn kind_of(kept: vec4<u32>) -> u32 {
    return kept.y;
}

fn object_of(kept: vec4<u32>) -> u32 {
    return kept.w;
}

fn wears(kept: vec4<u32>, corner: Corner) -> bool {
    return kind_of(kept) == PAINTED && scene.objects[object_of(kept)].paint == corner.paint;
}

// What is kept of a pixel that wears a paint. Others are discarded: a software renderer leaves a shader where all its pixels are,
// and runs through both sides of everything else.
fn kept_of_paint(corner: Corner) -> vec4<u32> {
    let kept = textureLoad(geometry_map, vec2<u32>(corner.place.xy), 0);
    if !wears(kept, corner) {
        discard;
    }
    return kept;
}

fn radiance_beyond(corner: Corner) -> vec3<f32> {
    let kept = textureLoad(geometry_map, vec2<u32>(corner.place.xy), 0);
    if kind_of(kept) == PAINTED {
        discard;
    }
    let seen = seen_beyond(normalize(view_ray(scene.view, frame_offset(corner.place)).along));
    return select(seen, vec3<f32>(0.0), kind_of(kept) == BACK);
}

fn painted_radiance(corner: Corner) -> vec3<f32> {
    let kept = kept_of_paint(corner);
    let offset = frame_offset(corner.place);
    let hit = kept_hit(offset, kept);
    let axes = scene.objects[hit.object].axes;
    let to_eye = -normalize(hit.ray.along);
    let covered = footprint(hit, 1.0);
    let turned = view_frame(scene.objects[hit.object].view, hit.normal);
    let to_world = axes * turned;
    let wo = to_eye * turned;
    let widening = gloss_widening(0.0, covered.mirrored_sides);
    let to_surface = surface_frame(hit);
    let world_to_surface = to_surface * transpose(axes);
    var around = vec3<f32>(0.0);
    if SURROUNDINGS == 2u {
        around = surroundings_scattered(to_world, wo, 0u, 0u, scene.directions)
            + surroundings_mirrored(to_world, wo, widening, 0u);
    } else if SURROUNDINGS == 1u {
        let scattered = scattered_around(axes * hit.normal, axes * to_eye, wo.z, corner.place.xy);
        around = (scattered + mirrored_around(to_world, wo, widening)) / frame.map_scale;
    }
    if AROUND && frame.sparkles != 0u {
        around += surroundings_sparkle(covered.surface, to_world, world_to_surface, wo, 0u, MAX_TAPS);
    }
    return around + lamps_radiance(hit, covered, world_to_surface, to_surface * to_eye);
}

// The hit of which the geometry pass kept this.
fn kept_hit(offset: vec2<f32>, kept: vec4<u32>) -> Hit {
    return hit_on(offset, kept.w, bitcast<f32>(kept.x), kept.z);
}

// BRDF times cosine under a lamp's middle, the part of one draw from rows, as `disc_part` of a small disc.
fn row_part(disc: Disc, wo: vec3<f32>, widening: f32, draw: RowDraw, d: Detail, sparkles: bool, first: bool) -> vec3<f32> {
    let wi = disc.direction;
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    var f = vec3<f32>(0.0);
    if sparkles {
        let g = geometry(coat_inner(wi), coat_inner(wo));
        let seen = flake_view(g, projected_half(wi, wo));
        // The whole disc is one patch.
        let square = disc.sine * disc.sine;
        let area = 4.0 * FRAC_PI_2 * square / (1.0 + sqrt(max(1.0 - square, 0.0)));
        var patches: array<LightPatch, MOST_PATCHES>;
        patches[0] = flake_patch(d, seen, area * half_stretch(wi, wo), 1.0);
        let fluctuation = xi_of_rows(draw, d, seen.slices, seen.half) - seen.mean;
        f = fluctuation * (kept(&patches, 1u) / f32(d.count));
        if first {
            f += seen.mean;
        }
        f *= transmittance(wi.z, wo.z) * wi.z;
    }
    if first {
        f += disc_part(disc, wo, widening, fixed_draw(0.5, vec3<f32>(0.5)), d, false, true);
    }
    return f;
}

// Radiance of all lamps, as `lamp_radiance` of each: the random numbers of a tap are the same for all of them.
fn lamps_radiance(hit: Hit, covered: Footprint, to_local: mat3x3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let sparkles = frame.sparkles != 0u && paint.flakes.levels > 0u;
    var d = Detail(vec2<f32>(0.0), 1u, 0u, 0.0);
    if sparkles {
        d = detail(covered.surface.footprint);
    }
    let point = world_point(hit);
    // A bit a lamp, found once for all taps.
    var lit = vec2<u32>(0xffffffffu);
    if SHADES {
        for (var k = 0u; k < scene.light_count; k++) {
            if is_shaded(hit, light_at(scene.lights[k], point)) {
                lit[k >> 5u] &= ~(1u << (k & 31u));
            }
        }
    }
    var sum = vec3<f32>(0.0);
    for (var tap = 0u; tap < d.count; tap++) {
        var draw: Draw;
        var drawn_row: RowDraw;
        if ROWS {
            drawn_row = row_draw(covered.surface, d, tap);
        } else if sparkles {
            draw = flake_draw(covered.surface, d, tap);
        }
        for (var k = 0u; k < scene.light_count; k++) {
            let seen = light_at(scene.lights[k], point);
            if ((lit[k >> 5u] >> (k & 31u)) & 1u) == 0u {
                continue;
            }
            let disc = Disc(to_local * seen.direction, seen.sine);
            let widening = gloss_widening(seen.angular_radius, covered.mirrored_sides);
            if ROWS {
                sum += row_part(disc, wo, widening, drawn_row, d, sparkles, tap == 0u) * seen.irradiance;
            } else {
                sum += disc_part(disc, wo, widening, draw, d, sparkles, tap == 0u) * seen.irradiance;
            }
            if tap == 0u {
                sum += lamp_mirrored(seen, covered, wo);
            }
        }
    }
    return sum;
}

// The lamp's disc as the coat mirrors it.
fn lamp_mirrored(seen: Incidence, covered: Footprint, wo: vec3<f32>) -> vec3<f32> {
    let reflectance = mirror_reflectance(wo);
    if reflectance > 0.0 {
        return lamp_disc(seen, covered) * reflectance;
    }
    return vec3<f32>(0.0);
}

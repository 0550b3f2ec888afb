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
    // Points that stand for the lamps of the surroundings.
    lamp_points: u32,
    // See `shadow_map`.
    lamps_a_layer: u32,
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
// Whether a lamp may be seen in several directions.
override WIDE_DISCS: bool = true;
// Whether random numbers repeat after some cells: software renderers divide integers lane by lane.
override TEXTURED: bool = true;
// Whether boxes may have bands between them.
override RAMPS: bool = true;
// Whether the coat mirrors the lamps themselves.
override MIRRORS: bool = true;

@group(1) @binding(1) var<uniform> frame: Frame;

struct Corner {
    @builtin(position) place: vec4<f32>,
    // Of the paint that is shaded, or what else is drawn one by one.
    @location(0) @interpolate(flat) number: u32,
}

// A triangle around the whole picture; instance k shades what has paint k.
@vertex
fn whole(@builtin(vertex_index) k: u32, @builtin(instance_index) number: u32) -> Corner {
    let place = vec2<f32>(f32((k & 1u) << 2u) - 1.0, f32((k & 2u) << 1u) - 1.0);
    return Corner(vec4<f32>(place, 0.0, 1.0), number);
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

// What is kept of a pixel that wears the paint. Others are discarded: a software renderer leaves a shader where all its pixels are,
// and runs through both sides of everything else.
fn kept_of_paint(corner: Corner) -> Kept {
    let kept = kept_at(corner);
    if kept.kind != PAINTED || scene.objects[kept.object].paint != corner.number {
        discard;
    }
    return kept;
}

fn radiance_beyond(corner: Corner) -> vec3<f32> {
    let kept = kept_at(corner);
    if kept.kind == PAINTED {
        discard;
    }
    let seen = seen_beyond(normalize(view_ray(scene.view, frame_offset(corner.place)).along));
    return select(seen, vec3<f32>(0.0), kept.kind == BACK);
}

fn painted_radiance(corner: Corner) -> vec3<f32> {
    let kept = kept_of_paint(corner);
    let seen = kept_seen(corner, kept);
    var sum = lamps_radiance(corner, kept, seen);
    if SURROUNDINGS == 0u {
        return sum;
    }
    let axes = scene.objects[kept.object].axes;
    let turned = view_frame(scene.objects[kept.object].view, seen.normal);
    let to_world = axes * turned;
    let wo = seen.to_eye * turned;
    if SURROUNDINGS == 2u {
        sum += surroundings_scattered(to_world, wo, 0u, 0u, scene.directions)
            + surroundings_mirrored(to_world, wo, seen.widening, 0u);
    } else {
        let scattered = scattered_around(axes * seen.normal, axes * seen.to_eye, wo.z, corner.place.xy);
        sum += (scattered + mirrored_around(to_world, wo, seen.widening)) / frame.map_scale;
    }
    if AROUND && frame.sparkles != 0u {
        sum += surroundings_sparkle(seen.surface, to_world, seen.to_surface, wo, 0u, MAX_TAPS);
    }
    return sum;
}

// Radiance of all lamps.
fn lamps_radiance(corner: Corner, kept: Kept, seen: Seen) -> vec3<f32> {
    let sparkles = frame.sparkles != 0u && paint.flakes.levels > 0u;
    var sum = vec3<f32>(0.0);
    var shadows = 0u;
    for (var k = 0u; k < scene.light_count; k++) {
        if SHADES {
            shadows = shadows_from(corner, k, shadows);
            if ((shadows >> (k % frame.lamps_a_layer)) & 1u) != 0u {
                continue;
            }
        }
        let light = light_at(scene.lights[k], seen.point);
        let disc = Disc(seen.to_surface * light.direction, light.sine);
        let widening = light.angular_radius * light.angular_radius / 8.0 + seen.widening;
        if ROWS {
            sum += row_radiance(seen.surface, disc, seen.wo, widening, sparkles) * light.irradiance;
        } else {
            sum += disc_radiance(seen.surface, disc, seen.wo, widening, sparkles) * light.irradiance;
        }
        if MIRRORS {
            sum += lamp_mirrored(light, footprint(kept_hit(corner, kept), 1.0), seen.wo);
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

// Entry points: a frame in real time, one sample a pixel. What a pixel meets is found once for a camera and a scene, and kept.

struct Frame {
    // What radiance is multiplied with.
    exposure: f32,
    // 0: flakes are seen with their mean only.
    sparkles: u32,
}

@group(1) @binding(1) var<uniform> frame: Frame;
// See `kept`.
@group(2) @binding(0) var geometry_map: texture_2d<u32>;

const NOTHING: u32 = 0u;
const BACK: u32 = 1u;
// Behind it the number of the paint.
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

// What a pixel meets: where on its ray, NOTHING, BACK or PAINTED, the chart.
@fragment
fn geometry_frame(corner: Corner) -> @location(0) vec4<u32> {
    let ray = frame_ray(corner.place);
    let hit = intersect(ray);
    if !hit.met {
        return vec4<u32>(0u, NOTHING, 0u, 0u);
    }
    let kind = select(PAINTED, BACK, dot(ray.along, hit.normal) >= 0.0);
    return vec4<u32>(bitcast<u32>(hit.at), kind, hit.chart, 0u);
}

// Linear radiance, times the exposure.
@fragment
fn linear_frame(corner: Corner) -> @location(0) vec4<f32> {
    return vec4<f32>(frame_radiance(corner) * frame.exposure, 1.0);
}

// The same as eight bits want it: clipped, and encoded as sRGB.
@fragment
fn encoded_frame(corner: Corner) -> @location(0) vec4<f32> {
    let linear = clamp(frame_radiance(corner) * frame.exposure, vec3<f32>(0.0), vec3<f32>(1.0));
    let bright = 1.055 * pow(linear, vec3<f32>(1.0 / 2.4)) - 0.055;
    return vec4<f32>(select(bright, 12.92 * linear, linear <= vec3<f32>(0.0031308)), 1.0);
}

// Through the middle of a pixel.
fn frame_ray(place: vec4<f32>) -> Ray {
    return view_ray(floor(place.xy) + 0.5 - scene.view.middle);
}

fn frame_radiance(corner: Corner) -> vec3<f32> {
    let kept = textureLoad(geometry_map, vec2<u32>(corner.place.xy), 0);
    // What is no paint belongs to the first.
    if max(kept.y, PAINTED) - PAINTED != corner.paint {
        discard;
    }
    let ray = frame_ray(corner.place);
    if kept.y == NOTHING {
        return seen_beyond(normalize(ray.along));
    }
    if kept.y == BACK {
        return vec3<f32>(0.0);
    }
    let hit = kept_hit(ray, kept);
    let to_eye = -normalize(ray.along);
    let covered = footprint(ray, hit, 1.0);
    let to_world = view_frame(hit.normal);
    let wo = to_eye * to_world;
    let widening = gloss_widening(0.0, covered.mirrored_sides);
    let around = surroundings_scattered(to_world, wo, 0u, 0u, scene.directions)
        + surroundings_mirrored(to_world, wo, widening, 0u);
    let to_surface = shape_frame(hit.chart, hit.normal);
    return around + lamps_radiance(covered, to_surface, to_surface * to_eye);
}

// The hit of which the geometry pass kept this.
fn kept_hit(ray: Ray, kept: vec4<u32>) -> Hit {
    let at = bitcast<f32>(kept.x);
    let point = ray.base + ray.along * at;
    return Hit(true, at, point, shape_normal(kept.z, point), kept.z);
}

// Radiance of all lamps, as `lamp_radiance` of each: the random numbers of a tap are the same for all of them.
fn lamps_radiance(covered: Footprint, to_local: mat3x3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let sparkles = frame.sparkles != 0u && paint.flakes.levels > 0u;
    var d = Detail(vec2<f32>(0.0), 1u, 0u, 0.0);
    if sparkles {
        d = detail(covered.surface.footprint);
    }
    var sum = vec3<f32>(0.0);
    for (var tap = 0u; tap < d.count; tap++) {
        var draw: Draw;
        if sparkles {
            draw = flake_draw(covered.surface, d, tap);
        }
        for (var k = 0u; k < scene.light_count; k++) {
            let seen = light_at(scene.lights[k], covered.point);
            let wi = to_local * seen.direction;
            if wi.z > 0.0 && wo.z > 0.0 {
                let g = geometry(coat_inner(wi), coat_inner(wo));
                var f = vec3<f32>(0.0);
                if sparkles {
                    let taps = flake_slices(g.theta_h, g.theta_i);
                    let half = projected_half(wi, wo);
                    f = xi_of_draw(draw, d.level, d.fraction, taps, half) * transmittance(wi.z, wo.z) / f32(d.count);
                }
                if tap == 0u {
                    let widening = gloss_widening(seen.angular_radius, covered.mirrored_sides);
                    f += under_coat(g, vec3<f32>(0.0), wi, wo, widening);
                }
                sum += f * seen.irradiance * wi.z;
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

// Twin of render/lamp.rs.

const DISC_GRID: u32 = 4u;

// Radiance of a lamp towards the eye, `wo` in the frame `to_local`, which is fixed to the surface.
fn lamp_radiance(seen: Incidence, covered: Footprint, to_local: mat3x3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let disc = Disc(to_local * seen.direction, seen.sine);
    let widening = gloss_widening(seen.angular_radius, covered.mirrored_sides);
    var sum = disc_radiance(covered.surface, disc, wo, widening, paint.flakes.levels > 0u) * seen.irradiance;
    let reflectance = mirror_reflectance(wo);
    if reflectance > 0.0 {
        sum += lamp_disc(seen, covered) * reflectance;
    }
    return sum;
}

// Mean radiance of the disc over the mirrored directions of a sample.
fn lamp_disc(seen: Incidence, covered: Footprint) -> vec3<f32> {
    let a = covered.mirrored_sides[0];
    let b = covered.mirrored_sides[1];
    let radius = seen.angular_radius;
    if angle_between(seen.direction, covered.mirrored) > radius + length(a) + length(b) {
        return vec3<f32>(0.0);
    }
    let spacing = max(length(a), length(b)) / f32(DISC_GRID);
    let soft = min(0.5 * spacing, radius);
    var sum = 0.0;
    for (var k = 0u; k < DISC_GRID * DISC_GRID; k++) {
        let at = (vec2<f32>(f32(k % DISC_GRID), f32(k / DISC_GRID)) + 0.5) / f32(DISC_GRID) - 0.5;
        let excess = angle_between(seen.direction, covered.mirrored + a * at.x + b * at.y) - radius;
        if soft > 0.0 {
            sum += clamp(0.5 - 0.5 * excess / soft, 0.0, 1.0);
        } else {
            sum += select(0.0, 1.0, excess < 0.0);
        }
    }
    let share = sum / f32(DISC_GRID * DISC_GRID);
    return seen.irradiance * (share * FRAC_1_PI / (seen.sine * seen.sine));
}

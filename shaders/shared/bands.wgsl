// Twin of `Ramp` of cluster/bands.rs.

struct Ramp {
    slope: f32,
    middle: f32,
}

// Share of what lies behind the boundary, at `beyond` = u less the boundary.
fn share(ramp: Ramp, beyond: f32) -> f32 {
    return clamp(ramp.middle + ramp.slope * beyond, 0.0, 1.0);
}

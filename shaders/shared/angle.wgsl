// The angle of (x, y) in the first quadrant, radians, to 2e-7: the built-in atan2 may be off by 4096 units in the last place.
// Twin of the library's atan2 that render/shade.rs calls; polynomial of Cephes' atanf (Moshier 1989).

fn angle(y: f32, x: f32) -> f32 {
    let near = min(x, y);
    let far = max(x, y);
    if far == 0.0 {
        return 0.0;
    }
    // Beyond pi/8 from the axis the difference to the diagonal is smaller.
    let from_diagonal = near > 0.41421357 * far;
    let t = select(near / far, (near - far) / (near + far), from_diagonal);
    let z = t * t;
    var p = 0.080537446;
    p = p * z - 0.13877685;
    p = p * z + 0.1997771;
    p = p * z - 0.33332950;
    let arc = t + t * z * p + select(0.0, FRAC_PI_4, from_diagonal);
    return select(arc, FRAC_PI_2 - arc, y > x);
}

// The angle of (x, y) in any quadrant, -pi to pi.
fn full_angle(y: f32, x: f32) -> f32 {
    let first = angle(abs(y), abs(x));
    let upper = select(first, 2.0 * FRAC_PI_2 - first, x < 0.0);
    return select(upper, -upper, y < 0.0);
}

// Angle between two vectors of any length, exact for small angles.
fn angle_between(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return full_angle(length(cross(a, b)), dot(a, b));
}

// Cosine and sine of a share of a full turn: the built-in ones may be off by 5e-4.
fn circle(share: f32) -> vec2<f32> {
    let quarter = floor(4.0 * share + 0.5);
    let near = turn((4.0 * share - quarter) * FRAC_PI_2);
    switch i32(quarter) & 3 {
        case 1: { return vec2<f32>(-near.y, near.x); }
        case 2: { return -near; }
        case 3: { return vec2<f32>(near.y, -near.x); }
        default: { return near; }
    }
}

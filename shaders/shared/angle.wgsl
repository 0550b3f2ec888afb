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

// Twin of color/lab_f32.rs: signed Lab to linear RGB.

const DELTA: f32 = 6.0 / 29.0;
const ZERO: f32 = 4.0 / 29.0;
const SLOPE: f32 = 3.0 * DELTA * DELTA;

// Linear RGB from XYZ over the white, a row each.
const RED_FROM_RELATIVE: vec3<f32> = vec3<f32>(3.080399, -1.5373832, -0.5430159);
const GREEN_FROM_RELATIVE: vec3<f32> = vec3<f32>(-0.92122334, 1.8759675, 0.04525586);
const BLUE_FROM_RELATIVE: vec3<f32> = vec3<f32>(0.05287394, -0.20397696, 1.151103);

fn expand(f: f32) -> f32 {
    let above = abs(f);
    let root = above + ZERO;
    let x = select(above * SLOPE, root * root * root, above > DELTA - ZERO);
    return select(x, -x, f < 0.0);
}

fn rgb_from_lab_f32(lab: vec3<f32>) -> vec3<f32> {
    let y = lab.x / 116.0;
    let relative = vec3<f32>(expand(y + lab.y / 500.0), expand(y), expand(y - lab.z / 200.0));
    return vec3<f32>(
        dot(RED_FROM_RELATIVE, relative),
        dot(GREEN_FROM_RELATIVE, relative),
        dot(BLUE_FROM_RELATIVE, relative),
    );
}

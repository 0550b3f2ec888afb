// Twin of scene/camera.rs. The CPU's rays start at the eye, in f64; here they start beside the object, so that f32 rounds a
// place on it by a share of the object's size, not of its distance.

struct View {
    // The point of the line of sight that is nearest to the origin, millimetres.
    foot: vec3<f32>,
    // Its distance from the eye, negative behind it.
    reach: f32,
    forward: vec3<f32>,
    // A pixel at a distance of 1.
    right: vec3<f32>,
    down: vec3<f32>,
    middle: vec2<f32>,
}

// The points base + s along; the eye is at s = -reach.
struct Ray {
    base: vec3<f32>,
    along: vec3<f32>,
}

// Through the point of the picture so many pixels from its middle.
fn view_ray(view: View, offset: vec2<f32>) -> Ray {
    let aside = view.right * offset.x + view.down * offset.y;
    return Ray(view.foot + aside * view.reach, view.forward + aside);
}

// Columns tangent, bitangent, `normal`: the camera's frame turned the short way.
fn view_frame(view: View, normal: vec3<f32>) -> mat3x3<f32> {
    let back = -view.forward;
    let axis = cross(back, normal);
    // Only the opposite of the line of sight has none; no surface that is seen faces there.
    let scale = 1.0 / max(1.0 + dot(back, normal), 1e-6);
    return mat3x3<f32>(
        turned(normalize(view.right), axis, scale),
        turned(normalize(-view.down), axis, scale),
        normal,
    );
}

// Rodrigues' rotation by the angle whose sine is the axis's length.
fn turned(v: vec3<f32>, axis: vec3<f32>, scale: f32) -> vec3<f32> {
    let across = cross(axis, v);
    return v + across + cross(axis, across) * scale;
}

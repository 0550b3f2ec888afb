// Twin of scene/light.rs: all kinds of lamps by the same numbers.

struct Light {
    // The center, millimetres, or the unit vector towards a lamp that is too far to have one.
    place: vec3<f32>,
    // Share of a point's own place that counts: 1, or 0 from afar.
    nearness: f32,
    // Irradiance at a distance of 1.
    power: vec3<f32>,
    // Of the ball, or the sine of the disc's angular radius.
    radius: f32,
    axis: vec3<f32>,
    // Half the opening angle of the cone, radians; beyond pi: no cone.
    cone: f32,
    edge: f32,
}

struct Incidence {
    direction: vec3<f32>,
    irradiance: vec3<f32>,
    // Radians, and its sine.
    angular_radius: f32,
    sine: f32,
    // Of the center, millimetres; as good as infinite from afar.
    distance: f32,
}

fn light_at(light: Light, point: vec3<f32>) -> Incidence {
    let way = light.place - light.nearness * point;
    let center = length(way);
    let distance = max(center, light.radius);
    var direction = vec3<f32>(0.0, 0.0, 1.0);
    if center > 0.0 {
        direction = way / center;
    }
    let inside = light.cone - angle_between(light.axis, -direction);
    var x = 1.0;
    if inside < light.edge {
        x = max(inside / light.edge, 0.0);
    } else if inside < 0.0 {
        x = 0.0;
    }
    let sine = light.radius / distance;
    return Incidence(
        direction,
        light.power * (x * x * (3.0 - 2.0 * x) / (distance * distance)),
        angle(light.radius, sqrt((distance - light.radius) * (distance + light.radius))),
        sine,
        select(3e38, center, light.nearness > 0.0),
    );
}

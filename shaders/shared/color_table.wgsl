// Twin of brdf/color_table.rs.

fn color_table_sample(theta_h: f32, theta_i: f32) -> vec3<f32> {
    let h = bracket(theta_h, paint.colors_size.x);
    let i = bracket(theta_i, paint.colors_size.y);
    let first = i.low * paint.colors_size.x + h.low;
    let next = first + paint.colors_size.x;
    return (1.0 - h.share) * (1.0 - i.share) * vector(colors[first])
        + h.share * (1.0 - i.share) * vector(colors[first + 1u])
        + (1.0 - h.share) * i.share * vector(colors[next])
        + h.share * i.share * vector(colors[next + 1u]);
}

// The texel before an angle, and the weight of the one behind.
struct Bracket {
    low: u32,
    share: f32,
}

fn bracket(theta: f32, n: u32) -> Bracket {
    let last = f32(n - 1u);
    let x = clamp(theta * FRAC_2_PI * last, 0.0, last);
    let low = min(u32(x), n - 2u);
    return Bracket(low, x - f32(low));
}

// Twin of render/draws.rs.

// The random numbers of one tap.
struct Draw {
    // Where in the box of a cluster, in (0, 1).
    inside: vec3<f32>,
    // Which cluster, unless it hangs on the half vector.
    fixed_u: f32,
    turning: bool,
    fine: KnotLattice,
    // Of the next level, with its share.
    coarse: KnotLattice,
    fraction: f32,
}

fn fixed_draw(u: f32, inside: vec3<f32>) -> Draw {
    var draw: Draw;
    draw.inside = inside;
    draw.fixed_u = u;
    return draw;
}

// `coarse` counts where `fraction` is above 0.
fn draw_of_words(fine: vec4<u32>, coarse: vec4<u32>, fraction: f32, turning: bool) -> Draw {
    var inside = units(fine.yzw);
    if fraction > 0.0 {
        let far = units(coarse.yzw);
        inside = vec3<f32>(
            uniform_blend(inside.x, far.x, fraction),
            uniform_blend(inside.y, far.y, fraction),
            uniform_blend(inside.z, far.z, fraction),
        );
    }
    var draw = fixed_draw(unit(fine.x), inside);
    if turning {
        draw.turning = true;
        draw.fraction = fraction;
        draw.fine = knot_lattice(pcg4d(fine));
        if fraction > 0.0 {
            draw.coarse = knot_lattice(pcg4d(coarse));
        }
    } else if fraction > 0.0 {
        draw.fixed_u = cdf(normal_blend(probit(draw.fixed_u), probit(unit(coarse.x)), fraction));
    }
    return draw;
}

fn draw_u(draw: Draw, place: vec2<f32>) -> f32 {
    if !draw.turning {
        return draw.fixed_u;
    }
    let g = knot_value(draw.fine, place);
    if draw.fraction == 0.0 {
        return cdf(g);
    }
    return cdf(normal_blend(g, knot_value(draw.coarse, place), draw.fraction));
}

fn units(bits: vec3<u32>) -> vec3<f32> {
    return vec3<f32>(unit(bits.x), unit(bits.y), unit(bits.z));
}

fn normal_blend(near: f32, far: f32, fraction: f32) -> f32 {
    let a = 1.0 - fraction;
    let b = fraction;
    return (a * near + b * far) / sqrt(a * a + b * b);
}

fn uniform_blend(a: f32, b: f32, f: f32) -> f32 {
    let narrow = min(f, 1.0 - f);
    let wide = max(f, 1.0 - f);
    let x = (1.0 - f) * a + f * b;
    let nearer = min(x, 1.0 - x);
    var rising: f32;
    if nearer < narrow {
        rising = nearer * nearer / (2.0 * narrow * wide);
    } else {
        rising = (nearer - narrow / 2.0) / wide;
    }
    return select(1.0 - rising, rising, x <= 0.5);
}

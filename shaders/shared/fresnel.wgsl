// Twin of brdf/fresnel.rs.

fn dielectric(cos_i: f32, eta: f32) -> f32 {
    if eta == 1.0 {
        return 0.0;
    }
    let inside = min(cos_i, 1.0);
    let cos_t = refracted_cosine(inside, eta);
    let s = (inside - eta * cos_t) / (inside + eta * cos_t);
    let p = (eta * inside - cos_t) / (eta * inside + cos_t);
    return (s * s + p * p) / 2.0;
}

fn transmitted(cos_i: f32, eta: f32) -> f32 {
    if eta == 1.0 {
        return 1.0;
    }
    let inside = min(cos_i, 1.0);
    let cos_t = refracted_cosine(inside, eta);
    let s = inside + eta * cos_t;
    let p = eta * inside + cos_t;
    return 2.0 * eta * inside * cos_t * (1.0 / (s * s) + 1.0 / (p * p));
}

fn refracted_cosine(cos_i: f32, eta: f32) -> f32 {
    if eta == 1.0 {
        return cos_i;
    }
    return sqrt(refracted_squared(min(cos_i, 1.0), eta));
}

fn refracted_squared(cos_i: f32, eta: f32) -> f32 {
    return ((eta - 1.0) * (eta + 1.0) + cos_i * cos_i) / (eta * eta);
}

fn schlick(f0: f32, cos_d: f32) -> f32 {
    let m = max(1.0 - cos_d, 0.0);
    let m2 = m * m;
    return f0 + (1.0 - f0) * (m2 * m2 * m);
}

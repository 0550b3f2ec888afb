// Twin of brdf/cook_torrance.rs.

struct LobeGeometry {
    tan2_h: f32,
    cos_h: f32,
    cos_i: f32,
    cos_o: f32,
    cos_d: f32,
}

fn beckmann(tan2_h: f32, cos_h: f32, roughness: f32) -> f32 {
    let a2 = roughness * roughness;
    let c2 = cos_h * cos_h;
    let exponent = -(tan2_h / a2) * LOG2_E;
    // Where an f32 is no normal number any more.
    if !(exponent > -126.0) {
        return 0.0;
    }
    return exp2_f32(exponent) / (a2 * c2 * c2);
}

fn v_cavity(g: LobeGeometry) -> f32 {
    let twice = 2.0 * g.cos_h / g.cos_d;
    return min(min(1.0, twice * g.cos_o), twice * g.cos_i);
}

fn lobe_eval(lobe: Lobe, g: LobeGeometry) -> f32 {
    if g.cos_i <= 0.0 || g.cos_o <= 0.0 || g.cos_h <= 0.0 {
        return 0.0;
    }
    let d = beckmann(g.tan2_h, g.cos_h, lobe.roughness);
    return lobe.coefficient * FRAC_1_PI * d * schlick(lobe.f0, g.cos_d) * v_cavity(g) / (g.cos_i * g.cos_o);
}

// A lobe, its squared roughness enlarged by `widening`.
fn widened(lobe: Lobe, widening: f32) -> Lobe {
    var wide = lobe;
    if widening > 0.0 {
        wide.roughness = sqrt(lobe.roughness * lobe.roughness + widening);
    }
    return wide;
}

fn brightness(g: LobeGeometry, widening: f32) -> f32 {
    if g.cos_i <= 0.0 || g.cos_o <= 0.0 {
        return 0.0;
    }
    var sum = paint.diffuse * FRAC_1_PI;
    for (var k = 0u; k < paint.lobe_count; k++) {
        sum += lobe_eval(widened(paint.lobes[k], widening), g);
    }
    return sum;
}

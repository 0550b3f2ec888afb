// Twin of render/proposal.rs.

fn proposal_sample(wo: vec3<f32>, at: vec2<f32>) -> vec3<f32> {
    var choice = at.x;
    for (var k = 0u; k < paint.lobe_count; k++) {
        let technique = paint.techniques[k];
        if choice < technique.probability {
            let half = half_vector(technique.roughness, vec2<f32>(choice / technique.probability, at.y));
            return mirrored(wo, half);
        }
        choice -= technique.probability;
    }
    let square = min(choice / paint.cosine, 1.0);
    return vec3<f32>(sqrt(square) * circle(at.y), sqrt(1.0 - square));
}

fn proposal_density(wi: vec3<f32>, g: LobeGeometry) -> f32 {
    var sum = paint.cosine * wi.z * FRAC_1_PI;
    for (var k = 0u; k < paint.lobe_count; k++) {
        sum += paint.techniques[k].probability * half_vector_density(g, paint.techniques[k].roughness);
    }
    return sum;
}

fn half_vector(roughness: f32, at: vec2<f32>) -> vec3<f32> {
    let tangent = roughness * sqrt(-ln(max(1.0 - at.x, 1e-7)));
    return normalize(vec3<f32>(tangent * circle(at.y), 1.0));
}

fn half_vector_density(g: LobeGeometry, roughness: f32) -> f32 {
    return FRAC_1_PI * beckmann(g.tan2_h, g.cos_h, roughness) * g.cos_h / (4.0 * g.cos_d);
}

fn mirrored(w: vec3<f32>, half: vec3<f32>) -> vec3<f32> {
    return normalize(half * (2.0 * dot(w, half)) - w);
}

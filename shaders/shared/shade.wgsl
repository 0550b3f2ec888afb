// Twin of render/shade.rs.

struct Geometry {
    lobe: LobeGeometry,
    theta_h: f32,
    theta_i: f32,
}

fn geometry(wi: vec3<f32>, wo: vec3<f32>) -> Geometry {
    let sum = wi + wo;
    return Geometry(
        lobe_geometry(wi, wo),
        angle(length(sum.xy), sum.z),
        angle(length(wi - wo), length(sum)),
    );
}

fn lobe_geometry(wi: vec3<f32>, wo: vec3<f32>) -> LobeGeometry {
    let sum = wi + wo;
    let l = length(sum);
    return LobeGeometry(dot(sum.xy, sum.xy) / (sum.z * sum.z), sum.z / l, wi.z, wo.z, 0.5 * l);
}

// The direction that the base sees.
fn coat_inner(outer: vec3<f32>) -> vec3<f32> {
    if paint.coat.refracts == 0u {
        return outer;
    }
    return vec3<f32>(outer.xy / paint.coat.ior, refracted_cosine(outer.z, paint.coat.ior));
}

// `(1 - F(wi)) (1 - F(wo))`, for outer cosines.
fn transmittance(cos_i: f32, cos_o: f32) -> f32 {
    return transmitted(cos_i, paint.coat.ior) * transmitted(cos_o, paint.coat.ior);
}

// The gloss lobe, 1/sr, its squared roughness enlarged by `widening`.
fn coat_gloss(wi: vec3<f32>, wo: vec3<f32>, widening: f32) -> f32 {
    if paint.coat.gloss.coefficient == 0.0 {
        return 0.0;
    }
    return lobe_eval(widened(paint.coat.gloss, widening), lobe_geometry(wi, wo));
}

// Share of the light that the ideal mirror reflects towards `wo`.
fn mirror_reflectance(wo: vec3<f32>) -> f32 {
    return paint.coat.mirror * dielectric(wo.z, paint.coat.ior);
}

// What blurs the gloss lobe, as an addition to its squared roughness.
fn gloss_widening(angular_radius: f32, mirrored_sides: array<vec3<f32>, 2>) -> f32 {
    let spread = dot(mirrored_sides[0], mirrored_sides[0]) + dot(mirrored_sides[1], mirrored_sides[1]);
    return angular_radius * angular_radius / 8.0 + spread / 48.0;
}

// BRDF without the ideal mirror, linear Rec.709, 1/sr, no cosine; 0 below the horizon.
fn shade(surface: Surface, wi: vec3<f32>, wo: vec3<f32>, widening: f32) -> vec3<f32> {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let g = geometry(coat_inner(wi), coat_inner(wo));
    var flakes = vec3<f32>(0.0);
    if paint.flakes.levels > 0u {
        flakes = xi(surface, g.theta_h, g.theta_i, projected_half(wi, wo));
    }
    return under_coat(g, flakes, wi, wo, widening);
}

// BRDF under many directions at once, where flakes count with their mean; gloss left out.
fn shade_mean(wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let g = geometry(coat_inner(wi), coat_inner(wo));
    return base(g, 0.0, xi_mean(g.theta_h, g.theta_i)) * transmittance(wi.z, wo.z);
}

// `transmittance base + gloss`.
fn under_coat(g: Geometry, xi: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>, widening: f32) -> vec3<f32> {
    return base(g, 0.0, xi) * transmittance(wi.z, wo.z) + coat_gloss(wi, wo, widening);
}

// `chi (a/pi + sum CT) + Xi`, the squared roughness of the lobes enlarged by `widening`.
fn base(g: Geometry, widening: f32, xi: vec3<f32>) -> vec3<f32> {
    return color_table_sample(g.theta_h, g.theta_i) * brightness(g.lobe, widening) + xi;
}

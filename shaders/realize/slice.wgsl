// What weights make of the numbers of a slice: mean, gain, and what its draws remember.

// Amplitudes of what draws remember, blended linearly: those of the realized clusters would take an expansion of each slice anew.
fn remember(number: u32, slice: MixSlice) {
    var lasting = 0.0;
    var fading = vec4<f32>(0.0);
    for (var k = 0u; k < blend.paints; k++) {
        let of_paint = moments[slice.first_moments + k];
        let f = of_paint.fading;
        lasting += blend.weights[k].x * of_paint.lasting;
        fading += blend.weights[k].x * vec4<f32>(f[0], f[1], f[2], f[3]);
    }
    realized_slices[number].lasting = max(lasting, 0.0);
    realized_slices[number].fading = max(fading, vec4<f32>(0.0));
}

// What the mean of the slice is to be.
fn mean_of_paints(slice: MixSlice) -> vec3<f32> {
    if blend.channels == LIGHTNESS {
        return vector(moments[slice.first_moments + blend.source].mean);
    }
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < blend.paints; k++) {
        sum += blend.weights[k].x * vector(moments[slice.first_moments + k].mean);
    }
    return sum;
}

fn gain_of_slice(slice: MixSlice, mean: vec3<f32>, deviation: vec3<f32>) -> vec3<f32> {
    if blend.gain == SOURCES_GAIN {
        return vector(moments[slice.first_moments + blend.source].gain);
    }
    var own = vec3<f32>(0.0);
    var roots = vec3<f32>(0.0);
    var beyond = vec3<f32>(0.0);
    for (var k = 0u; k < blend.paints; k++) {
        let m = moments[slice.first_moments + k];
        own += blend.weights[k].x * vector(m.gain);
        let wide = vector(m.gain) * vector(m.deviation);
        roots += blend.weights[k].y * cube_root(wide);
        beyond += blend.weights[k].z * wide;
    }
    own = clamp(own, vec3<f32>(0.0), vec3<f32>(1e3));
    if blend.gain == OWN_GAIN {
        return own;
    }
    let wanted = max(roots * roots * roots + beyond, vec3<f32>(0.0));
    // Scatter below the rounding of the mean is none.
    let none = deviation <= 3e-6 * abs(mean) + 1e-30;
    let gain = min(wanted / max(deviation, vec3<f32>(1e-30)), vec3<f32>(1e3));
    return select(gain, own, none | (abs(gain - own) <= 1e-5 * own));
}

// Of numbers that are 0 or more: by the exponent, then Newton's rule.
fn cube_root(x: vec3<f32>) -> vec3<f32> {
    let safe = max(x, vec3<f32>(1e-30));
    var root = bitcast<vec3<f32>>(bitcast<vec3<u32>>(safe) / 3u + 709921077u);
    for (var k = 0u; k < 4u; k++) {
        root = (2.0 * root + safe / (root * root)) / 3.0;
    }
    return select(root, vec3<f32>(0.0), x <= vec3<f32>(0.0));
}

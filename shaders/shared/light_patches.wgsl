// Twin of render/light_patches.rs, and of the struct of render/memory.rs.

const RANGES: vec4<f32> = vec4<f32>(0.3841, 0.1775, 0.0625, 0.00965);
const FAR: f32 = 16.0;
// Most patches of a disc, and of the surroundings.
const MOST_PATCHES: u32 = 52u;

struct Memory {
    // Deviation of what stays, whatever the half vector, and of what forgets within the ranges.
    lasting: f32,
    fading: vec4<f32>,
}

struct LightPatch {
    place: vec2<f32>,
    variance: f32,
    alone: f32,
    own_variance: f32,
    memory: Memory,
}

fn variance_of(area: f32) -> f32 {
    return 0.25 * FRAC_1_PI * area;
}

// What a patch has in common with itself, of the variance of its middle.
fn patch_common(light: LightPatch) -> vec4<f32> {
    let even = RANGES / (RANGES + 2.0 * light.variance);
    return mix(even, RANGES / (RANGES + 2.0 * light.own_variance), light.alone);
}

fn kept(patches: ptr<function, array<LightPatch, MOST_PATCHES>>, count: u32) -> f32 {
    var largest = 0.0;
    for (var k = 0u; k < count; k++) {
        let memory = (*patches)[k].memory;
        let fading = max(max(memory.fading.x, memory.fading.y), max(memory.fading.z, memory.fading.w));
        largest = max(largest, max(memory.lasting, fading));
    }
    if largest == 0.0 {
        return 1.0;
    }
    var lasting = 0.0;
    for (var k = 0u; k < count; k++) {
        lasting += (*patches)[k].memory.lasting / largest;
    }
    var integral = lasting * lasting;
    var taps = integral;
    for (var k = 0u; k < count; k++) {
        let one = (*patches)[k];
        let fading = one.memory.fading / largest;
        taps += dot(fading * fading, vec4<f32>(1.0));
        integral += dot(fading * fading, patch_common(one));
        for (var l = 0u; l < k; l++) {
            let two = (*patches)[l];
            let step = one.place - two.place;
            let square = dot(step, step);
            let wide = RANGES + (one.variance + two.variance);
            if square > FAR * wide.x {
                continue;
            }
            let both = 2.0 * fading * (two.memory.fading / largest);
            integral += dot(both, bells(square, wide) * RANGES / wide);
            if square <= FAR * RANGES.x {
                taps += dot(both, bells(square, RANGES));
            }
        }
    }
    return sqrt(integral / taps);
}

// `kept` of one even patch alone.
fn kept_of_one(light: LightPatch) -> f32 {
    let both = light.memory.fading * light.memory.fading;
    let lasting = light.memory.lasting * light.memory.lasting;
    let taps = lasting + dot(both, vec4<f32>(1.0));
    if taps > 0.0 {
        return sqrt((lasting + dot(both, RANGES / (RANGES + 2.0 * light.variance))) / taps);
    }
    return 1.0;
}

fn bells(square: f32, ranges: vec4<f32>) -> vec4<f32> {
    if square == 0.0 {
        return vec4<f32>(1.0);
    }
    let exponent = max((-0.5 * LOG2_E * square) / ranges, vec4<f32>(-125.0));
    return vec4<f32>(exp2_f32(exponent.x), exp2_f32(exponent.y), exp2_f32(exponent.z), exp2_f32(exponent.w));
}

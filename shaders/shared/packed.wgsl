// Twin of render/packed.rs: boxes and bands in few bits.

struct LabBox {
    low: vec3<f32>,
    high: vec3<f32>,
}

const MOST_STEPS: f32 = 16383.0;
// Biased exponent of the smallest step.
const SMALLEST_STEP: i32 = 87;

fn pack_box(corners: LabBox) -> array<u32, 3> {
    let sides = max(abs(corners.low), abs(corners.high));
    let largest = max(sides.x, max(sides.y, sides.z));
    let exponent = u32(clamp(i32(bitcast<u32>(largest * 1.0001) >> 23u) - 13 - SMALLEST_STEP, 0, 63));
    let per_step = bitcast<f32>((254u - u32(SMALLEST_STEP) - exponent) << 23u);
    let most = vec3<f32>(MOST_STEPS);
    let low = vec3<u32>(vec3<i32>(clamp(round(corners.low * per_step), -most, most))) & vec3<u32>(0x7fffu);
    let high = vec3<u32>(vec3<i32>(clamp(round(corners.high * per_step), -most, most))) & vec3<u32>(0x7fffu);
    let parts = (vec3<u32>(exponent) >> vec3<u32>(0u, 2u, 4u)) & vec3<u32>(3u);
    let words = low | (high << vec3<u32>(15u)) | (parts << vec3<u32>(30u));
    return array<u32, 3>(words.x, words.y, words.z);
}

fn unpack_box(packed: array<u32, 3>) -> LabBox {
    let words = vec3<u32>(packed[0], packed[1], packed[2]);
    let parts = words >> vec3<u32>(30u);
    let step = bitcast<f32>(((parts.x | (parts.y << 2u) | (parts.z << 4u)) + u32(SMALLEST_STEP)) << 23u);
    let low = bitcast<vec3<i32>>(words << vec3<u32>(17u)) >> vec3<u32>(17u);
    let high = bitcast<vec3<i32>>(words << vec3<u32>(2u)) >> vec3<u32>(17u);
    return LabBox(vec3<f32>(low) * step, vec3<f32>(high) * step);
}

fn pack_ramp(ramp: Ramp) -> u32 {
    let code = ((bitcast<u32>(ramp.slope) + 512u) >> 10u) - (126u << 13u);
    let packed = (code << 14u) | u32(min(round(ramp.middle * 16384.0), 16383.0));
    return select(packed, 0u, ramp.slope <= 0.0);
}

fn unpack_ramp(packed: u32) -> Ramp {
    let slope = bitcast<f32>(((packed >> 14u) + (126u << 13u)) << 10u);
    let middle = f32(packed & 16383u) / 16384.0;
    return Ramp(select(slope, 0.0, packed == 0u), select(middle, 0.0, packed == 0u));
}

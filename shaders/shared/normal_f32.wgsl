// Twin of math/normal_f32.rs: Horner's rule written out.

const TAIL: f32 = 5.0;

fn probit(p: f32) -> f32 {
    let w = -ln(4.0 * p * (1.0 - p));
    // Of two series the one that holds, without a branch: a software renderer takes both sides.
    let is_tail = w >= TAIL;
    let x = select(w * 0.4 - 1.0, (w - 10.129619) * 0.19494626, is_tail);
    var slope = select(0.0001231515, 0.00090908166, is_tail);
    slope = slope * x + select(0.00059338805, -0.0015671276, is_tail);
    slope = slope * x + select(-0.0024367974, 2.5606003e-5, is_tail);
    slope = slope * x + select(-0.0012144507, 0.003573379, is_tail);
    slope = slope * x + select(0.024152359, -0.015897404, is_tail);
    slope = slope * x + select(-0.055406567, 0.063690044, is_tail);
    slope = slope * x + select(-0.07385214, -0.2784877, is_tail);
    slope = slope * x + select(1.7440133, 2.2895374, is_tail);
    slope = slope * x + select(4.2466273, 8.531282, is_tail);
    return (p - 0.5) * slope;
}

fn cdf(z: f32) -> f32 {
    let far = min(abs(z), 5.4);
    let x = far * 0.3478261 - 1.0;
    var slope = 9.3221126e-5;
    slope = slope * x - 0.00028520406;
    slope = slope * x + 0.00029899817;
    slope = slope * x + 0.00010406669;
    slope = slope * x - 0.001540034;
    slope = slope * x + 0.006110202;
    slope = slope * x - 0.018419093;
    slope = slope * x + 0.048021674;
    slope = slope * x - 0.115488626;
    slope = slope * x - 1.803581;
    slope = slope * x - 2.7656806;
    let tail = exp2_f32(far * slope - 1.0);
    return select(1.0 - tail, tail, z < 0.0);
}

fn ln(x: f32) -> f32 {
    let bits = bitcast<i32>(x);
    let exponent = (bits - 0x3f3504f3) >> 23u;
    let t = bitcast<f32>(bits - (exponent << 23u)) - 1.0;
    var quotient = 0.08959908;
    quotient = quotient * t - 0.1448227;
    quotient = quotient * t + 0.14917415;
    quotient = quotient * t - 0.1654373;
    quotient = quotient * t + 0.19958413;
    quotient = quotient * t - 0.25002947;
    quotient = quotient * t + 0.3333416;
    quotient = quotient * t - 0.4999998;
    quotient = quotient * t + 1.0;
    return f32(exponent) * LN_2 + t * quotient;
}

fn exp2_f32(x: f32) -> f32 {
    let whole = floor(x);
    let part = x - whole;
    var slope = 0.00021612919;
    slope = slope * part + 0.0012467845;
    slope = slope * part + 0.009675452;
    slope = slope * part + 0.055485282;
    slope = slope * part + 0.24022931;
    slope = slope * part + 0.69314706;
    return bitcast<f32>(u32(i32(whole) + 127) << 23u) * (1.0 + part * slope);
}

// Twin of math/hash.rs.

fn pcg4d(v: vec4<u32>) -> vec4<u32> {
    var n = v * 1664525u + 1013904223u;
    n.x += n.y * n.w;
    n.y += n.z * n.x;
    n.z += n.x * n.y;
    n.w += n.y * n.z;
    n = n ^ (n >> vec4<u32>(16u));
    n.x += n.y * n.w;
    n.y += n.z * n.x;
    n.z += n.x * n.y;
    n.w += n.y * n.z;
    return n;
}

fn unit(bits: u32) -> f32 {
    return f32((bits >> 9u) * 2u + 1u) * (1.0 / 16777216.0);
}

// Twin of math/knots.rs.

// The place on a lattice of a projected half vector.
fn knot_place(point: vec2<f32>) -> vec2<f32> {
    return point * (paint.flakes.knots_per_unit / sqrt(1.0 + paint.flakes.knot_compression * dot(point, point)));
}

// Area of places over that of the projected half vectors they belong to.
fn knot_stretch(point: vec2<f32>) -> f32 {
    let side = paint.flakes.knots_per_unit / (1.0 + paint.flakes.knot_compression * dot(point, point));
    return side * side;
}

struct KnotLattice {
    // Cosine and sine of its turn.
    turn: vec2<f32>,
    offset: vec2<f32>,
    key: vec2<u32>,
}

fn knot_lattice(words: vec4<u32>) -> KnotLattice {
    let angle = (unit(words.z) - 0.5) * FRAC_PI_2;
    let key = vec2<u32>(words.w, words.x ^ ((words.y << 16u) | (words.y >> 16u)));
    return KnotLattice(turn(angle), vec2<f32>(unit(words.x), unit(words.y)), key);
}

fn knot_value(lattice: KnotLattice, place: vec2<f32>) -> f32 {
    let t = lattice.turn;
    let at = vec2<f32>(t.x * place.x - t.y * place.y, t.y * place.x + t.x * place.y) + lattice.offset;
    let corner = floor(at);
    let first = bitcast<vec2<u32>>(vec2<i32>(corner));
    let weights = knot_weights(at - corner);
    var sum = 0.0;
    for (var k = 0u; k < 4u; k++) {
        let knot = vec4<u32>(first.x + (k & 1u), first.y + (k >> 1u), lattice.key);
        sum += weights[k] * probit(unit(pcg4d(knot).x));
    }
    return sum;
}

fn knot_weights(place: vec2<f32>) -> vec4<f32> {
    let far = place;
    let near = 1.0 - place;
    let squares = near * near + far * far;
    let scale = 1.0 / sqrt(squares.x * squares.y);
    return vec4<f32>(near.x * near.y, far.x * near.y, near.x * far.y, far.x * far.y) * scale;
}

fn turn(angle: f32) -> vec2<f32> {
    let square = angle * angle;
    let cosine = 1.0 - square * (0.5 - square * (1.0 / 24.0 - square * (1.0 / 720.0 - square / 40320.0)));
    let sine = angle * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square / 5040.0)));
    return vec2<f32>(cosine, sine);
}

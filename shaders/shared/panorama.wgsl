// Twin of scene/panorama.rs.

struct Panorama {
    // Columns and rows; 0: there is none.
    size: vec2<u32>,
    // Where in the tables its texels begin: radiance, and the share up to there in the row's power; row-major, top row first.
    first_texel: u32,
    // Where its rows begin: the share up to there, and the height of the lower end.
    first_row: u32,
    // Cosine and sine of the angle by which it is turned about z.
    turn: vec2<f32>,
    is_bright: u32,
}

fn panorama_radiance(direction: vec3<f32>) -> vec3<f32> {
    let at = panorama_place(direction) - 0.5;
    let corner = floor(at);
    let weight = at - corner;
    let x = i32(corner.x);
    let y = i32(corner.y);
    let above = mix(panorama_texel(x, y), panorama_texel(x + 1, y), weight.x);
    let below = mix(panorama_texel(x, y + 1), panorama_texel(x + 1, y + 1), weight.x);
    return mix(above, below, weight.y);
}

// Columns go around, rows end.
fn panorama_texel(x: i32, y: i32) -> vec3<f32> {
    let size = vec2<i32>(scene.panorama.size);
    let column = (x + size.x) % size.x;
    let row = clamp(y, 0, size.y - 1);
    return bitcast<vec3<f32>>(tables[scene.panorama.first_texel + u32(row * size.x + column)].xyz);
}

fn panorama_sample(at: vec2<f32>) -> vec3<f32> {
    let size = scene.panorama.size;
    let row = inverted(scene.panorama.first_row, size.y, 0u, at.x);
    let first = scene.panorama.first_texel + row.part * size.x;
    let column = inverted(first, size.x, 3u, at.y);
    let upper = panorama_upper_end(row.part);
    let z = mix(upper, panorama_lower_end(row.part), row.inside);
    // Sine and cosine of the longitude, 0 in the middle.
    let around = circle((f32(column.part) + column.inside) / f32(size.x) - 0.5);
    let flat = around.yx * sqrt(max(1.0 - z * z, 0.0));
    let turn = scene.panorama.turn;
    return vec3<f32>(turn.x * flat.x - turn.y * flat.y, turn.y * flat.x + turn.x * flat.y, z);
}

// Of panorama_sample, 1/sr.
fn panorama_density(direction: vec3<f32>) -> f32 {
    let size = scene.panorama.size;
    let at = min(vec2<u32>(panorama_place(direction)), size - 1u);
    let first = scene.panorama.first_texel + at.y * size.x;
    let mass = part_share(scene.panorama.first_row, 0u, at.y) * part_share(first, 3u, at.x);
    let rise = panorama_upper_end(at.y) - panorama_lower_end(at.y);
    return mass * f32(size.x) * FRAC_1_TAU / rise;
}

fn panorama_upper_end(row: u32) -> f32 {
    if row == 0u {
        return 1.0;
    }
    return panorama_lower_end(row - 1u);
}

fn panorama_lower_end(row: u32) -> f32 {
    return bitcast<f32>(tables[scene.panorama.first_row + row].y);
}

// Where on the picture a direction is, in texels from its top left corner.
fn panorama_place(direction: vec3<f32>) -> vec2<f32> {
    let turn = scene.panorama.turn;
    let flat = vec2<f32>(
        turn.x * direction.x + turn.y * direction.y,
        turn.x * direction.y - turn.y * direction.x,
    );
    let longitude = full_angle(flat.x, flat.y);
    let colatitude = full_angle(length(flat), direction.z);
    return vec2<f32>(longitude * FRAC_1_TAU + 0.5, colatitude * FRAC_1_PI) * vec2<f32>(scene.panorama.size);
}

// The part of a distribution in which a number lies, and where in it, 0 to 1.
struct Inverted {
    part: u32,
    inside: f32,
}

// A distribution: `count` entries of the tables, of each of which one component is the share up to there.
fn inverted(first: u32, count: u32, component: u32, x: f32) -> Inverted {
    // The first part beyond x.
    var low = 0u;
    var high = count - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if upto(first, component, middle) <= x {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    var before = 0.0;
    if low > 0u {
        before = upto(first, component, low - 1u);
    }
    let inside = (x - before) / (upto(first, component, low) - before);
    return Inverted(low, clamp(inside, 0.0, 1.0));
}

fn upto(first: u32, component: u32, part: u32) -> f32 {
    return bitcast<f32>(tables[first + part][component]);
}

fn part_share(first: u32, component: u32, part: u32) -> f32 {
    if part == 0u {
        return upto(first, component, part);
    }
    return upto(first, component, part) - upto(first, component, part - 1u);
}

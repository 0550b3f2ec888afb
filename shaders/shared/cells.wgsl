// Twin of render/cells.rs; beyond 2^31 cells from the origin the two no longer saturate alike.

const JITTER: f32 = 0.9;
const DENSER: f32 = 1.0245;

fn cell_index(random: u32, coordinate: f32) -> u32 {
    let index = i32(coordinate);
    if !TEXTURED || random == 0u {
        return bitcast<u32>(index);
    }
    let side = i32(random);
    return bitcast<u32>((index % side + side) % side);
}

fn cell(surface: Surface, uv_mm: vec2<f32>, level: u32, cells_per_mm: f32) -> vec4<u32> {
    let place = uv_mm * cells_per_mm;
    let chart = (surface.chart << 8u) | level;
    var at = floor(place);
    if level == 0u {
        at = nearest_center(place * DENSER, chart, surface);
    }
    return cell_words(at, chart, surface, surface.seed);
}

// Of a level that is not the finest: without the search, which a software renderer would run through.
fn coarse_cell(surface: Surface, uv_mm: vec2<f32>, level: u32, cells_per_mm: f32) -> vec4<u32> {
    return cell_words(floor(uv_mm * cells_per_mm), (surface.chart << 8u) | level, surface, surface.seed);
}

fn nearest_center(place: vec2<f32>, chart: u32, surface: Surface) -> vec2<f32> {
    let home = floor(place);
    var nearest = home;
    var least = 1e38;
    for (var k = 0u; k < 9u; k++) {
        let candidate = home + vec2<f32>(f32(k % 3u) - 1.0, f32(k / 3u) - 1.0);
        let words = cell_words(candidate, chart, surface, ~surface.seed);
        let center = candidate + 0.5 + JITTER * (vec2<f32>(unit(words.x), unit(words.y)) - 0.5);
        let step = center - place;
        let distance = dot(step, step);
        if distance < least {
            least = distance;
            nearest = candidate;
        }
    }
    return nearest;
}

fn cell_words(at: vec2<f32>, chart: u32, surface: Surface, seed: u32) -> vec4<u32> {
    return pcg4d(vec4<u32>(cell_index(surface.random, at.x), cell_index(surface.random, at.y), chart, seed));
}

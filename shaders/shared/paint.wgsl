// A paint as it is drawn: twin of render/paint.rs, filled by gpu/paint.rs.

struct Lobe {
    coefficient: f32,
    roughness: f32,
    @size(8) f0: f32,
}

// One of the ways to choose a direction: by the half vectors of a lobe.
struct Technique {
    probability: f32,
    @size(12) roughness: f32,
}

struct Coat {
    // A coefficient of 0: no gloss lobe.
    gloss: Lobe,
    ior: f32,
    refracts: u32,
    mirror: f32,
}

struct FlakeLayout {
    // Cells of the lattice of each level, four levels a vector.
    cells_per_mm: array<vec4<f32>, 4>,
    // First slice of each row of the grid, and the end of the last row; four a vector.
    starts: array<vec4<u32>, 46>,
    bins: u32,
    rows: u32,
    missing_is_nearest: u32,
    texel_mm: f32,
    // 0: no flakes, or none that sparkle.
    levels: u32,
    slices_per_level: u32,
    // 0: u depends on the place alone.
    knots_per_unit: f32,
    knot_compression: f32,
    // Number of its first cluster, which the first ramp is of.
    first_cluster: u32,
}

struct Paint {
    lobes: array<Lobe, 4>,
    coat: Coat,
    flakes: FlakeLayout,
    colors_size: vec2<u32>,
    lobe_count: u32,
    diffuse: f32,
    techniques: array<Technique, 4>,
    // Probability of the cosine law.
    cosine: f32,
}

// One slice at one level.
struct Slice {
    gain: vec3<f32>,
    first_cluster: u32,
    offset: vec3<f32>,
    // See `guide_word`.
    guide: u32,
    // How much draws fluctuate, and how far they remember the half vector: twin of render/memory.rs.
    lasting: f32,
    fading: vec4<f32>,
}

struct Cluster {
    // Probability of this cluster or one before it.
    cumulative: f32,
    // See packed.wgsl.
    corners: array<u32, 3>,
}

@group(0) @binding(0) var<uniform> paint: Paint;
// The color table, then the mean of every slice.
@group(0) @binding(1) var<storage, read> colors: array<array<f32, 3>>;
// As they lie in memory: see `slice_at`.
@group(0) @binding(2) var<storage, read> slices: array<array<vec4<u32>, 4>>;
// As they lie in memory: see `cluster_of`.
@group(0) @binding(3) var<storage, read> clusters: array<vec4<u32>>;
// Guide tables, two parts a word, the lower half first.
@group(0) @binding(4) var<storage, read> guide: array<u32>;
// Of every cluster, or none at all.
@group(0) @binding(5) var<storage, read> ramps: array<u32>;

const FRAC_1_PI: f32 = 0.31830987;
const FRAC_1_TAU: f32 = 0.15915494;
const FRAC_2_PI: f32 = 0.63661975;
const FRAC_PI_2: f32 = 1.5707964;
const FRAC_PI_4: f32 = 0.7853982;
const LN_2: f32 = 0.6931472;
const LOG2_E: f32 = 1.442695;

// A software renderer looks up four words in the time of one.
fn slice_at(k: u32) -> Slice {
    let a = slices[k][0];
    let b = slices[k][1];
    let c = slices[k][2];
    let fading = bitcast<vec4<f32>>(slices[k][3]);
    let lasting = bitcast<f32>(c.x);
    return Slice(bitcast<vec3<f32>>(a.xyz), a.w, bitcast<vec3<f32>>(b.xyz), b.w, lasting, fading);
}

fn cluster_of(words: vec4<u32>) -> Cluster {
    return Cluster(bitcast<f32>(words.x), array<u32, 3>(words.y, words.z, words.w));
}

// Where a guide table begins, and in the lower five bits one more than the logarithm of its parts, a power of two. 0: no slice.
fn guide_word(first_part: u32, parts: u32) -> u32 {
    return select((first_part << 5u) | (firstLeadingBit(parts) + 1u), 0u, parts == 0u);
}

fn vector(components: array<f32, 3>) -> vec3<f32> {
    return vec3<f32>(components[0], components[1], components[2]);
}

// What host and shaders share. TWIN of src/local/inputs.rs (inputs) and src/local/gpu/layout.rs (batches and outputs):
// same fields in the same order, checked by a test.

struct Header {
    vx_count: u32,
    vtheta_count: u32,
    steps: u32,
    disc_count: u32,
    obstacle_count: u32,
    width: u32,
    height: u32,
    cell_bits: u32,
    start_x: i32,
    start_y: i32,
    heading: u32,
    target_x: i32,
    target_y: i32,
    key_x: i32,
    key_y: i32,
    max_clearance: u32,
    table_bits: u32,
    coarse_bits: u32,
    fine_bits: u32,
    stop_by_arc: u32,
    outside_is_free: u32,
    min_max: u32,
    stamp: u32,
    // Fills up to the 16-byte boundary that a vec4 needs.
    padding: u32,
    weights: vec4<u32>,
}

struct VxSample {
    coarse: i32,
    fine: i32,
    velocity_term: u32,
    stopping_need: u32,
}

struct VthetaSample {
    angle_per_step: u32,
    stopping_need: u32,
}

struct BodyDisc {
    x: i32,
    y: i32,
    radius: i32,
}

struct MovingBody {
    x: i32,
    y: i32,
    step_x: i32,
    step_y: i32,
    radius: i32,
}

struct Terms {
    heading: u32,
    clearance: u32,
    velocity: u32,
    path: u32,
}

struct Normalizer {
    offset: u32,
    mantissa: u32,
    bits: i32,
}

// Where a problem's parts begin in the buffers that all problems of a batch share.
struct BufferOffsets {
    // Workgroups of turns and of samples before its own; those of samples have a Partial each.
    first_groups: vec2<u32>,
    // Elements before its own; of bodies, field and table, words.
    first_vx: u32,
    first_vtheta: u32,
    first_body: u32,
    first_field: u32,
    first_table: u32,
    first_record: u32,
}

struct BatchEntry {
    header: Header,
    offsets: BufferOffsets,
}

// The problems of one submission; each has the answer of its own index.
struct Batch {
    count: u32,
    problems: array<BatchEntry, MAX_PROBLEMS>,
}

// A sample, judged: terms and reason. The velocity term is its speed's.
struct Record {
    heading: u32,
    clearance: u32,
    path: u32,
    status: u32,
}

// What one workgroup of samples adds up to, then its best sample.
struct Partial {
    sums: vec4<u32>,
    min: vec4<u32>,
    max: vec4<u32>,
    // Admissible, collision and cannot-stop samples in ten bits each.
    counts: u32,
    // The best sample's score, lower and upper half, and index.
    best: array<u32, 3>,
}

struct Answer {
    // Admissible, collision, cannot stop, outside.
    counts: vec4<u32>,
    sums_low: vec4<u32>,
    sums_high: vec4<u32>,
    min: vec4<u32>,
    max: vec4<u32>,
    normalizers: array<Normalizer, 4>,
    // The winner's index, its score's halves, the stamp of the problem answered, the winner's terms.
    winner: u32,
    score_low: u32,
    score_high: u32,
    stamp: u32,
    terms: Terms,
}

const OK: u32 = 0u;
const COLLISION: u32 = 1u;
const CANNOT_STOP: u32 = 2u;
const OUTSIDE: u32 = 3u;

// Words of a disc and of a moving obstacle among the bodies; the discs come first.
const DISC_WORDS: u32 = 3u;
const OBSTACLE_WORDS: u32 = 5u;

// Problems of a batch: all of them fit into the uniform buffer that every adapter binds, 64 KiB.
const MAX_PROBLEMS: u32 = 256u;

// Batch, speeds, turns and bodies are views of one buffer, one behind the other.
@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<storage, read> vx_samples: array<VxSample>;
@group(0) @binding(2) var<storage, read> vtheta_samples: array<VthetaSample>;
@group(0) @binding(3) var<storage, read> bodies: array<i32>;
@group(0) @binding(4) var<storage, read> field: array<u32>;
@group(0) @binding(5) var<storage, read_write> table: array<i32>;
@group(0) @binding(6) var<storage, read_write> records: array<Record>;
@group(0) @binding(7) var<storage, read_write> partials: array<Partial>;
@group(0) @binding(8) var<storage, read_write> answers: array<Answer>;

// The problem that this invocation serves.
var<private> header: Header;
var<private> offsets: BufferOffsets;

fn load_problem(problem: u32) {
    header = batch.problems[problem].header;
    offsets = batch.problems[problem].offsets;
}

fn disc(index: u32) -> BodyDisc {
    let at = offsets.first_body + index * DISC_WORDS;
    return BodyDisc(bodies[at], bodies[at + 1u], bodies[at + 2u]);
}

fn disc_radius(index: u32) -> i32 {
    return bodies[offsets.first_body + index * DISC_WORDS + 2u];
}

fn obstacle(index: u32) -> MovingBody {
    let at = offsets.first_body + header.disc_count * DISC_WORDS + index * OBSTACLE_WORDS;
    return MovingBody(bodies[at], bodies[at + 1u], bodies[at + 2u], bodies[at + 3u], bodies[at + 4u]);
}

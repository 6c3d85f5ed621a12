// Data shared by host and shaders. TWIN of src/local/kernel_inputs.rs (inputs) and src/local/gpu/layout.rs (batches and
// outputs): same fields in the same order, checked by a test.

struct Header {
    vx_count: u32,
    profile_count: u32,
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
    segment_count: u32,
    weights: vec4<u32>,
}

struct VxSample {
    coarse: i32,
    fine: i32,
    velocity_term: u32,
    stopping_need: u32,
}

struct TurnProfile {
    coarse: i32,
    fine: i32,
    stopping_need: u32,
    max_turn: u32,
    end_turn: u32,
}

struct ProfileSegment {
    end: u32,
    turn: u32,
    turn_growth: u32,
    share: i32,
    share_growth: i32,
}

struct QuantizedDisc {
    x: i32,
    y: i32,
    radius: i32,
}

struct QuantizedObstacle {
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

// Offsets of a problem's parts in the buffers of the batch.
struct BufferOffsets {
    // Workgroups of turn profiles and of samples before its own. A workgroup of samples has one Partial.
    first_groups: vec2<u32>,
    // Elements before its own; for lists, field and table, words.
    first_vx: u32,
    first_profile: u32,
    first_list: u32,
    first_field: u32,
    first_table: u32,
    first_record: u32,
}

struct BatchEntry {
    header: Header,
    offsets: BufferOffsets,
}

// The problems of one submission. The answer to a problem has the same index.
struct Batch {
    count: u32,
    // Number of times that a workgroup of turn profiles takes rows.
    tabulation_rounds: u32,
    problems: array<BatchEntry, MAX_PROBLEMS>,
}

// Terms and status of a sample. The velocity term is that of its forward speed.
struct Record {
    heading: u32,
    clearance: u32,
    path: u32,
    status: u32,
}

// Totals and best sample of one workgroup.
struct Partial {
    sums: vec4<u32>,
    min: vec4<u32>,
    max: vec4<u32>,
    // Admissible, collision and cannot-stop samples in ten bits each.
    counts: u32,
    // Score (lower and upper half) and index of the best sample.
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
    // Index of the winner, halves of its score, stamp of the problem, terms of the winner.
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

// Words of a disc, of a moving obstacle and of a segment in `lists`, in this order.
const DISC_WORDS: u32 = 3u;
const OBSTACLE_WORDS: u32 = 5u;
const SEGMENT_WORDS: u32 = 5u;

// A pipeline can be specialised for a batch whose problems all have one disc, or no moving obstacle.
override ONE_DISC: bool = false;
override MOVING_OBSTACLES: bool = true;

// Largest number of problems of a batch: they fit into the uniform buffer of 64 KiB that every adapter supports.
const MAX_PROBLEMS: u32 = 256u;

// Batch, vx_samples, profiles and lists are views of one buffer, at successive offsets.
@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<storage, read> vx_samples: array<VxSample>;
@group(0) @binding(2) var<storage, read> profiles: array<TurnProfile>;
@group(0) @binding(3) var<storage, read> lists: array<i32>;
@group(0) @binding(4) var<storage, read> field: array<u32>;
@group(0) @binding(5) var<storage, read_write> table: array<vec2<i32>>;
@group(0) @binding(6) var<storage, read_write> records: array<Record>;
@group(0) @binding(7) var<storage, read_write> partials: array<Partial>;
@group(0) @binding(8) var<storage, read_write> answers: array<Answer>;

// The problem of this invocation.
var<private> header: Header;
var<private> offsets: BufferOffsets;

fn load_problem(problem: u32) {
    header = batch.problems[problem].header;
    offsets = batch.problems[problem].offsets;
}

fn disc_count() -> u32 {
    return select(header.disc_count, 1u, ONE_DISC);
}

fn obstacle_count() -> u32 {
    return select(0u, header.obstacle_count, MOVING_OBSTACLES);
}

fn disc(index: u32) -> QuantizedDisc {
    let at = offsets.first_list + index * DISC_WORDS;
    return QuantizedDisc(lists[at], lists[at + 1u], lists[at + 2u]);
}

fn disc_radius(index: u32) -> i32 {
    return lists[offsets.first_list + index * DISC_WORDS + 2u];
}

fn obstacle(index: u32) -> QuantizedObstacle {
    let at = offsets.first_list + header.disc_count * DISC_WORDS + index * OBSTACLE_WORDS;
    return QuantizedObstacle(lists[at], lists[at + 1u], lists[at + 2u], lists[at + 3u], lists[at + 4u]);
}

fn profile_segment(index: u32) -> ProfileSegment {
    let before = header.disc_count * DISC_WORDS + header.obstacle_count * OBSTACLE_WORDS;
    let at = offsets.first_list + before + index * SEGMENT_WORDS;
    return ProfileSegment(
        bitcast<u32>(lists[at]),
        bitcast<u32>(lists[at + 1u]),
        bitcast<u32>(lists[at + 2u]),
        lists[at + 3u],
        lists[at + 4u],
    );
}

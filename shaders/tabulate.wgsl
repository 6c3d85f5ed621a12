// Fills the tables of the turn profiles, one invocation per step. The same table as `tabulate` of src/local/rollout.rs, which
// adds the steps one after the other: sums of integers do not depend on the order.

// Number of steps that one workgroup tabulates together.
const STEPS_PER_GROUP: u32 = 64u;

// Heading before and after a step, and the share of the sample's speed.
struct ProfileStep {
    before: u32,
    after: u32,
    share: i32,
}

// Change of the heading over the first steps of a segment.
fn turned(segment: ProfileSegment, steps: u32) -> u32 {
    return segment.turn * steps + segment.turn_growth * ((steps * (steps - 1u)) >> 1u);
}

fn profile_step(row: u32, step: u32) -> ProfileStep {
    var index = row * header.segment_count;
    var segment = profile_segment(index);
    var first = 0u;
    var heading = header.heading;
    while segment.end <= step {
        heading += turned(segment, segment.end - first);
        first = segment.end;
        index += 1u;
        segment = profile_segment(index);
    }
    let done = step - first;
    return ProfileStep(
        heading + turned(segment, done),
        heading + turned(segment, done + 1u),
        segment.share + bitcast<i32>(done) * segment.share_growth,
    );
}

// Cosine and sine of the headings before a step, times the share of the sample's speed and times the rest.
fn displacement_shares(motion: ProfileStep) -> vec4<i32> {
    let direction = vec2<i32>(cos_q20(motion.before), sin_q20(motion.before));
    let own = vec2<i32>(mul_hi_i32(motion.share, direction.x << 2u), mul_hi_i32(motion.share, direction.y << 2u));
    return vec4<i32>(own, direction - own);
}

// Writes the entries of a step from its sums: of the sample's own speed, and of the rest.
fn tabulate_step(first: u32, step: u32, profile: TurnProfile, heading: u32, sums: vec4<i32>) {
    var at = first + step * (step_words() / 2u);
    table[at] = vec2<i32>(shift_round(sums.x, header.table_bits), shift_round(sums.y, header.table_bits));
    let base = vec2<i32>(
        header.start_x + displacement(profile.coarse, sums.z),
        header.start_y + displacement(profile.coarse, sums.w),
    );
    let cosine = shift_round(cos_q20(heading), 6u);
    let sine = shift_round(sin_q20(heading), 6u);
    for (var index = 0u; index < disc_count(); index += 1u) {
        let footprint_disc = disc(index);
        at += 1u;
        table[at] = base + vec2<i32>(
            shift_round(footprint_disc.x * cosine - footprint_disc.y * sine, 14u),
            shift_round(footprint_disc.x * sine + footprint_disc.y * cosine, 14u),
        );
    }
    if step + 1u == header.steps {
        table[at + 1u] = sums.xy;
        table[at + 2u] = vec2<i32>(
            shift_round(mul_hi_i32(profile.fine, sums.z), header.fine_bits),
            shift_round(mul_hi_i32(profile.fine, sums.w), header.fine_bits),
        );
    }
}

var<workgroup> step_sums: array<vec4<i32>, 2u * STEPS_PER_GROUP>;

// Sums of the values of the invocations of a row up to this one. Each round reads one half of the memory and writes the other.
fn sums_up_to(local: u32, lanes: u32, own: vec4<i32>) -> vec4<i32> {
    var sums = own;
    var read_from = 0u;
    step_sums[local] = sums;
    for (var distance = 1u; distance < lanes; distance *= 2u) {
        workgroupBarrier();
        if local % lanes >= distance {
            sums += step_sums[read_from + local - distance];
        }
        read_from = STEPS_PER_GROUP - read_from;
        step_sums[read_from + local] = sums;
    }
    return sums;
}

// Invocations of a row: the next power of two of the number of steps, at most a workgroup.
fn lanes_of(steps: u32) -> u32 {
    return 1u << min(32u - countLeadingZeros(steps - 1u), 6u);
}

@compute @workgroup_size(STEPS_PER_GROUP)
fn tabulate_profiles(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3<u32>) {
    let problem = problem_of(group.x, OF_PROFILES);
    load_problem(problem);
    // The bounds of loops with barriers come from uniform memory, so that all invocations of a workgroup agree.
    let steps = batch.problems[problem].header.steps;
    let lanes = lanes_of(steps);
    let rows_at_once = STEPS_PER_GROUP / lanes;
    let rounds = batch.tabulation_rounds;
    let first_row = (group.x - batch.problems[problem].offsets.first_groups[OF_PROFILES]) * rounds * rows_at_once;
    for (var round = 0u; round < rounds; round += 1u) {
        let row = first_row + round * rows_at_once + local / lanes;
        var before = vec4<i32>(0);
        for (var first_step = 0u; first_step < steps; first_step += lanes) {
            let step = first_step + local % lanes;
            let has_step = row < header.profile_count && step < steps;
            var motion = ProfileStep();
            var own = vec4<i32>(0);
            if has_step {
                motion = profile_step(row, step);
                own = displacement_shares(motion);
            }
            let sums = before + sums_up_to(local, lanes, own);
            if has_step {
                tabulate_step(table_start(row), step, profiles[offsets.first_profile + row], motion.after, sums);
            }
            // Only rows of a whole workgroup have more steps: the number of rounds is even, the result in the first half.
            if first_step + lanes < steps {
                workgroupBarrier();
                before += step_sums[STEPS_PER_GROUP - 1u];
                workgroupBarrier();
            }
        }
        workgroupBarrier();
    }
}

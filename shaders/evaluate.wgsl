// The five dispatches of a batch of decisions, in order. The arithmetic is in the twins.
//
//   tabulate_profiles    one thread per turn profile    fills the displacement table
//   evaluate_samples   one thread per sample          evaluates it, adds up the workgroup
//   normalize          one workgroup per problem      totals and normalisers
//   score_samples      one thread per sample          scores it, selects the workgroup's best
//   select_winner      one workgroup per problem      the winner
//
// A workgroup serves one problem; the workgroups of a problem are consecutive.

const PROFILES_PER_GROUP: u32 = 96u;
const SAMPLES_PER_GROUP: u32 = 256u;
const REDUCERS: u32 = 64u;
// Number of entries that one thread reduces to one, to save barriers. The workgroup sizes are powers of it.
const FOLD: u32 = 4u;

// Index in `first_groups` of the workgroups of a dispatch.
const OF_PROFILES: u32 = 0u;
const OF_SAMPLES: u32 = 1u;

// The problem of a workgroup: the last one that begins at or before it.
fn problem_of(group: u32, which: u32) -> u32 {
    var problem = 0u;
    var beyond = batch.count;
    while beyond - problem > 1u {
        let middle = (problem + beyond) / 2u;
        if batch.problems[middle].offsets.first_groups[which] <= group {
            problem = middle;
        } else {
            beyond = middle;
        }
    }
    return problem;
}

fn sample_count() -> u32 {
    return header.vx_count * header.profile_count;
}

fn group_count() -> u32 {
    return (sample_count() + SAMPLES_PER_GROUP - 1u) / SAMPLES_PER_GROUP;
}

// Start of a row's table.
fn table_start(index: u32) -> u32 {
    return offsets.first_table + index * table_words();
}

@compute @workgroup_size(PROFILES_PER_GROUP)
fn tabulate_profiles(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3<u32>) {
    load_problem(problem_of(group.x, OF_PROFILES));
    let index = (group.x - offsets.first_groups[OF_PROFILES]) * PROFILES_PER_GROUP + local;
    if index < header.profile_count {
        tabulate(index, table_start(index));
    }
}

// Terms are below 2^24, so the sum over 256 threads fits in 32 bits.
var<workgroup> group_sums: array<vec4<u32>, SAMPLES_PER_GROUP>;
var<workgroup> group_min: array<vec4<u32>, SAMPLES_PER_GROUP>;
var<workgroup> group_max: array<vec4<u32>, SAMPLES_PER_GROUP>;
var<workgroup> group_counts: array<u32, SAMPLES_PER_GROUP>;

@compute @workgroup_size(SAMPLES_PER_GROUP)
fn evaluate_samples(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    load_problem(problem_of(group.x, OF_SAMPLES));
    let index = (group.x - offsets.first_groups[OF_SAMPLES]) * SAMPLES_PER_GROUP + local;
    var sums = vec4<u32>(0u);
    var minimum = vec4<u32>(0xffffffffu);
    var maximum = vec4<u32>(0u);
    var counts = 0u;
    if index < sample_count() {
        let vx = vx_samples[offsets.first_vx + index % header.vx_count];
        let row = index / header.vx_count;
        let profile = profiles[offsets.first_profile + row];
        let first = table_start(row);
        let outcome = evaluate_sample(vx, profile, first);
        var record = Record(0u, 0u, 0u, outcome.status);
        if outcome.status == OK {
            let found = terms(vx, end_heading(profile), end_position(vx, first), outcome.clearance);
            record = Record(found.heading, found.clearance, found.path, OK);
            sums = vec4<u32>(found.heading, found.clearance, found.velocity, found.path);
            minimum = sums;
            maximum = sums;
        }
        records[offsets.first_record + index] = record;
        // Ten bits for each of the first three statuses; the remaining samples are outside.
        counts = select(1u << (10u * outcome.status), 0u, outcome.status == OUTSIDE);
    }
    group_sums[local] = sums;
    group_min[local] = minimum;
    group_max[local] = maximum;
    group_counts[local] = counts;
    for (var left = SAMPLES_PER_GROUP / FOLD; left > 0u; left /= FOLD) {
        workgroupBarrier();
        if local < left {
            for (var other = local + left; other < FOLD * left; other += left) {
                sums += group_sums[other];
                minimum = min(minimum, group_min[other]);
                maximum = max(maximum, group_max[other]);
                counts += group_counts[other];
            }
            group_sums[local] = sums;
            group_min[local] = minimum;
            group_max[local] = maximum;
            group_counts[local] = counts;
        }
    }
    if local == 0u {
        partials[group.x].sums = group_sums[0];
        partials[group.x].min = group_min[0];
        partials[group.x].max = group_max[0];
        partials[group.x].counts = group_counts[0];
    }
}

var<workgroup> total_low: array<vec4<u32>, REDUCERS>;
var<workgroup> total_high: array<vec4<u32>, REDUCERS>;
var<workgroup> total_min: array<vec4<u32>, REDUCERS>;
var<workgroup> total_max: array<vec4<u32>, REDUCERS>;
var<workgroup> total_counts: array<vec4<u32>, REDUCERS>;

@compute @workgroup_size(REDUCERS)
fn normalize(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) problem: vec3<u32>) {
    load_problem(problem.x);
    var low = vec4<u32>(0u);
    var high = vec4<u32>(0u);
    var minimum = vec4<u32>(0xffffffffu);
    var maximum = vec4<u32>(0u);
    var counts = vec4<u32>(0u);
    for (var group = local; group < group_count(); group += REDUCERS) {
        let at = offsets.first_groups[OF_SAMPLES] + group;
        let sums = partials[at].sums;
        low += sums;
        high += select(vec4<u32>(0u), vec4<u32>(1u), low < sums);
        minimum = min(minimum, partials[at].min);
        maximum = max(maximum, partials[at].max);
        let packed = partials[at].counts;
        counts += vec4<u32>(packed & 1023u, (packed >> 10u) & 1023u, (packed >> 20u) & 1023u, 0u);
    }
    total_low[local] = low;
    total_high[local] = high;
    total_min[local] = minimum;
    total_max[local] = maximum;
    total_counts[local] = counts;
    for (var left = REDUCERS / FOLD; left > 0u; left /= FOLD) {
        workgroupBarrier();
        if local < left {
            for (var other = local + left; other < FOLD * left; other += left) {
                low += total_low[other];
                let carries = low < total_low[other];
                high += total_high[other] + select(vec4<u32>(0u), vec4<u32>(1u), carries);
                minimum = min(minimum, total_min[other]);
                maximum = max(maximum, total_max[other]);
                counts += total_counts[other];
            }
            total_low[local] = low;
            total_high[local] = high;
            total_min[local] = minimum;
            total_max[local] = maximum;
            total_counts[local] = counts;
        }
    }
    if local == 0u {
        let found = total_counts[0];
        let weights = header.weights;
        let answer = &answers[problem.x];
        (*answer).counts = vec4<u32>(found.xyz, sample_count() - found.x - found.y - found.z);
        (*answer).sums_low = total_low[0];
        (*answer).sums_high = total_high[0];
        (*answer).min = total_min[0];
        (*answer).max = total_max[0];
        for (var term = 0u; term < 4u; term += 1u) {
            let sum = vec2<u32>(total_low[0][term], total_high[0][term]);
            (*answer).normalizers[term] =
                term_normalizer(weights[term], sum, total_min[0][term], total_max[0][term]);
        }
    }
}

var<workgroup> group_best: array<Candidate, SAMPLES_PER_GROUP>;

fn record_terms(index: u32) -> Terms {
    let record = records[offsets.first_record + index];
    let vx = vx_samples[offsets.first_vx + index % header.vx_count];
    return Terms(record.heading, record.clearance, vx.velocity_term, record.path);
}

@compute @workgroup_size(SAMPLES_PER_GROUP)
fn score_samples(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let problem = problem_of(group.x, OF_SAMPLES);
    load_problem(problem);
    let index = (group.x - offsets.first_groups[OF_SAMPLES]) * SAMPLES_PER_GROUP + local;
    var candidate = no_candidate();
    if index < sample_count() && records[offsets.first_record + index].status == OK {
        let by = answers[problem].normalizers;
        candidate = Candidate(score(record_terms(index), by[0], by[1], by[2], by[3]), index);
    }
    group_best[local] = candidate;
    for (var left = SAMPLES_PER_GROUP / FOLD; left > 0u; left /= FOLD) {
        workgroupBarrier();
        if local < left {
            for (var other = local + left; other < FOLD * left; other += left) {
                candidate = better(candidate, group_best[other]);
            }
            group_best[local] = candidate;
        }
    }
    if local == 0u {
        let best = group_best[0];
        partials[group.x].best = array<u32, 3>(best.score.x, best.score.y, best.index);
    }
}

var<workgroup> finalists: array<Candidate, REDUCERS>;

@compute @workgroup_size(REDUCERS)
fn select_winner(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) problem: vec3<u32>) {
    load_problem(problem.x);
    var finalist = no_candidate();
    for (var group = local; group < group_count(); group += REDUCERS) {
        let best = partials[offsets.first_groups[OF_SAMPLES] + group].best;
        finalist = better(finalist, Candidate(vec2<u32>(best[0], best[1]), best[2]));
    }
    finalists[local] = finalist;
    for (var left = REDUCERS / FOLD; left > 0u; left /= FOLD) {
        workgroupBarrier();
        if local < left {
            for (var other = local + left; other < FOLD * left; other += left) {
                finalist = better(finalist, finalists[other]);
            }
            finalists[local] = finalist;
        }
    }
    if local == 0u {
        let best = finalists[0];
        let answer = &answers[problem.x];
        (*answer).winner = best.index;
        (*answer).score_low = best.score.x;
        (*answer).score_high = best.score.y;
        (*answer).stamp = header.stamp;
        (*answer).terms = Terms(0u, 0u, 0u, 0u);
        if best.index < sample_count() {
            (*answer).terms = record_terms(best.index);
        }
    }
}

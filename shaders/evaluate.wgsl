// The five dispatches of a batch of decisions, in order. No mathematics here: that is in the twins.
//
//   tabulate_turns   a thread for each turn rate        fills the displacement table
//   judge_samples    a thread for each sample           judges it, adds up its workgroup
//   normalize        a workgroup for each problem       totals, and what normalises the terms
//   score_samples    a thread for each sample           scores it, finds its workgroup's best
//   choose           a workgroup for each problem       the winner
//
// A workgroup serves one problem: those of a problem follow one another.

const TURNS_PER_GROUP: u32 = 128u;
const SAMPLES_PER_GROUP: u32 = 256u;
const REDUCERS: u32 = 64u;
// So many entries become one at a time where a workgroup adds up, so that few barriers do; the sizes of those that do
// are powers of it.
const FOLD: u32 = 4u;

// Which of `first_groups` counts the workgroups of a dispatch.
const OF_TURNS: u32 = 0u;
const OF_SAMPLES: u32 = 1u;

// The problem that a workgroup serves: the last that does not begin behind it.
fn problem_of(group: u32, which: u32) -> u32 {
    var problem = 0u;
    var beyond = batch.count;
    while beyond - problem > 1u {
        let middle = (problem + beyond) / 2u;
        if batch.problems[middle].place.first_groups[which] <= group {
            problem = middle;
        } else {
            beyond = middle;
        }
    }
    return problem;
}

fn sample_count() -> u32 {
    return header.v_count * header.omega_count;
}

fn group_count() -> u32 {
    return (sample_count() + SAMPLES_PER_GROUP - 1u) / SAMPLES_PER_GROUP;
}

// Where a turn rate's table begins.
fn first_of_turn(index: u32) -> u32 {
    return place.first_table + index * table_words();
}

@compute @workgroup_size(TURNS_PER_GROUP)
fn tabulate_turns(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3<u32>) {
    take_up(problem_of(group.x, OF_TURNS));
    let index = (group.x - place.first_groups[OF_TURNS]) * TURNS_PER_GROUP + local;
    if index < header.omega_count {
        tabulate(turns[place.first_turn + index], first_of_turn(index));
    }
}

// Terms are below 2^24, so the sum of a workgroup's 256 fits in 32 bits.
var<workgroup> group_sums: array<vec4<u32>, SAMPLES_PER_GROUP>;
var<workgroup> group_least: array<vec4<u32>, SAMPLES_PER_GROUP>;
var<workgroup> group_greatest: array<vec4<u32>, SAMPLES_PER_GROUP>;
var<workgroup> group_counts: array<u32, SAMPLES_PER_GROUP>;

@compute @workgroup_size(SAMPLES_PER_GROUP)
fn judge_samples(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    take_up(problem_of(group.x, OF_SAMPLES));
    let index = (group.x - place.first_groups[OF_SAMPLES]) * SAMPLES_PER_GROUP + local;
    var sums = vec4<u32>(0u);
    var least = vec4<u32>(0xffffffffu);
    var greatest = vec4<u32>(0u);
    var counts = 0u;
    if index < sample_count() {
        let speed = speeds[place.first_speed + index % header.v_count];
        let turn_index = index / header.v_count;
        let turn = turns[place.first_turn + turn_index];
        let first = first_of_turn(turn_index);
        let judged = judge(speed, turn, first);
        var record = Record(0u, 0u, 0u, judged.reason);
        if judged.reason == OK {
            let found = terms(speed, end_heading(turn), end_position(speed, first), judged.clearance);
            record = Record(found.heading, found.clearance, found.path, OK);
            sums = vec4<u32>(found.heading, found.clearance, found.velocity, found.path);
            least = sums;
            greatest = sums;
        }
        records[place.first_record + index] = record;
        // Ten bits for each of the first three reasons; what remains is outside.
        counts = select(1u << (10u * judged.reason), 0u, judged.reason == OUTSIDE);
    }
    group_sums[local] = sums;
    group_least[local] = least;
    group_greatest[local] = greatest;
    group_counts[local] = counts;
    for (var left = SAMPLES_PER_GROUP / FOLD; left > 0u; left /= FOLD) {
        workgroupBarrier();
        if local < left {
            for (var other = local + left; other < FOLD * left; other += left) {
                sums += group_sums[other];
                least = min(least, group_least[other]);
                greatest = max(greatest, group_greatest[other]);
                counts += group_counts[other];
            }
            group_sums[local] = sums;
            group_least[local] = least;
            group_greatest[local] = greatest;
            group_counts[local] = counts;
        }
    }
    if local == 0u {
        partials[group.x].sums = group_sums[0];
        partials[group.x].least = group_least[0];
        partials[group.x].greatest = group_greatest[0];
        partials[group.x].counts = group_counts[0];
    }
}

var<workgroup> total_low: array<vec4<u32>, REDUCERS>;
var<workgroup> total_high: array<vec4<u32>, REDUCERS>;
var<workgroup> total_least: array<vec4<u32>, REDUCERS>;
var<workgroup> total_greatest: array<vec4<u32>, REDUCERS>;
var<workgroup> total_counts: array<vec4<u32>, REDUCERS>;

@compute @workgroup_size(REDUCERS)
fn normalize(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) problem: vec3<u32>) {
    take_up(problem.x);
    var low = vec4<u32>(0u);
    var high = vec4<u32>(0u);
    var least = vec4<u32>(0xffffffffu);
    var greatest = vec4<u32>(0u);
    var counts = vec4<u32>(0u);
    for (var group = local; group < group_count(); group += REDUCERS) {
        let at = place.first_groups[OF_SAMPLES] + group;
        let sums = partials[at].sums;
        low += sums;
        high += select(vec4<u32>(0u), vec4<u32>(1u), low < sums);
        least = min(least, partials[at].least);
        greatest = max(greatest, partials[at].greatest);
        let packed = partials[at].counts;
        counts += vec4<u32>(packed & 1023u, (packed >> 10u) & 1023u, (packed >> 20u) & 1023u, 0u);
    }
    total_low[local] = low;
    total_high[local] = high;
    total_least[local] = least;
    total_greatest[local] = greatest;
    total_counts[local] = counts;
    for (var left = REDUCERS / FOLD; left > 0u; left /= FOLD) {
        workgroupBarrier();
        if local < left {
            for (var other = local + left; other < FOLD * left; other += left) {
                low += total_low[other];
                let carries = low < total_low[other];
                high += total_high[other] + select(vec4<u32>(0u), vec4<u32>(1u), carries);
                least = min(least, total_least[other]);
                greatest = max(greatest, total_greatest[other]);
                counts += total_counts[other];
            }
            total_low[local] = low;
            total_high[local] = high;
            total_least[local] = least;
            total_greatest[local] = greatest;
            total_counts[local] = counts;
        }
    }
    if local == 0u {
        let judged = total_counts[0];
        let weights = header.weights;
        let answer = &answers[problem.x];
        (*answer).counts = vec4<u32>(judged.xyz, sample_count() - judged.x - judged.y - judged.z);
        (*answer).sums_low = total_low[0];
        (*answer).sums_high = total_high[0];
        (*answer).least = total_least[0];
        (*answer).greatest = total_greatest[0];
        for (var term = 0u; term < 4u; term += 1u) {
            let sum = vec2<u32>(total_low[0][term], total_high[0][term]);
            (*answer).normalizers[term] =
                term_normalizer(weights[term], sum, total_least[0][term], total_greatest[0][term]);
        }
    }
}

var<workgroup> group_best: array<Candidate, SAMPLES_PER_GROUP>;

fn record_terms(index: u32) -> Terms {
    let record = records[place.first_record + index];
    let speed = speeds[place.first_speed + index % header.v_count];
    return Terms(record.heading, record.clearance, speed.term, record.path);
}

@compute @workgroup_size(SAMPLES_PER_GROUP)
fn score_samples(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let problem = problem_of(group.x, OF_SAMPLES);
    take_up(problem);
    let index = (group.x - place.first_groups[OF_SAMPLES]) * SAMPLES_PER_GROUP + local;
    var candidate = nobody();
    if index < sample_count() && records[place.first_record + index].reason == OK {
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
fn choose(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) problem: vec3<u32>) {
    take_up(problem.x);
    var finalist = nobody();
    for (var group = local; group < group_count(); group += REDUCERS) {
        let best = partials[place.first_groups[OF_SAMPLES] + group].best;
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

// Finds the winner from the records and totals of `evaluate_samples`. The arithmetic is in the twins.
//
// A problem with few samples takes one dispatch, `decide`, of one workgroup. One with many takes three:
//
//   normalize        one workgroup per problem    totals and normalisers
//   score_samples    one invocation per sample    scores it, selects the workgroup's best
//   select_winner    one workgroup per problem    the winner

const REDUCERS: u32 = 256u;
const REDUCER_HALF: u32 = REDUCERS / 2u;

// Totals of a problem, in 64 bits each.
struct ProblemTotals {
    low: vec4<u32>,
    high: vec4<u32>,
    min: vec4<u32>,
    max: vec4<u32>,
    // Admissible, collision and cannot-stop samples.
    counts: vec4<u32>,
}

var<workgroup> total_low: array<vec4<u32>, REDUCER_HALF>;
var<workgroup> total_high: array<vec4<u32>, REDUCER_HALF>;
var<workgroup> total_min: array<vec4<u32>, REDUCER_HALF>;
var<workgroup> total_max: array<vec4<u32>, REDUCER_HALF>;
var<workgroup> total_counts: array<vec4<u32>, REDUCER_HALF>;

fn store_totals(at: u32, totals: ProblemTotals) {
    total_low[at] = totals.low;
    total_high[at] = totals.high;
    total_min[at] = totals.min;
    total_max[at] = totals.max;
    total_counts[at] = totals.counts;
}

fn add_carrying(totals: ptr<function, ProblemTotals>, low: vec4<u32>, high: vec4<u32>) {
    let sum = (*totals).low + low;
    (*totals).high += high + select(vec4<u32>(0u), vec4<u32>(1u), sum < low);
    (*totals).low = sum;
}

fn add_stored(totals: ptr<function, ProblemTotals>, at: u32) {
    add_carrying(totals, total_low[at], total_high[at]);
    (*totals).min = min((*totals).min, total_min[at]);
    (*totals).max = max((*totals).max, total_max[at]);
    (*totals).counts += total_counts[at];
}

fn add_partial(totals: ptr<function, ProblemTotals>, group: u32) {
    let at = offsets.first_groups[OF_SAMPLES] + group;
    add_carrying(totals, partials[at].sums, vec4<u32>(0u));
    (*totals).min = min((*totals).min, partials[at].min);
    (*totals).max = max((*totals).max, partials[at].max);
    let packed = partials[at].counts;
    (*totals).counts += vec4<u32>(packed & 1023u, (packed >> 10u) & 1023u, (packed >> 20u) & 1023u, 0u);
}

var<workgroup> normalizers: array<Normalizer, 4>;

// Writes the totals of a problem to its answer, and its normalisers to the workgroup's memory.
fn total_and_normalize(local: u32, problem: u32) {
    var totals = ProblemTotals();
    totals.min = vec4<u32>(0xffffffffu);
    for (var group = local; group < group_count(); group += REDUCERS) {
        add_partial(&totals, group);
    }
    if local >= REDUCER_HALF {
        store_totals(local - REDUCER_HALF, totals);
    }
    workgroupBarrier();
    if local < REDUCER_HALF {
        add_stored(&totals, local);
    }
    // An invocation writes only where it alone has read.
    var left = REDUCER_HALF;
    for (var next = REDUCER_HALF / FOLD; left > 1u; next = max(next / FOLD, 1u)) {
        if local >= next && local < left {
            store_totals(local, totals);
        }
        workgroupBarrier();
        if local < next {
            for (var other = local + next; other < left; other += next) {
                add_stored(&totals, other);
            }
        }
        left = next;
    }
    if local == 0u {
        store_totals(0u, totals);
        let answer = &answers[problem];
        let counts = totals.counts;
        (*answer).counts = vec4<u32>(counts.xyz, sample_count() - counts.x - counts.y - counts.z);
        (*answer).sums_low = totals.low;
        (*answer).sums_high = totals.high;
        (*answer).min = totals.min;
        (*answer).max = totals.max;
    }
    workgroupBarrier();
    if local < 4u {
        let sum = vec2<u32>(total_low[0][local], total_high[0][local]);
        // Some compilers move the whole header to slow memory for an index that is not constant.
        let weight = batch.problems[problem].header.weights[local];
        let by = term_normalizer(weight, sum, total_min[0][local], total_max[0][local]);
        normalizers[local] = by;
        answers[problem].normalizers[local] = by;
    }
    workgroupBarrier();
}

fn record_terms(index: u32) -> Terms {
    let record = records[offsets.first_record + index];
    let vx = vx_samples[offsets.first_vx + index % header.vx_count];
    return Terms(record.heading, record.clearance, vx.velocity_term, record.path);
}

fn candidate_of(index: u32, by: array<Normalizer, 4>) -> Candidate {
    if records[offsets.first_record + index].status != OK {
        return no_candidate();
    }
    return Candidate(score(record_terms(index), by[0], by[1], by[2], by[3]), index);
}

var<workgroup> candidates: array<Candidate, REDUCERS>;

// The best candidate of a workgroup, for its first invocation.
fn best_of_group(local: u32, own: Candidate) -> Candidate {
    var best = own;
    candidates[local] = best;
    for (var left = REDUCERS / FOLD; left > 0u; left /= FOLD) {
        workgroupBarrier();
        if local < left {
            for (var other = local + left; other < FOLD * left; other += left) {
                best = better(best, candidates[other]);
            }
            candidates[local] = best;
        }
    }
    return best;
}

fn answer_winner(problem: u32, best: Candidate) {
    let answer = &answers[problem];
    (*answer).winner = best.index;
    (*answer).score_low = best.score.x;
    (*answer).score_high = best.score.y;
    (*answer).stamp = header.stamp;
    (*answer).terms = Terms(0u, 0u, 0u, 0u);
    if best.index < sample_count() {
        (*answer).terms = record_terms(best.index);
    }
}

@compute @workgroup_size(REDUCERS)
fn decide(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) problem: vec3<u32>) {
    load_problem(problem.x);
    total_and_normalize(local, problem.x);
    let by = normalizers;
    var best = no_candidate();
    for (var index = local; index < sample_count(); index += REDUCERS) {
        best = better(best, candidate_of(index, by));
    }
    best = best_of_group(local, best);
    if local == 0u {
        answer_winner(problem.x, best);
    }
}

@compute @workgroup_size(REDUCERS)
fn normalize(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) problem: vec3<u32>) {
    load_problem(problem.x);
    total_and_normalize(local, problem.x);
}

@compute @workgroup_size(SAMPLES_PER_GROUP)
fn score_samples(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3<u32>) {
    let problem = problem_of(group.x, OF_SAMPLES);
    load_problem(problem);
    let index = (group.x - offsets.first_groups[OF_SAMPLES]) * SAMPLES_PER_GROUP + local;
    var candidate = no_candidate();
    if index < sample_count() {
        candidate = candidate_of(index, answers[problem].normalizers);
    }
    let best = best_of_group(local, candidate);
    if local == 0u {
        partials[group.x].best = array<u32, 3>(best.score.x, best.score.y, best.index);
    }
}

@compute @workgroup_size(REDUCERS)
fn select_winner(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) problem: vec3<u32>) {
    load_problem(problem.x);
    var finalist = no_candidate();
    for (var group = local; group < group_count(); group += REDUCERS) {
        let best = partials[offsets.first_groups[OF_SAMPLES] + group].best;
        finalist = better(finalist, Candidate(vec2<u32>(best[0], best[1]), best[2]));
    }
    finalist = best_of_group(local, finalist);
    if local == 0u {
        answer_winner(problem.x, finalist);
    }
}

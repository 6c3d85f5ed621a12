// Evaluates the samples of a batch, one invocation per sample, and adds up each workgroup. The arithmetic is in the twins.

// Turn profiles whose samples alternate within a wave. Samples of equal speed or of equal turn rate visit similar numbers of
// steps only in part: with both varying, fewer invocations of a wave wait for its slowest.
const BAND: u32 = 8u;

// Speed and turn profile of an invocation. Each band of turn profiles takes all speeds before the next band begins.
fn sample_of(invocation: u32) -> vec2<u32> {
    let per_band = header.vx_count * BAND;
    let band = invocation / per_band;
    let first_row = band * BAND;
    let rows = min(BAND, header.profile_count - first_row);
    let rest = invocation - band * per_band;
    let column = rest / rows;
    return vec2<u32>(column, first_row + rest - column * rows);
}

// Terms are below 2^24, so their sums over a workgroup fit in 32 bits.
struct GroupTotals {
    sums: vec4<u32>,
    min: vec4<u32>,
    max: vec4<u32>,
    counts: u32,
}

// The upper half of a workgroup writes, the lower half adds: half the memory lets more workgroups run at once.
const GROUP_HALF: u32 = SAMPLES_PER_GROUP / 2u;
var<workgroup> group_sums: array<vec4<u32>, GROUP_HALF>;
var<workgroup> group_min: array<vec4<u32>, GROUP_HALF>;
var<workgroup> group_max: array<vec4<u32>, GROUP_HALF>;
var<workgroup> group_counts: array<u32, GROUP_HALF>;

fn store_group(at: u32, totals: GroupTotals) {
    group_sums[at] = totals.sums;
    group_min[at] = totals.min;
    group_max[at] = totals.max;
    group_counts[at] = totals.counts;
}

fn with_group(totals: GroupTotals, at: u32) -> GroupTotals {
    return GroupTotals(
        totals.sums + group_sums[at],
        min(totals.min, group_min[at]),
        max(totals.max, group_max[at]),
        totals.counts + group_counts[at],
    );
}

@compute @workgroup_size(SAMPLES_PER_GROUP)
fn evaluate_samples(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3<u32>) {
    load_problem(problem_of(group.x, OF_SAMPLES));
    let invocation = (group.x - offsets.first_groups[OF_SAMPLES]) * SAMPLES_PER_GROUP + local;
    var totals = GroupTotals(vec4<u32>(0u), vec4<u32>(0xffffffffu), vec4<u32>(0u), 0u);
    if invocation < sample_count() {
        let sample = sample_of(invocation);
        let vx = vx_samples[offsets.first_vx + sample.x];
        let profile = profiles[offsets.first_profile + sample.y];
        let first = table_start(sample.y);
        let outcome = evaluate_sample(vx, profile, first);
        var record = Record(0u, 0u, 0u, outcome.status);
        if outcome.status == OK {
            let found = terms(vx, end_heading(profile), end_position(vx, first), outcome.clearance);
            record = Record(found.heading, found.clearance, found.path, OK);
            totals.sums = vec4<u32>(found.heading, found.clearance, found.velocity, found.path);
            totals.min = totals.sums;
            totals.max = totals.sums;
        }
        records[offsets.first_record + sample.y * header.vx_count + sample.x] = record;
        // Ten bits for each of the first three statuses; the remaining samples are outside.
        totals.counts = select(1u << (10u * outcome.status), 0u, outcome.status == OUTSIDE);
    }
    if local >= GROUP_HALF {
        store_group(local - GROUP_HALF, totals);
    }
    workgroupBarrier();
    if local < GROUP_HALF {
        totals = with_group(totals, local);
    }
    // An invocation writes only where it alone has read.
    var left = GROUP_HALF;
    for (var next = GROUP_HALF / FOLD; left > 1u; next = max(next / FOLD, 1u)) {
        if local >= next && local < left {
            store_group(local, totals);
        }
        workgroupBarrier();
        if local < next {
            for (var other = local + next; other < left; other += next) {
                totals = with_group(totals, other);
            }
        }
        left = next;
    }
    if local == 0u {
        partials[group.x].sums = totals.sums;
        partials[group.x].min = totals.min;
        partials[group.x].max = totals.max;
        partials[group.x].counts = totals.counts;
    }
}

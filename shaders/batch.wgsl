// A workgroup serves one problem of the batch; the workgroups of a problem are consecutive.

const SAMPLES_PER_GROUP: u32 = 256u;
// Number of entries that one invocation reduces to one, to save barriers.
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

// Start of a row's table, in pairs of words.
fn table_start(row: u32) -> u32 {
    return (offsets.first_table + row * table_words()) / 2u;
}

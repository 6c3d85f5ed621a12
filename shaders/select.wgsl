// Totals over the admissible samples, and the selection of the best. TWIN of src/local/select.rs.

// Score and index of a sample.
struct Candidate {
    score: vec2<u32>,
    index: u32,
}

// Loses to every admissible sample.
fn no_candidate() -> Candidate {
    return Candidate(vec2<u32>(0u, HALF_TURN), 0xffffffffu);
}

// Compares scores as signed numbers.
fn less_signed(a: vec2<u32>, b: vec2<u32>) -> bool {
    return less_wide(vec2<u32>(a.x, a.y ^ HALF_TURN), vec2<u32>(b.x, b.y ^ HALF_TURN));
}

fn better(one: Candidate, other: Candidate) -> Candidate {
    let equal = one.score.x == other.score.x && one.score.y == other.score.y;
    if less_signed(one.score, other.score) || (equal && other.index < one.index) {
        return other;
    }
    return one;
}

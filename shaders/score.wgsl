// The four terms of a trajectory, their normalisation and the score. TWIN of src/local/score.rs.

fn terms(vx: VxSample, end_heading: u32, end: vec2<i32>, clearance: u32) -> Terms {
    let to_key_x = header.key_x - end.x;
    let to_key_y = header.key_y - end.y;
    return Terms(
        heading_term(header.target_x - end.x, header.target_y - end.y, end_heading),
        clearance,
        vx.velocity_term,
        isqrt64(squared_length(to_key_x, to_key_y)),
    );
}

fn heading_term(to_target_x: i32, to_target_y: i32, heading: u32) -> u32 {
    if to_target_x == 0 && to_target_y == 0 {
        return HALF_TURN >> 8u;
    }
    let direction = atan2_turn(to_target_y, to_target_x);
    return (HALF_TURN - turn_size(direction - heading)) >> 8u;
}

fn normalizer(offset: u32, weight: u32, scale: vec2<u32>) -> Normalizer {
    if weight == 0u || (scale.x == 0u && scale.y == 0u) {
        return Normalizer(0u, 0u, 0);
    }
    let scale_zeros = leading_zeros_wide(scale);
    let weight_zeros = countLeadingZeros(weight);
    let divisor = shift_wide(scale, -bitcast<i32>(scale_zeros)).y;
    let dividend = weight << weight_zeros;
    let halved = select(0u, 1u, dividend >= divisor);
    let mantissa = div_wide(dividend >> halved, divisor);
    let bits = 32 - bitcast<i32>(halved) + bitcast<i32>(weight_zeros) - bitcast<i32>(scale_zeros);
    return Normalizer(offset, mantissa, bits);
}

// The normaliser of one term.
fn term_normalizer(weight: u32, sum: vec2<u32>, minimum: u32, maximum: u32) -> Normalizer {
    if header.min_max == 1u && minimum <= maximum {
        return normalizer(minimum, weight, vec2<u32>(maximum - minimum, 0u));
    }
    return normalizer(0u, weight, sum);
}

fn share(term: u32, by: Normalizer) -> vec2<u32> {
    return shift_wide(mul_wide(term - by.offset, by.mantissa), by.bits);
}

// Lower and upper half of the score; the top bit of the upper half is the sign.
fn score(values: Terms, heading: Normalizer, clearance: Normalizer, velocity: Normalizer, path: Normalizer) -> vec2<u32> {
    let heading_share = share(values.heading, heading);
    let sum = add_wide(add_wide(heading_share, share(values.clearance, clearance)), share(values.velocity, velocity));
    return sub_wide(sum, share(values.path, path));
}

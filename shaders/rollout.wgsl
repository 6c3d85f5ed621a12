// Rolls out one sample and checks it for contacts. TWIN of src/local/rollout.rs: same names, same order, same bits.

fn table_words() -> u32 {
    return header.steps * step_words() + 4u;
}

fn step_words() -> u32 {
    return 2u + 2u * disc_count();
}

fn displacement(coarse: i32, sum: i32) -> i32 {
    return shift_round(coarse * shift_round(sum, header.table_bits), header.coarse_bits);
}

struct StepResult {
    clearance: i32,
    outside: bool,
    static_clearance: i32,
    border: i32,
}

struct ClearanceRate {
    margin: i32,
    steps_per_unit: u32,
}

struct SampleOutcome {
    status: u32,
    clearance: u32,
}

// Only a stop within the arc needs the first step that ends the trajectory. Otherwise the last step comes first: most
// samples that collide do so near the end, and a small clearance found early lets many steps be skipped.
fn evaluate_sample(vx: VxSample, profile: TurnProfile, first: u32) -> SampleOutcome {
    let by_arc = header.stop_by_arc == 1u;
    let rate = clearance_rate(vx, profile);
    var min_clearance = bitcast<i32>(header.max_clearance);
    var done = 0u;
    var ended_by = OK;
    while done < header.steps {
        let step = select(header.steps - 1u - done, done, by_arc);
        let step_result = step_clearance(vx, first, step);
        if step_result.clearance <= 0 {
            ended_by = COLLISION;
            break;
        }
        if step_result.outside {
            ended_by = OUTSIDE;
            if by_arc {
                break;
            }
        }
        min_clearance = min(min_clearance, step_result.clearance);
        done += 1u + skippable_steps(rate, step_result, min_clearance);
    }
    let status = classify(vx, profile, ended_by, min(done, header.steps), min_clearance);
    return SampleOutcome(status, select(0u, bitcast<u32>(min_clearance), status == OK));
}

fn classify(vx: VxSample, profile: TurnProfile, ended_by: u32, free_steps: u32, min_clearance: i32) -> u32 {
    let available = select(bitcast<u32>(min_clearance), free_steps, header.stop_by_arc == 1u);
    let ends_trajectory = header.stop_by_arc == 0u || free_steps == 0u;
    if ended_by != OK && ends_trajectory {
        return ended_by;
    }
    return select(OK, CANNOT_STOP, available < vx.stopping_need || available < profile.stopping_need);
}

fn clearance_rate(vx: VxSample, profile: TurnProfile) -> ClearanceRate {
    var lever_arm = 0u;
    for (var index = 0u; index < disc_count(); index += 1u) {
        let footprint_disc = disc(index);
        lever_arm = max(lever_arm, bitcast<u32>(abs(footprint_disc.x)) + bitcast<u32>(abs(footprint_disc.y)));
    }
    var obstacle_step = 0u;
    if MOVING_OBSTACLES {
        for (var moving = 0u; moving < header.obstacle_count; moving += 1u) {
            let body = obstacle(moving);
            obstacle_step = max(obstacle_step, bitcast<u32>(abs(body.step_x)) + bitcast<u32>(abs(body.step_y)));
        }
    }
    let fastest = bitcast<u32>(max(abs(vx.coarse), abs(profile.coarse)));
    let along = (fastest * (bitcast<u32>(ONE_Q20) >> header.table_bits)) >> header.coarse_bits;
    let around = mul_hi_u32(7u * lever_arm, profile.max_turn);
    let max_change = along + around + (obstacle_step >> 8u) + 4u;
    let displacements = min(header.segment_count, 2u);
    let margin = ((1449u << header.cell_bits) >> 10u) + (max_change >> (6u - displacements)) + 16u;
    return ClearanceRate(bitcast<i32>(margin), 65536u / max_change);
}

fn skippable_steps(rate: ClearanceRate, step_result: StepResult, min_clearance: i32) -> u32 {
    let slack = min(step_result.static_clearance - min_clearance, step_result.border) - rate.margin;
    return ((bitcast<u32>(max(slack, 0)) & 0xffffu) * (rate.steps_per_unit & 0xffffu)) >> 16u;
}

fn step_clearance(vx: VxSample, first: u32, step: u32) -> StepResult {
    var at = first + step * (step_words() / 2u);
    let displaced = table[at];
    let moved_x = shift_round(vx.coarse * displaced.x, header.coarse_bits);
    let moved_y = shift_round(vx.coarse * displaced.y, header.coarse_bits);
    var result = StepResult(bitcast<i32>(header.max_clearance), false, 65535, 65535);
    for (var index = 0u; index < disc_count(); index += 1u) {
        let radius = disc_radius(index);
        at += 1u;
        let centre = table[at];
        let x = centre.x + moved_x;
        let y = centre.y + moved_y;
        let distance = clearance_at(x, y);
        if distance >= 0 {
            result.clearance = min(result.clearance, distance - radius);
            result.static_clearance = min(result.static_clearance, distance - radius);
        } else {
            result.outside = result.outside || header.outside_is_free == 0u;
            result.static_clearance = 0;
        }
        if header.outside_is_free == 0u {
            result.border = min(result.border, border_distance(x, y));
        }
        if MOVING_OBSTACLES {
            for (var moving = 0u; moving < header.obstacle_count; moving += 1u) {
                let body = obstacle(moving);
                let reach = result.clearance + radius + body.radius;
                let gap = capped_distance(body, x, y, step, reach);
                result.clearance = min(result.clearance, gap - radius - body.radius);
            }
        }
        // Lets the compiler see that the loop ends, in spite of the counter that wgpu adds to every loop.
        if ONE_DISC {
            break;
        }
    }
    if MOVING_OBSTACLES && header.obstacle_count > 0u {
        result.static_clearance = min(result.static_clearance, result.clearance);
    }
    return result;
}

// Negative off the field.
fn clearance_at(x: i32, y: i32) -> i32 {
    let column = bitcast<u32>(x >> header.cell_bits);
    let row = bitcast<u32>(y >> header.cell_bits);
    if column >= header.width || row >= header.height {
        return -1;
    }
    // Both factors are below 2^16: some adapters multiply fewer bits faster.
    let index = (row & 0xffffu) * (header.width & 0xffffu) + column;
    return bitcast<i32>((field[offsets.first_field + (index >> 1u)] >> ((index & 1u) * 16u)) & 0xffffu);
}

// Lower bound of the distance to the border of the field, units; at most 65535.
fn border_distance(x: i32, y: i32) -> i32 {
    let column = x >> header.cell_bits;
    let row = y >> header.cell_bits;
    let across = min(column, bitcast<i32>(header.width) - 1 - column);
    let along = min(row, bitcast<i32>(header.height) - 1 - row);
    return clamp(min(across, along), 0, 65535 >> header.cell_bits) << header.cell_bits;
}

fn capped_distance(body: QuantizedObstacle, x: i32, y: i32, step: u32, reach: i32) -> i32 {
    let steps = bitcast<i32>(step) + 1;
    let body_x = shift_round(body.x + steps * body.step_x, 8u);
    let body_y = shift_round(body.y + steps * body.step_y, 8u);
    let across = clamp(x - header.start_x - body_x, -46340, 46340);
    let along = clamp(y - header.start_y - body_y, -46340, 46340);
    let squared = bitcast<u32>(across * across) + bitcast<u32>(along * along);
    if reach > 0 && squared < bitcast<u32>(reach * reach) {
        return bitcast<i32>(isqrt32(squared));
    }
    return reach;
}

fn end_position(vx: VxSample, first: u32) -> vec2<i32> {
    let at = first + header.steps * (step_words() / 2u);
    let sums = table[at];
    return table[at + 1u] + vec2<i32>(
        shift_round(mul_hi_i32(vx.fine, sums.x), header.fine_bits),
        shift_round(mul_hi_i32(vx.fine, sums.y), header.fine_bits),
    );
}

fn end_heading(profile: TurnProfile) -> u32 {
    return header.heading + profile.end_turn;
}

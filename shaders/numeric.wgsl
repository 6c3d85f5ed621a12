// Integer arithmetic that every engine shares. TWIN of src/numeric.rs: same names, same order, same bits.
// WGSL has no 64-bit integers: here a u64 is vec2<u32>(lower half, upper half).

const ONE_Q20: i32 = 1048576;
const QUARTER_TURN: u32 = 0x40000000u;
const HALF_TURN: u32 = 0x80000000u;

// The full product of two 32-bit numbers.
fn mul_wide(a: u32, b: u32) -> vec2<u32> {
    let a_low = a & 0xffffu;
    let a_high = a >> 16u;
    let b_low = b & 0xffffu;
    let b_high = b >> 16u;
    let low = a_low * b_low;
    let cross = a_high * b_low + (low >> 16u);
    let middle = a_low * b_high + (cross & 0xffffu);
    return vec2<u32>((middle << 16u) | (low & 0xffffu), a_high * b_high + (cross >> 16u) + (middle >> 16u));
}

fn mul_hi_u32(a: u32, b: u32) -> u32 {
    return mul_wide(a, b).y;
}

fn mul_hi_i32(a: i32, b: i32) -> i32 {
    let unsigned = mul_hi_u32(bitcast<u32>(a), bitcast<u32>(b));
    return bitcast<i32>(unsigned) - select(0, b, a < 0) - select(0, a, b < 0);
}

fn shift_round(value: i32, bits: u32) -> i32 {
    return (value + ((1i << bits) >> 1u)) >> bits;
}

fn sin_q20(angle: u32) -> i32 {
    let turned = bitcast<i32>(angle);
    let mirrored = bitcast<i32>(HALF_TURN - angle);
    let folded = select(turned, mirrored, angle + QUARTER_TURN > HALF_TURN);
    let x = min(folded, 0x3fffffff);
    let square = mul_hi_i32(x << 1u, x << 1u);
    var sum = 80971;
    sum = mul_hi_i32(sum << 2u, square) - 2508383;
    sum = mul_hi_i32(sum << 2u, square) + 42782427;
    sum = mul_hi_i32(sum << 2u, square) - 346798938;
    sum = mul_hi_i32(sum << 2u, square) + 843314837;
    return shift_round(mul_hi_i32(x << 1u, sum << 1u), 9u);
}

fn cos_q20(angle: u32) -> i32 {
    return sin_q20(angle + QUARTER_TURN);
}

fn atan2_turn(y: i32, x: i32) -> u32 {
    let width = bitcast<u32>(abs(x));
    let height = bitcast<u32>(abs(y));
    let steep = height > width;
    let long = select(width, height, steep);
    let short = select(height, width, steep);
    if long == 0u {
        return 0u;
    }
    let scale = countLeadingZeros(long);
    let divisor = ((long << scale) >> 16u) + (((long << scale) >> 15u) & 1u);
    let quotient = (short << scale) / divisor;
    let ratio = min(quotient, 65536u);
    let x_q30 = bitcast<i32>(ratio << 14u);
    let square = mul_hi_i32(x_q30 << 1u, x_q30 << 1u);
    var sum = -4005397;
    sum = mul_hi_i32(sum << 2u, square) + 17993950;
    sum = mul_hi_i32(sum << 2u, square) - 39792550;
    sum = mul_hi_i32(sum << 2u, square) + 66148740;
    sum = mul_hi_i32(sum << 2u, square) - 113684708;
    sum = mul_hi_i32(sum << 2u, square) + 341774852;
    let flat = mul_hi_u32(bitcast<u32>(x_q30) << 1u, bitcast<u32>(sum) << 2u);
    let octant = select(flat, QUARTER_TURN - flat, steep);
    let half = select(octant, HALF_TURN - octant, x < 0);
    return select(half, 0u - half, y < 0);
}

// A float gives the first guess. Integers correct it, so the rounding of the adapter does not matter.
fn isqrt32(value: u32) -> u32 {
    var root = min(u32(sqrt(f32(value))), 65535u);
    while root * root > value {
        root -= 1u;
    }
    while root < 65535u && (root + 1u) * (root + 1u) <= value {
        root += 1u;
    }
    return root;
}

fn isqrt64(value: vec2<u32>) -> u32 {
    var root = u32(sqrt(f32(value.y) * 4294967296.0 + f32(value.x)));
    while less_wide(value, mul_wide(root, root)) {
        root -= 1u;
    }
    while !less_wide(value, mul_wide(root + 1u, root + 1u)) {
        root += 1u;
    }
    return root;
}

fn squared_length(x: i32, y: i32) -> vec2<u32> {
    let width = bitcast<u32>(abs(x));
    let height = bitcast<u32>(abs(y));
    return add_wide(mul_wide(width, width), mul_wide(height, height));
}

fn turn_size(angle: u32) -> u32 {
    return bitcast<u32>(abs(bitcast<i32>(angle)));
}

// Long division, one bit per iteration; used once per term of a decision.
fn div_wide(upper: u32, divisor: u32) -> u32 {
    var remainder = upper;
    var quotient = 0u;
    for (var bit = 0u; bit < 32u; bit += 1u) {
        let overflows = (remainder & HALF_TURN) != 0u;
        remainder = remainder << 1u;
        quotient = quotient << 1u;
        if overflows || remainder >= divisor {
            remainder -= divisor;
            quotient += 1u;
        }
    }
    return quotient;
}

fn shift_wide(value: vec2<u32>, bits: i32) -> vec2<u32> {
    if bits >= 64 {
        return vec2<u32>(0u, 0u);
    }
    if bits >= 32 {
        return vec2<u32>(value.y >> u32(bits - 32), 0u);
    }
    if bits > 0 {
        return vec2<u32>((value.x >> u32(bits)) | (value.y << u32(32 - bits)), value.y >> u32(bits));
    }
    if bits == 0 {
        return value;
    }
    if bits > -32 {
        return vec2<u32>(value.x << u32(-bits), (value.y << u32(-bits)) | (value.x >> u32(32 + bits)));
    }
    return vec2<u32>(0u, value.x << u32(-bits - 32));
}

// Rust uses the operators of u64 instead.

fn add_wide(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + select(0u, 1u, low < a.x));
}

fn sub_wide(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return vec2<u32>(a.x - b.x, a.y - b.y - select(0u, 1u, a.x < b.x));
}

fn less_wide(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

fn leading_zeros_wide(value: vec2<u32>) -> u32 {
    return select(countLeadingZeros(value.y), 32u + countLeadingZeros(value.x), value.y == 0u);
}

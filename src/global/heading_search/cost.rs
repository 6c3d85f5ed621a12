//! Costs of the lattice, in thousandths of the distance between two lattice points.

/// Units of cost for each lattice point of length.
const UNITS: f64 = 1000.0;
/// Factor of the length driven where the heading matters: the robot drives slowly there.
pub(super) const NARROW_PRICE: u64 = 2;
/// Further factor of the length driven backwards, in halves.
const BACKWARD_HALVES: u64 = 3;
/// Length that costs as much as a turn of one radian, metres.
const TURN_M: f64 = 0.25;

/// The cost of a length in lattice points in the open.
pub(super) fn length_cost(length: f64) -> u64 {
    (length * UNITS).round() as u64
}

/// The cost of a length in metres, for lattice points at this distance, metres. An infinite length has the greatest cost.
pub(super) fn metres_cost(length_m: f64, spacing_m: f64) -> u64 {
    (length_m / spacing_m * UNITS) as u64
}

/// The cost of a straight move where the heading matters.
pub(super) fn narrow_cost(length: f64, is_backward: bool) -> u64 {
    let cost = length_cost(length) * NARROW_PRICE;
    if is_backward { cost * BACKWARD_HALVES / 2 } else { cost }
}

/// The cost of a turn in place, radians.
pub(super) fn turn_cost(angle: f64, spacing_m: f64) -> u64 {
    metres_cost(angle.abs() * TURN_M, spacing_m)
}

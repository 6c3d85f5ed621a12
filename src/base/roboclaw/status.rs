//! The status bits, command 90.

use crate::base::{BaseSettings, Faults};

/// Returns whether the emergency stop is active, and the faults. Warnings are ignored.
///
/// The tables are those of command 90 in Basicmicro's "`RoboClaw` Series User Manual": four bytes from firmware 4.1.34 on, two
/// bytes in earlier editions, where overcurrent is only a warning.
pub(super) fn read(settings: &BaseSettings, bits: u32) -> (bool, Faults) {
    let any = |mask: u32| bits & mask != 0;
    let wide = settings.roboclaw.status_bytes == 4;
    let drivers = if wide { [0x40, 0x80] } else { [0x100, 0x200] };
    let [stop, hot, supply, current, stalled, other] =
        if wide { [0x01, 0x06, 0x38, 0x3000, 0x0300, 0xCC00] } else { [0x04, 0x18, 0xE0, 0, 0, 0] };
    let faults = [
        (any(drivers[0]), settings.motor_fault(false)),
        (any(drivers[1]), settings.motor_fault(true)),
        (any(hot), Faults::OVERHEATED),
        (any(supply), Faults::SUPPLY),
        (any(current), Faults::OVERCURRENT),
        (any(stalled), Faults::STALLED),
        (any(other), Faults::OTHER),
    ];
    let all = faults.into_iter().fold(Faults::NONE, |all, (set, fault)| all.union(fault.when(set)));
    (any(stop), all)
}

/// Encodes the status bits: the inverse of [`read`].
pub(super) fn write(settings: &BaseSettings, stopped: bool, faults: Faults) -> u32 {
    // Trying all sixteen bits keeps the two directions consistent.
    (0..16)
        .map(|bit| 1 << bit)
        .filter(|bit| {
            let (stops, fault) = read(settings, *bit);
            stops && stopped || !fault.is_empty() && faults.contains(fault)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::roboclaw::RoboClawSettings;

    #[test]
    fn status_round_trips_in_both_widths() {
        for status_bytes in [2, 4] {
            let settings = BaseSettings {
                swap_tracks: true,
                roboclaw: RoboClawSettings { status_bytes, ..RoboClawSettings::default() },
                ..BaseSettings::default()
            };
            for faults in
                [Faults::NONE, Faults::MOTOR_LEFT, Faults::SUPPLY.union(Faults::OVERHEATED)]
            {
                for stopped in [false, true] {
                    let bits = write(&settings, stopped, faults);
                    assert_eq!(read(&settings, bits), (stopped, faults), "{status_bytes} {bits:X}");
                }
            }
        }
    }

    #[test]
    fn status_warnings_are_no_faults() {
        let settings = BaseSettings::default();
        assert_eq!(read(&settings, 0xFFFF_0000), (false, Faults::NONE));
        assert_eq!(read(&settings, 0x0001), (true, Faults::NONE));
        assert_eq!(read(&settings, 0x0040), (false, Faults::MOTOR_LEFT));
    }

    /// The expected values are the manual's two tables.
    #[test]
    fn every_status_bit_matches_manual() {
        use Faults as F;
        let stop = (true, F::NONE);
        let fault = |fault| (false, fault);
        let nothing = fault(F::NONE);
        let [hot, supply, left, right] =
            [F::OVERHEATED, F::SUPPLY, F::MOTOR_LEFT, F::MOTOR_RIGHT].map(fault);
        let [stalled, position, current] = [F::STALLED, F::OTHER, F::OVERCURRENT].map(fault);
        let four_bytes = [
            stop, hot, hot, supply, supply, supply, left, right, stalled, stalled, position,
            position, current, current,
        ];
        let two_bytes = [
            nothing, nothing, stop, hot, hot, supply, supply, supply, left, right, nothing,
            nothing, nothing, nothing, nothing, nothing,
        ];
        let tables: [(usize, &[(bool, F)]); 2] = [(4, &four_bytes), (2, &two_bytes)];
        for (status_bytes, table) in tables {
            let mut settings = BaseSettings::default();
            settings.roboclaw.status_bytes = status_bytes;
            for (bit, expected) in table.iter().enumerate() {
                assert_eq!(read(&settings, 1 << bit), *expected, "{status_bytes} {bit}");
            }
        }
    }
}

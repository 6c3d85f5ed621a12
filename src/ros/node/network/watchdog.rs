//! The watchdog of the network process: zero velocity where the control process falls silent.

/// Longest silence of the control process, seconds. It sends a frame at each tick.
const MAX_SILENCE_S: f64 = 0.3;
/// Interval of the zeros, seconds.
const ZERO_INTERVAL_S: f64 = 0.05;

/// Decides when the network process publishes a zero of its own.
///
/// Before the first command this node does not control the robot: the watchdog stays silent.
#[derive(Clone, Copy, Debug, Default)]
pub struct CommandWatchdog {
    /// Time of the last frame, and of the last zero, seconds.
    frame_s: f64,
    zero_s: Option<f64>,
    is_moving: bool,
}

impl CommandWatchdog {
    /// A frame of the control process arrived at a time, seconds.
    pub const fn on_frame(&mut self, now_s: f64) {
        self.frame_s = now_s;
        self.zero_s = None;
    }

    /// A command was published; `is_zero`: whether it was zero velocity.
    pub const fn on_command(&mut self, is_zero: bool) {
        self.is_moving = !is_zero;
    }

    /// Whether to publish zero at a time, seconds.
    pub fn wants_zero(&mut self, now_s: f64) -> bool {
        let is_silent = now_s - self.frame_s > MAX_SILENCE_S;
        let is_due = self.zero_s.is_none_or(|zero_s| now_s - zero_s >= ZERO_INTERVAL_S);
        if !(self.is_moving && is_silent && is_due) {
            return false;
        }
        self.zero_s = Some(now_s);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silence_after_a_motion_command_causes_zeros_until_the_next_frame() {
        let mut watchdog = CommandWatchdog::default();
        watchdog.on_frame(1.0);
        assert!(!watchdog.wants_zero(9.0), "no command so far");
        watchdog.on_frame(10.0);
        watchdog.on_command(false);
        assert!(!watchdog.wants_zero(10.2));
        assert!(watchdog.wants_zero(10.31));
        assert!(!watchdog.wants_zero(10.33));
        assert!(watchdog.wants_zero(10.37));
        watchdog.on_frame(10.4);
        assert!(!watchdog.wants_zero(10.6));
        watchdog.on_command(true);
        assert!(!watchdog.wants_zero(20.0), "the last command was zero");
    }
}

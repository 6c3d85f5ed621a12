//! What the node reports: rejected messages, missing inputs, notices for the user at their first occurrence, and counters.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::mem::{Discriminant, discriminant, take};

use serde::Serialize;
use thiserror::Error;

use super::frames::NoPose;
use super::names::NodeNames;
use crate::base::{OperatorState, ProtectiveAction};
use crate::localization::{LocalizationError, LostReason};
use crate::map::{MapError, MaskFault};
use crate::navigator::{Fault, Mode, Navigator, ObservationFault};
use crate::robot::TickTime;
use crate::settings::SettingError;

/// Time after which a late tick is reported again, seconds.
const LATE_TICKS_S: f64 = 10.0;

/// A message that is older than this, seconds, was stamped by a clock that does not count from 1970: ten days.
const OTHER_EPOCH_S: f64 = 864_000.0;
/// Time without any message after the start that is reported, seconds.
const SILENCE_S: f64 = 10.0;

/// Time without a protective action after which the same action is reported again, seconds.
const QUIET_S: f64 = 1.0;

/// Why a message is rejected. A rejected message changes nothing.
#[derive(Debug, Error)]
pub enum MessageError {
    #[error("it cannot be decoded ({reason}): the topic's type must be {expected}")]
    Undecodable { reason: String, expected: &'static str },
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    #[error("{field} is above {max} m/s or rad/s: no base moves so fast")]
    TooFast { field: &'static str, max: f64 },
    #[error(
        "the quaternion of {field} has length {length}: it must be 1; (0, 0, 0, 1) is no rotation"
    )]
    BadQuaternion { field: &'static str, length: f64 },
    #[error("{field} lies more than {max_m} m from the origin: choose a nearer origin of the map")]
    TooFar { field: &'static str, max_m: f64 },
    #[error("{0} is tilted: its z axis must point up, because the robot drives in a plane")]
    Tilted(&'static str),
    #[error("it is in the frame `{found}`, the map in `{expected}`: send it in the map's frame")]
    WrongFrame { found: String, expected: String },
    #[error(
        "it is in the frame `{found}`, whose pose in the map's frame `{expected}` is not known; known frames: {known}"
    )]
    UnknownFrame { found: String, expected: String, known: String },
    #[error("its {0} is empty: name the frame")]
    NoFrame(&'static str),
    #[error("its {field} must have at most {max} bytes and no control characters")]
    BadFrameName { field: &'static str, max: usize },
    #[error(
        "its pose moves, but its speed (twist) is zero: the driver must send the measured speed"
    )]
    NoSpeed,
    #[error("tf has more than {max} frames")]
    TooManyFrames { max: usize },
    #[error("it is in the frame `{frame}`, {}", .reason.of_lidar(.base_frame))]
    LidarMount { frame: String, base_frame: String, reason: NoPose },
    #[error("its stamp is zero: the sender must set the time of the measurement")]
    NoStamp,
    #[error(
        "its stamp is {ahead_s:.3} s in the future, the limit is {limit_s} s (max_clock_ahead_s): synchronise the clocks of the \
         machines with chrony or NTP; simulated time is not supported"
    )]
    ClockAhead { ahead_s: f64, limit_s: f64 },
    /// The size, the resolution or a cell of a map is invalid.
    #[error(transparent)]
    Map(#[from] MapError),
    #[error(
        "it has {found} ranges, but {expected} beams from angle_min to angle_max by angle_increment"
    )]
    WrongBeamCount { found: usize, expected: f64 },
    #[error("the beams span {turns:.1} turns: angles are in radians")]
    TooManyTurns { turns: f64 },
    #[error(transparent)]
    OutOfRange(#[from] SettingError),
    #[error(
        "the variances of x, y and yaw must be above zero: state how uncertain the pose is, such as 0.25 m^2 and 0.07 rad^2, or \
         send only zeros for these"
    )]
    NoCovariance,
    #[error("its speed_limit is {0}: it must be zero for no limit, or above")]
    BadSpeedLimit(f64),
    #[error(
        "its type is {kind}: the node knows 0 (keepout), 1 (speed in percent) and 2 (speed in m/s)"
    )]
    UnknownFilter { kind: u8 },
    #[error(
        "its filter_mask_topic is `{found}`: the node reads `{expected}`; publish the mask there"
    )]
    OtherMask { found: String, expected: String },
    #[error("the node does not localise the robot: set pose_source = \"scans\"")]
    NotLocalizing,
    #[error("the node is {state}: its lifecycle manager must activate it first")]
    NotActive { state: &'static str },
    #[error(transparent)]
    Localization(#[from] LocalizationError),
    /// A message is a repetition or older than the last.
    #[error("its stamp is not after the stamp of the last one: check the clock of the sender")]
    NotNewer,
}

/// The input that the node waits for. Meanwhile the robot brakes to zero.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MissingInput {
    #[error("no map was received")]
    Map,
    #[error("the mask on {topic} is in the frame `{found}`, the map in `{expected}`")]
    MaskInMapFrame { topic: String, found: String, expected: String },
    #[error("the mask on {topic} cannot be used: {fault}")]
    UsableMask { topic: String, fault: MaskFault },
    #[error(
        "the mask on {mask} has no meaning without a message on {info}: start the server of the filter's info"
    )]
    FilterInfo { mask: String, info: String },
    #[error("the map is being prepared")]
    PreparedMap,
    #[error("the robot's pose is being searched ({0})")]
    Pose(LostReason),
    #[error("no odometry was received")]
    Odometry,
    /// Odometry or scans: what was received before a late tick or a loss of the transport is forgotten.
    #[error("no {0} was received since the node or its transport paused")]
    SincePause(&'static str),
    /// The last odometry is too old.
    #[error("odometry is no longer received")]
    RecentOdometry,
    #[error("odometry is received, but its stamps are too old")]
    OldOdometry,
    #[error("odometry is in the frame `{odometry}`, {}", .reason.of_odometry(.map))]
    Transform { odometry: String, map: String, reason: NoPose },
    /// A dynamic transform is too old.
    #[error(
        "tf no longer gives the pose of `{frame}` in `{ancestor}`: its last transform is too old"
    )]
    RecentTransform { frame: String, ancestor: String },
    #[error("scans are in the frame `{frame}`, {}", .reason.of_lidar(.base_frame))]
    LidarMount { frame: String, base_frame: String, reason: NoPose },
    #[error("no scan was received")]
    Scan,
    /// The last scan is too old.
    #[error("scans are no longer received")]
    RecentScan,
    #[error("scans are received, but their stamps are too old")]
    OldScan,
}

/// Counters since the start of the node.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct NodeStats {
    /// Accepted messages by topic.
    pub received: BTreeMap<&'static str, u64>,
    /// Rejected messages by topic.
    pub rejected: BTreeMap<&'static str, u64>,
    /// Accepted goals.
    pub goals: u64,
    /// Reached goals.
    pub reached: u64,
    /// Aborted goals, also those without a path and those that a newer goal replaced.
    pub aborted: u64,
    /// Published velocities.
    pub commands: u64,
    /// Ticks that came over a control period late: [`TickTime::is_late`].
    pub late_ticks: u64,
    /// Ticks in which the protective layer changed the velocity, by the name of its action.
    pub protective_actions: BTreeMap<&'static str, u64>,
    /// Least time from stamp to arrival over the last 10 s by topic, seconds: transport, and the offset between the clocks.
    pub least_delay_s: BTreeMap<&'static str, f64>,
}

impl NodeStats {
    pub(super) fn count_message(&mut self, topic: &'static str, is_accepted: bool) {
        let counts = if is_accepted { &mut self.received } else { &mut self.rejected };
        *counts.entry(topic).or_default() += 1;
    }

    /// Whether any message has been received.
    pub(super) fn has_message(&self) -> bool {
        !(self.received.is_empty() && self.rejected.is_empty())
    }

    pub(super) fn count_command(&mut self, action: &ProtectiveAction) {
        self.commands += 1;
        if !action.passes() {
            *self.protective_actions.entry(action.name()).or_default() += 1;
        }
    }
}

/// Notices for the user, and those that the user has already.
#[derive(Debug, Default)]
pub struct Notices {
    names: NodeNames,
    pending: Vec<String>,
    rejections: HashSet<(&'static str, Discriminant<MessageError>)>,
    missing: Option<MissingInput>,
    unmatched_topics: BTreeSet<&'static str>,
    late_topics: BTreeSet<&'static str>,
    /// Since when no message has been received, seconds; infinite once that is settled.
    silent_since_s: Option<f64>,
    /// Time of the last report of a late tick, seconds.
    late_tick_s: Option<f64>,
    had_sensor_fault: bool,
    /// Whether the place of the robot was blocked on the last map.
    is_place_blocked: bool,
    /// What the present sensor fault began with.
    first_fault: Option<ObservationFault>,
    operator: Option<OperatorState>,
    /// Protective actions since the layer was last quiet, and the time of the last one, seconds.
    actions: BTreeSet<&'static str>,
    acted_s: f64,
}

impl Notices {
    /// No notices, for a node with these names.
    pub fn new(names: NodeNames) -> Self {
        Self { names, ..Self::default() }
    }

    /// Adds a notice. Control characters, which the network may have sent, do not reach the user's terminal.
    pub fn push(&mut self, notice: impl Into<String>) {
        self.pending.push(notice.into().replace(char::is_control, "\u{fffd}"));
    }

    /// Takes the new notices.
    pub fn take(&mut self) -> Vec<String> {
        take(&mut self.pending)
    }

    /// A message is rejected. There is one notice for each topic and kind of error, and one for each goal.
    pub fn rejected(&mut self, topic: &'static str, is_goal: bool, error: &MessageError) {
        if self.rejections.insert((topic, discriminant(error))) || is_goal {
            let topic = self.names.shown(topic);
            self.push(format!("a message on {topic} is rejected: {error}"));
        }
    }

    /// No message of a publisher arrives. There is one notice for each topic.
    pub fn unmatched(&mut self, topic: &'static str, expected: &str) {
        if self.unmatched_topics.insert(topic) {
            let topic = self.names.shown(topic);
            self.push(format!(
                "a publisher on {topic} has another quality of service (QoS), and none of its messages arrive: publish as {expected}"
            ));
        }
    }

    /// The robot waits for an input, or for none.
    pub fn missing(&mut self, missing: Option<&MissingInput>) {
        if self.missing.as_ref() == missing {
            return;
        }
        if let Some(missing) = missing {
            self.push(format!("waiting: {missing}"));
            // Afterwards the navigator sees a gap in time: it needs no notice of its own.
            self.had_sensor_fault = true;
        }
        self.missing = missing.cloned();
    }

    /// Whether the place of the robot is blocked on a map that arrived while it drives. Reports the first of several such maps.
    pub fn place_on_map(&mut self, is_blocked: bool) {
        if is_blocked && !self.is_place_blocked {
            self.push(
                "the place of the robot is occupied or unknown on the new map: no path begins there until the robot has left it",
            );
        }
        self.is_place_blocked = is_blocked;
    }

    /// Even the fastest recent message of a topic is too old before the next one arrives. Reports the first of them.
    pub fn late(
        &mut self,
        topic: &'static str,
        least_delay_s: f64,
        least_age_s: f64,
        limit_s: f64,
    ) {
        if least_age_s <= limit_s {
            self.late_topics.remove(topic);
        } else if self.late_topics.insert(topic) {
            let cause = if least_delay_s > OTHER_EPOCH_S {
                "the sender uses simulated time (use_sim_time), which is not supported, or its clock was never set"
            } else {
                "the sender is slow or sends too rarely, or its clock is behind; synchronise the clocks with chrony or NTP"
            };
            let topic = self.names.shown(topic);
            self.push(format!(
                "messages on {topic} are {least_delay_s:.2} s old when they arrive, and {least_age_s:.2} s before the next one, the \
                 limit is {limit_s} s: {cause}"
            ));
        }
    }

    /// Reports once that nothing has ever been received for some seconds.
    pub fn silence(&mut self, now_s: f64, has_message: bool) {
        let since_s = *self.silent_since_s.get_or_insert(now_s);
        if has_message {
            self.silent_since_s = Some(f64::INFINITY);
        } else if now_s - since_s > SILENCE_S {
            self.silent_since_s = Some(f64::INFINITY);
            self.push(format!(
                "no message was received for {SILENCE_S} s: check ROS_DOMAIN_ID, the namespace and the network"
            ));
        }
    }

    /// Reports a late tick, at most one in ten seconds.
    pub fn late_tick(&mut self, now_s: f64, tick: &TickTime) {
        let is_recent = |reported_s: f64| (0.0..LATE_TICKS_S).contains(&(now_s - reported_s));
        if self.late_tick_s.is_some_and(is_recent) {
            return;
        }
        if let Some(warning) = tick.warning() {
            self.late_tick_s = Some(now_s);
            self.push(format!("the control loop is late: {warning}"));
        }
    }

    /// Reports the operator's switch at its first state and at each change.
    pub fn operator(&mut self, state: OperatorState) {
        if self.operator.replace(state) == Some(state) {
            return;
        }
        self.push(match state {
            OperatorState::NotArmed => "not armed: the robot stands until an operator arms it",
            OperatorState::Armed => "armed: the robot drives to its goals",
            OperatorState::Stopped => {
                "stopped by the operator: the robot stands until it is armed again"
            }
        });
    }

    /// Reports what the protective layer does to a command: each kind of action once until the layer is quiet. The operator's
    /// switch has notices of its own.
    pub fn protective_action(&mut self, now_s: f64, action: &ProtectiveAction) {
        if matches!(action, ProtectiveAction::NotArmed | ProtectiveAction::OperatorStop) {
            return;
        }
        if !action.passes() {
            self.acted_s = now_s;
            if self.actions.insert(action.name()) {
                self.push(format!("protection: {}: {action}", action.name()));
            }
        } else if !self.actions.is_empty() && !(0.0..=QUIET_S).contains(&(now_s - self.acted_s)) {
            self.actions.clear();
            self.push(format!("protection: {}: {action}", action.name()));
        }
    }

    /// A new navigator has had no sensor fault yet.
    pub const fn reset_sensor_fault(&mut self) {
        self.had_sensor_fault = false;
        self.first_fault = None;
    }

    /// Reports a sensor fault at its first tick.
    pub fn sensor_fault(&mut self, mode: Mode, navigator: &Navigator) {
        let has_sensor_fault = mode == Mode::SensorFault;
        let fault = navigator.observation_fault();
        if let Some(fault) = fault.filter(|_| has_sensor_fault && !self.had_sensor_fault) {
            self.push(format!("braking: {fault}"));
        }
        self.had_sensor_fault = has_sensor_fault;
        self.first_fault = self.first_fault.filter(|_| fault.is_some()).or(fault);
    }

    /// The text of a navigator's fault. Where observations became faulty for another reason than the last one, it has that
    /// reason too: a fault of odometry stops the robot, and a scan that no longer changes then looks like a frozen lidar.
    pub fn fault_text(&self, fault: &Fault) -> String {
        match (fault, self.first_fault) {
            (Fault::FaultyObservation { fault: last, .. }, Some(first)) if first != *last => {
                format!("{fault}; it began with: {first}")
            }
            _ => fault.to_string(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_of_a_fault_names_the_first_cause() {
        let fault = Fault::FaultyObservation { fault: ObservationFault::FrozenScan, count: 30 };
        let mut notices = Notices::default();
        for (first, is_named) in [
            (None, false),
            (Some(ObservationFault::FrozenScan), false),
            (Some(ObservationFault::PoseFrozen), true),
        ] {
            notices.first_fault = first;
            let text = notices.fault_text(&fault);
            assert!(text.starts_with("INVALID_OBSERVATION"), "{text}");
            assert_eq!(
                text.contains("it began with: the pose does not change"),
                is_named,
                "{text}"
            );
        }
    }
}

//! The frames on the pipes between control process and network process.
//!
//! A frame is a byte for its kind, the length of its payload as a little-endian `u32`, and the payload: a message in CDR.

use std::io::{self, Read, Write};

use crate::ros::msg::{self, Message};
use crate::ros::node::{ActionUpdate, IncomingMessage};

/// Longest payload of a map, a path or markers, bytes.
const MAX_LARGE: u32 = 256 << 20;
/// Longest other payload, bytes.
const MAX_SMALL: u32 = 4 << 20;

/// A frame of the network process.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FromNetwork {
    /// The process is alive. `unsent` is the number of ticks with a message that DDS did not take.
    Alive {
        /// The counter.
        unsent: u64,
    },
    /// DDS cannot start; the process ends.
    Failed(String),
    /// A message that arrived.
    Message(IncomingMessage),
}

/// A frame of the control process.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ToNetwork {
    /// The process is alive.
    Alive,
    /// For `cmd_vel`. The header is used for stamped velocities.
    Command(msg::TwistStamped),
    /// For `plan`.
    Path(msg::Path),
    /// For `local_markers`.
    Markers(msg::MarkerArray),
    /// For `diagnostics`.
    Diagnostics(msg::DiagnosticArray),
    /// For `tf`.
    Transforms(msg::TFMessage),
    /// For `inbye/updated_map`.
    UpdatedMap(msg::OccupancyGrid),
    /// For the clients of the action.
    Action(ActionUpdate),
    /// For the services of a managed node.
    State(msg::LifecycleAnswer),
}

/// A type of frames.
pub trait Frame: Sized {
    /// The longest payload of a kind, bytes; none for an unknown kind.
    fn max_payload(kind: u8) -> Option<u32>;
    /// Kind and payload.
    fn to_parts(&self) -> (u8, Vec<u8>);
    /// The frame with a kind and a payload, or nothing if they are invalid.
    fn from_parts(kind: u8, payload: &[u8]) -> Option<Self>;
}

impl Frame for FromNetwork {
    fn max_payload(kind: u8) -> Option<u32> {
        match kind {
            2 | 12 | 13 => Some(MAX_LARGE),
            0 | 1 | 3..=11 | 14..=22 => Some(MAX_SMALL),
            _ => None,
        }
    }

    fn to_parts(&self) -> (u8, Vec<u8>) {
        match self {
            Self::Alive { unsent } => (0, unsent.to_le_bytes().to_vec()),
            Self::Failed(reason) => (1, reason.clone().into_bytes()),
            Self::Message(message) => message.to_parts(),
        }
    }

    fn from_parts(kind: u8, payload: &[u8]) -> Option<Self> {
        match kind {
            0 => {
                let unsent = u64::from_le_bytes(payload.try_into().ok()?);
                Some(Self::Alive { unsent })
            }
            1 => Some(Self::Failed(String::from_utf8_lossy(payload).into_owned())),
            _ => IncomingMessage::from_parts(kind, payload).map(Self::Message),
        }
    }
}

impl Frame for ToNetwork {
    fn max_payload(kind: u8) -> Option<u32> {
        match kind {
            0 | 1 | 4 | 5 | 7..=12 => Some(MAX_SMALL),
            2 | 3 | 6 => Some(MAX_LARGE),
            _ => None,
        }
    }

    fn to_parts(&self) -> (u8, Vec<u8>) {
        match self {
            Self::Alive => (0, Vec::new()),
            Self::Command(message) => (1, message.to_cdr()),
            Self::Path(message) => (2, message.to_cdr()),
            Self::Markers(message) => (3, message.to_cdr()),
            Self::Diagnostics(message) => (4, message.to_cdr()),
            Self::Transforms(message) => (5, message.to_cdr()),
            Self::UpdatedMap(message) => (6, message.to_cdr()),
            Self::State(message) => (11, message.to_cdr()),
            Self::Action(update) => match update {
                ActionUpdate::Answer(message) => (7, message.to_cdr()),
                ActionUpdate::CancelAnswer(message) => (8, message.to_cdr()),
                ActionUpdate::Feedback(message) => (9, message.to_cdr()),
                ActionUpdate::End(message) => (10, message.to_cdr()),
                ActionUpdate::Result(message) => (12, message.to_cdr()),
            },
        }
    }

    fn from_parts(kind: u8, payload: &[u8]) -> Option<Self> {
        match kind {
            0 => payload.is_empty().then_some(Self::Alive),
            1 => Message::from_cdr(payload).map(Self::Command),
            2 => Message::from_cdr(payload).map(Self::Path),
            3 => Message::from_cdr(payload).map(Self::Markers),
            4 => Message::from_cdr(payload).map(Self::Diagnostics),
            5 => Message::from_cdr(payload).map(Self::Transforms),
            6 => Message::from_cdr(payload).map(Self::UpdatedMap),
            7 => Message::from_cdr(payload).map(ActionUpdate::Answer).map(Self::Action),
            8 => Message::from_cdr(payload).map(ActionUpdate::CancelAnswer).map(Self::Action),
            9 => Message::from_cdr(payload).map(ActionUpdate::Feedback).map(Self::Action),
            10 => Message::from_cdr(payload).map(ActionUpdate::End).map(Self::Action),
            11 => Message::from_cdr(payload).map(Self::State),
            12 => Message::from_cdr(payload).map(ActionUpdate::Result).map(Self::Action),
            _ => None,
        }
    }
}

/// Writes a frame. A frame that is longer than permitted is left out.
///
/// # Errors
/// When the writer fails.
pub fn write_frame<F: Frame>(writer: &mut impl Write, frame: &F) -> io::Result<()> {
    let (kind, payload) = frame.to_parts();
    let Some(length) = u32::try_from(payload.len())
        .ok()
        .filter(|length| F::max_payload(kind).is_some_and(|max| *length <= max))
    else {
        return Ok(());
    };
    writer.write_all(&[kind])?;
    writer.write_all(&length.to_le_bytes())?;
    writer.write_all(&payload)?;
    writer.flush()
}

/// Reads a frame and returns it with the length of its payload in bytes. Memory grows with the bytes that arrive, not with the
/// length that the frame states.
///
/// # Errors
/// When the reader fails or ends, and with `InvalidData` when kind, length or payload are invalid.
pub fn read_frame<F: Frame>(reader: &mut impl Read) -> io::Result<(F, usize)> {
    let mut head = [0; 5];
    reader.read_exact(&mut head)?;
    let [kind, length @ ..] = head;
    let length = u32::from_le_bytes(length);
    let max = F::max_payload(kind).ok_or_else(|| invalid("unknown kind of frame"))?;
    if length > max {
        return Err(invalid("frame is too long"));
    }
    let mut payload = Vec::new();
    let read = reader.take(u64::from(length)).read_to_end(&mut payload)?;
    if read < length as usize {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    let frame = F::from_parts(kind, &payload).ok_or_else(|| invalid("frame is malformed"))?;
    Ok((frame, read))
}

fn invalid(reason: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_return_unchanged() {
        let map = msg::OccupancyGrid { data: vec![0, 100, -1], ..msg::OccupancyGrid::default() };
        let (topic, expected) = ("scan", "LaserScan");
        let reason = "too short".to_owned();
        let frames = [
            FromNetwork::Alive { unsent: 7 },
            FromNetwork::Failed("no sockets".into()),
            FromNetwork::Message(IncomingMessage::Map(map)),
            FromNetwork::Message(IncomingMessage::Odometry(Box::default())),
            FromNetwork::Message(IncomingMessage::Transforms(msg::TFMessage::default())),
            FromNetwork::Message(IncomingMessage::Undecodable { topic, expected, reason }),
            FromNetwork::Message(IncomingMessage::Unmatched { topic, expected: "reliable".into() }),
            FromNetwork::Message(IncomingMessage::OtherPublisher {
                topic: "cmd_vel",
                is_present: true,
            }),
            FromNetwork::Message(IncomingMessage::OtherType {
                topic: "cmd_vel",
                expected: "geometry_msgs/msg/Twist".into(),
                found: Some("a type with spaces".into()),
            }),
            FromNetwork::Message(IncomingMessage::OtherType {
                topic: "scan",
                expected: "sensor_msgs/msg/LaserScan".into(),
                found: None,
            }),
            FromNetwork::Message(IncomingMessage::Arm(msg::Bool { data: true })),
            FromNetwork::Message(IncomingMessage::Stop(msg::Bool { data: true })),
            FromNetwork::Message(IncomingMessage::InitialPose(Box::default())),
            FromNetwork::Message(IncomingMessage::KeepoutMask(msg::OccupancyGrid::default())),
            FromNetwork::Message(IncomingMessage::SpeedMask(msg::OccupancyGrid::default())),
            FromNetwork::Message(IncomingMessage::FilterInfo(msg::CostmapFilterInfo::default())),
            FromNetwork::Message(IncomingMessage::SpeedLimit(msg::SpeedLimit::default())),
        ];
        let mut bytes = Vec::new();
        for frame in &frames {
            write_frame(&mut bytes, frame).expect("a vector takes all");
        }
        let mut rest = bytes.as_slice();
        for frame in &frames {
            let (read, _): (FromNetwork, _) = read_frame(&mut rest).expect("a frame");
            assert_eq!(read, *frame);
        }
        assert!(rest.is_empty());
    }

    #[test]
    fn invalid_frames_are_errors() {
        let cases: [(&[u8], io::ErrorKind); 5] = [
            (&[0, 8, 0, 0], io::ErrorKind::UnexpectedEof),
            (&[0, 8, 0, 0, 0, 1], io::ErrorKind::UnexpectedEof),
            (&[99, 0, 0, 0, 0], io::ErrorKind::InvalidData),
            (&[3, 255, 255, 255, 255, 1, 2, 3], io::ErrorKind::InvalidData),
            (&[3, 3, 0, 0, 0, 1, 2, 3], io::ErrorKind::InvalidData),
        ];
        for (bytes, kind) in cases {
            let mut bytes = bytes;
            let read: io::Result<(FromNetwork, usize)> = read_frame(&mut bytes);
            assert_eq!(read.expect_err("invalid").kind(), kind, "{bytes:?}");
        }
    }
}

//! A drive kept in a file that ROS 2 tools open, and decided again from it.
//!
//! The file is MCAP (<https://mcap.dev>) in the profile `ros2`: messages in CDR with `ros2msg` schemas, as `rosbag2` writes
//! them. [`Topic`] lists what is in it. Times are those of the drive, from zero on.
//!
//! ROS messages round ranges to float32, so there is one of our own beside them: `inbye_msgs/Tick` holds observation and
//! decision to the bit. With the configuration, the journey and the map, which the file holds too, [`replay()`] makes the
//! navigator anew, shows it what it saw, and compares every decision.
//!
//! **Memory.** A recorder holds at most 64 ticks that wait for the disk, and the file at most a chunk of 1 MiB and a tick, or
//! the map where that is larger, besides an index of a few hundred bytes for each chunk. A reader holds one chunk, and the
//! map.
//!
//! **Errors.** A full disk, a broken one and, for a drive in real time, one that is too slow end the recording, never the
//! drive. What was written before can be read: so can a file that was cut, up to its last whole chunk, which ends every 2 s.

mod cdr;
mod definitions;
mod error;
mod head;
mod messages;
mod parts;
mod reader;
mod recorder;
mod records;
mod replay;
mod topic;
mod writer;

pub use error::{FORMAT, RecordingError};
pub use head::{Head, Tail};
pub use messages::Tick;
pub use reader::Recording;
pub use recorder::{DiskBusy, Recorded, Recorder};
pub use replay::{Difference, Number, Replay, replay};
pub use topic::Topic;

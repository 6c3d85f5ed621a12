//! `builtin_interfaces`, `std_msgs` and `diagnostic_msgs`.

use core::fmt::{self, Display, Formatter};

use super::declaration::{Cdr, Decoder, Encoder, FieldType, messages};

/// The field type `byte`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "ros2", derive(serde::Serialize, serde::Deserialize))]
pub struct Byte(pub u8);

impl Cdr for Byte {
    fn encode(&self, encoder: &mut Encoder) {
        self.0.encode(encoder);
    }

    fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        u8::decode(decoder).map(Self)
    }
}

impl Display for Byte {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

impl FieldType for Byte {
    fn type_name() -> String {
        "byte".to_owned()
    }
}

messages! {
    /// A time since 1970, or zero if it is unknown.
    #[derive(Copy, Default, Eq, PartialOrd, Ord)]
    builtin_interfaces / Time {
        /// Whole seconds.
        sec: i32,
        /// Nanoseconds, 0 to 999,999,999.
        nanosec: u32,
    }

    /// A duration.
    #[derive(Copy, Default, Eq)]
    builtin_interfaces / Duration {
        /// Whole seconds.
        sec: i32,
        /// Nanoseconds, 0 to 999,999,999.
        nanosec: u32,
    }

    /// Time and frame of data.
    #[derive(Default, Eq)]
    std_msgs / Header {
        /// Time of the measurement.
        stamp: Time,
        /// Frame of the data.
        frame_id: String,
    }

    /// A named value.
    #[derive(Default, Eq)]
    diagnostic_msgs / KeyValue {
        /// The name.
        key: String,
        /// The value as text.
        value: String,
    }

    /// The status of a component.
    #[derive(Default, Eq)]
    diagnostic_msgs / DiagnosticStatus {
        [OK: Byte = Byte(0), WARN: Byte = Byte(1), ERROR: Byte = Byte(2), STALE: Byte = Byte(3)]
        /// OK, WARN, ERROR or STALE.
        level: Byte,
        /// Name of the component.
        name: String,
        /// Description of the status.
        message: String,
        /// Name of the hardware.
        hardware_id: String,
        /// Values of the status.
        values: Vec<KeyValue>,
    }

    /// The status of several components.
    #[derive(Default, Eq)]
    diagnostic_msgs / DiagnosticArray {
        /// Time and frame.
        header: Header,
        /// The statuses.
        status: Vec<DiagnosticStatus>,
    }
}

impl Time {
    /// Whether the time is unknown.
    #[must_use]
    pub const fn is_zero(&self) -> bool {
        self.sec == 0 && self.nanosec == 0
    }

    /// The time in seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        f64::from(self.sec) + f64::from(self.nanosec) * 1e-9
    }
}

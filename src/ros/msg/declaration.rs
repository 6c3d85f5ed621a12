//! The traits of message types, and the macro that declares them.
use core::fmt::Write;

pub(crate) use crate::ros::cdr::{Cdr, Decoder, Encoder};

/// A type of message fields.
pub trait FieldType: Cdr {
    /// The name of the type in a message definition, such as `float64` or `geometry_msgs/Point[]`.
    fn type_name() -> String;

    /// Appends the definitions of the type's message types, each with its name, unless they are in the list.
    fn append_definitions(_definitions: &mut Vec<(String, String)>) {}
}

/// A message type.
pub trait Message: FieldType {
    /// The package, such as `nav_msgs`.
    const PACKAGE: &'static str;
    /// The name, such as `Path`.
    const NAME: &'static str;

    /// The message in CDR.
    #[must_use]
    fn to_cdr(&self) -> Vec<u8> {
        let mut encoder = Encoder::new();
        self.encode(&mut encoder);
        encoder.finish()
    }

    /// Reads a message in CDR. Returns nothing if the bytes are not exactly one message.
    #[must_use]
    fn from_cdr(bytes: &[u8]) -> Option<Self> {
        let mut decoder = Decoder::new(bytes)?;
        let message = Self::decode(&mut decoder)?;
        decoder.is_done().then_some(message)
    }

    /// The schema in the encoding `ros2msg`: the definition, then the definitions of all types that it contains.
    #[must_use]
    fn schema() -> String {
        let mut definitions = Vec::new();
        Self::append_definitions(&mut definitions);
        let separator = "=".repeat(80);
        let mut text = String::new();
        for (name, definition) in definitions {
            if !text.is_empty() {
                let _ = writeln!(text, "{separator}\nMSG: {name}");
            }
            text += &definition;
        }
        text
    }
}

/// Declares message types: a struct, its CDR representation, and its definition with the doc comments as comments. DDS needs
/// the traits of serde.
///
/// Constants are listed in brackets. `= literal` after a field is its default in the definition.
macro_rules! messages {
    ($(
        $(#[doc = $doc:literal])*
        $(#[derive($($derive:ident),*)])?
        $package:ident / $name:ident {
            $([$($constant:ident: $constant_type:ty = $value:expr),* $(,)?])?
            $(
                $(#[doc = $field_doc:literal])*
                $field:ident: $type:ty $(= $default:literal)?,
            )*
        }
    )*) => { $(
        $(#[doc = $doc])*
        #[derive(Clone, Debug, PartialEq $($(, $derive)*)?)]
        #[cfg_attr(feature = "ros2", derive(serde::Serialize, serde::Deserialize))]
        pub struct $name {
            $(
                $(#[doc = $field_doc])*
                pub $field: $type,
            )*
        }

        $(impl $name {
            $(
                #[doc = concat!("The constant `", stringify!($constant), "` of the message definition.")]
                pub const $constant: $constant_type = $value;
            )*
        })?

        impl $crate::ros::msg::declaration::Cdr for $name {
            fn encode(&self, encoder: &mut $crate::ros::msg::declaration::Encoder) {
                $(self.$field.encode(encoder);)*
            }

            fn decode(decoder: &mut $crate::ros::msg::declaration::Decoder<'_>) -> Option<Self> {
                $(let $field = $crate::ros::msg::declaration::Cdr::decode(decoder)?;)*
                Some(Self { $($field),* })
            }
        }

        impl $crate::ros::msg::declaration::FieldType for $name {
            fn type_name() -> String {
                concat!(stringify!($package), "/", stringify!($name)).to_owned()
            }

            fn append_definitions(definitions: &mut Vec<(String, String)>) {
                let own = <Self as $crate::ros::msg::declaration::FieldType>::type_name();
                if definitions.iter().any(|(name, _)| *name == own) {
                    return;
                }
                let mut text = String::new();
                $(text += concat!("#", $doc, "\n");)*
                $($(
                    let type_name = <$constant_type as $crate::ros::msg::declaration::FieldType>::type_name();
                    text += &format!("{type_name} {}={}\n", stringify!($constant), $value);
                )*)?
                $(
                    $(text += concat!("#", $field_doc, "\n");)*
                    // The definition has the field name without Rust's prefix for keywords.
                    let field = stringify!($field);
                    let field = field.strip_prefix("r#").unwrap_or(field);
                    let type_name = <$type as $crate::ros::msg::declaration::FieldType>::type_name();
                    text += &[&type_name, " ", field, concat!($(" ", $default,)? "\n")].concat();
                )*
                definitions.push((own, text));
                $(<$type as $crate::ros::msg::declaration::FieldType>::append_definitions(definitions);)*
            }
        }

        impl $crate::ros::msg::declaration::Message for $name {
            const PACKAGE: &'static str = stringify!($package);
            const NAME: &'static str = stringify!($name);
        }
    )* };
}
pub(crate) use messages;

macro_rules! primitive_types {
    ($($type:ty: $name:literal),*) => { $(
        impl FieldType for $type {
            fn type_name() -> String {
                $name.to_owned()
            }
        }
    )* };
}
primitive_types! {
    bool: "bool", i8: "int8", u8: "uint8", i32: "int32", u32: "uint32", u64: "uint64",
    f32: "float32", f64: "float64", String: "string", [[f64; 6]; 6]: "float64[36]"
}

impl<T: FieldType> FieldType for Vec<T> {
    fn type_name() -> String {
        T::type_name() + "[]"
    }

    fn append_definitions(definitions: &mut Vec<(String, String)>) {
        T::append_definitions(definitions);
    }
}

#[cfg(test)]
mod tests {
    use super::Message;
    use crate::ros::msg::{Marker, Path, Quaternion};

    #[test]
    fn schema_defines_each_type_once() {
        let schema = Path::schema();
        let lines = || schema.lines().filter(|line| !line.starts_with('#'));
        let own: Vec<&str> = lines().take(2).collect();
        assert_eq!(own, ["std_msgs/Header header", "geometry_msgs/PoseStamped[] poses"]);
        let names: Vec<&str> = lines().filter_map(|line| line.strip_prefix("MSG: ")).collect();
        assert_eq!(
            names,
            [
                "std_msgs/Header",
                "builtin_interfaces/Time",
                "geometry_msgs/PoseStamped",
                "geometry_msgs/Pose",
                "geometry_msgs/Point",
                "geometry_msgs/Quaternion",
            ]
        );
    }

    #[test]
    fn definition_has_constants_defaults_and_keywords() {
        let marker = Marker::schema();
        assert!(marker.contains("\nint32 CYLINDER=3\n") && marker.contains("\nint32 type\n"));
        assert!(Quaternion::schema().contains("\nfloat64 w 1\n"));
    }
}

//! The traits of message types, their CDR representation, and the macro that declares them.
//!
//! ROS 2 uses plain CDR: little-endian, each number aligned to its own size. A message starts with four bytes that identify the
//! encoding. Alignment counts from the end of these bytes (OMG DDS-XTypes 7.4.1; RTPS 10.5).

use core::fmt::Write;

/// Plain CDR, little-endian.
const ENCODING: [u8; 4] = [0, 1, 0, 0];

/// Writes one message.
pub struct Encoder(Vec<u8>);

impl Encoder {
    fn number<const N: usize>(&mut self, little_endian: [u8; N]) {
        let offset = self.0.len() - ENCODING.len();
        let padded = offset.next_multiple_of(N) + ENCODING.len();
        self.0.resize(padded, 0);
        self.0.extend_from_slice(&little_endian);
    }
}

/// Reads one message.
pub struct Decoder<'a> {
    bytes: &'a [u8],
    offset: usize,
}

impl<'a> Decoder<'a> {
    fn take(&mut self, size: usize) -> Option<&'a [u8]> {
        let end = self.offset.checked_add(size)?;
        let taken = self.bytes.get(self.offset..end)?;
        self.offset = end;
        Some(taken)
    }

    fn number<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.offset = self.offset.next_multiple_of(N);
        self.take(N)?.try_into().ok()
    }
}

/// A type of message fields.
pub trait FieldType: Sized {
    /// The name of the type in a message definition, such as `float64` or `geometry_msgs/Point[]`.
    fn type_name() -> String;

    /// Appends the definitions of the type's message types, each with its name, unless they are in the list.
    fn append_definitions(_definitions: &mut Vec<(String, String)>) {}

    /// Appends the value to a message.
    fn encode(&self, encoder: &mut Encoder);

    /// Reads the value from a message. Returns nothing if the message ends too early or is invalid.
    fn decode(decoder: &mut Decoder<'_>) -> Option<Self>;
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
        let mut encoder = Encoder(ENCODING.to_vec());
        self.encode(&mut encoder);
        encoder.0
    }

    /// Reads a message in CDR. Returns nothing if the bytes are not exactly one message.
    #[must_use]
    fn from_cdr(bytes: &[u8]) -> Option<Self> {
        let mut decoder = Decoder { bytes: bytes.strip_prefix(&ENCODING)?, offset: 0 };
        let message = Self::decode(&mut decoder)?;
        (decoder.offset == decoder.bytes.len()).then_some(message)
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

            fn encode(&self, encoder: &mut $crate::ros::msg::declaration::Encoder) {
                $(self.$field.encode(encoder);)*
            }

            fn decode(decoder: &mut $crate::ros::msg::declaration::Decoder<'_>) -> Option<Self> {
                $(let $field = $crate::ros::msg::declaration::FieldType::decode(decoder)?;)*
                Some(Self { $($field),* })
            }
        }

        impl $crate::ros::msg::declaration::Message for $name {
            const PACKAGE: &'static str = stringify!($package);
            const NAME: &'static str = stringify!($name);
        }
    )* };
}
pub(crate) use messages;

macro_rules! numbers {
    ($($type:ty: $name:literal),*) => { $(
        impl FieldType for $type {
            fn type_name() -> String {
                $name.to_owned()
            }

            fn encode(&self, encoder: &mut Encoder) {
                encoder.number(self.to_le_bytes());
            }

            fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
                decoder.number().map(Self::from_le_bytes)
            }
        }
    )* };
}
numbers! {
    i8: "int8", u8: "uint8", i16: "int16", u16: "uint16", i32: "int32", u32: "uint32", i64: "int64", u64: "uint64", f32: "float32", f64: "float64"
}

impl FieldType for bool {
    fn type_name() -> String {
        "bool".to_owned()
    }

    fn encode(&self, encoder: &mut Encoder) {
        u8::from(*self).encode(encoder);
    }

    fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        match u8::decode(decoder)? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }
}

/// A string ends with a zero, which its length includes.
impl FieldType for String {
    fn type_name() -> String {
        "string".to_owned()
    }

    fn encode(&self, encoder: &mut Encoder) {
        ((self.len() + 1) as u32).encode(encoder);
        encoder.0.extend_from_slice(self.as_bytes());
        encoder.0.push(0);
    }

    fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        let length = u32::decode(decoder)? as usize;
        let (zero, text) = decoder.take(length)?.split_last()?;
        let text = str::from_utf8(text).ok()?;
        (*zero == 0).then(|| text.to_owned())
    }
}

impl<T: FieldType> FieldType for Vec<T> {
    fn type_name() -> String {
        T::type_name() + "[]"
    }

    fn append_definitions(definitions: &mut Vec<(String, String)>) {
        T::append_definitions(definitions);
    }

    fn encode(&self, encoder: &mut Encoder) {
        (self.len() as u32).encode(encoder);
        self.iter().for_each(|value| value.encode(encoder));
    }

    fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        // `collect` does not allocate by this length, which can exceed the message.
        let length = u32::decode(decoder)?;
        (0..length).map(|_| T::decode(decoder)).collect()
    }
}

/// An identity.
impl FieldType for [u8; 16] {
    fn type_name() -> String {
        "uint8[16]".to_owned()
    }

    fn encode(&self, encoder: &mut Encoder) {
        encoder.0.extend_from_slice(self);
    }

    fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        decoder.take(16)?.try_into().ok()
    }
}

/// A covariance.
impl FieldType for [[f64; 6]; 6] {
    fn type_name() -> String {
        "float64[36]".to_owned()
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.as_flattened().iter().for_each(|value| value.encode(encoder));
    }

    fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        let mut rows = Self::default();
        for value in rows.as_flattened_mut() {
            *value = f64::decode(decoder)?;
        }
        Some(rows)
    }
}

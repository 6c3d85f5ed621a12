//! Plain CDR as ROS 2 uses it: little-endian, each number aligned to its own size.
//!
//! A message starts with four bytes that identify the encoding. Alignment counts from the end of these bytes (OMG DDS-XTypes
//! 7.4.1; RTPS 10.5).

/// Plain CDR, little-endian.
const ENCODING: [u8; 4] = [0, 1, 0, 0];

/// Writes one message.
pub struct Encoder(Vec<u8>);

impl Encoder {
    /// Starts an empty message.
    #[must_use]
    pub fn new() -> Self {
        Self(ENCODING.to_vec())
    }

    /// Returns the message.
    #[must_use]
    pub fn finish(self) -> Vec<u8> {
        self.0
    }

    fn number<const N: usize>(&mut self, little_endian: [u8; N]) {
        let offset = self.0.len() - ENCODING.len();
        let padded = offset.next_multiple_of(N) + ENCODING.len();
        self.0.resize(padded, 0);
        self.0.extend_from_slice(&little_endian);
    }

    fn length(&mut self, length: usize) {
        self.number((length as u32).to_le_bytes());
    }
}

impl Default for Encoder {
    fn default() -> Self {
        Self::new()
    }
}

/// Reads one message.
pub struct Decoder<'a> {
    bytes: &'a [u8],
    offset: usize,
}

impl<'a> Decoder<'a> {
    /// Starts at the beginning of a message, or returns nothing if it has another encoding.
    #[must_use]
    pub fn new(message: &'a [u8]) -> Option<Self> {
        let bytes = message.strip_prefix(&ENCODING)?;
        Some(Self { bytes, offset: 0 })
    }

    /// Whether the message is at its end.
    #[must_use]
    pub const fn is_done(&self) -> bool {
        self.offset == self.bytes.len()
    }

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

    fn length(&mut self) -> Option<usize> {
        self.number().map(|bytes| u32::from_le_bytes(bytes) as usize)
    }
}

/// A value with a CDR representation.
pub trait Cdr: Sized {
    /// Appends the value to a message.
    fn encode(&self, encoder: &mut Encoder);

    /// Reads the value from a message. Returns nothing if the message ends too early or is invalid.
    fn decode(decoder: &mut Decoder<'_>) -> Option<Self>;
}

macro_rules! numbers {
    ($($type:ty),*) => { $(
        impl Cdr for $type {
            fn encode(&self, encoder: &mut Encoder) {
                encoder.number(self.to_le_bytes());
            }

            fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
                decoder.number().map(Self::from_le_bytes)
            }
        }
    )* };
}
numbers!(i8, u8, i32, u32, u64, f32, f64);

impl Cdr for bool {
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
impl Cdr for String {
    fn encode(&self, encoder: &mut Encoder) {
        encoder.length(self.len() + 1);
        encoder.0.extend_from_slice(self.as_bytes());
        encoder.0.push(0);
    }

    fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        let length = decoder.length()?;
        let (zero, text) = decoder.take(length)?.split_last()?;
        let text = str::from_utf8(text).ok()?;
        (*zero == 0).then(|| text.to_owned())
    }
}

impl<T: Cdr> Cdr for Vec<T> {
    fn encode(&self, encoder: &mut Encoder) {
        encoder.length(self.len());
        self.iter().for_each(|value| value.encode(encoder));
    }

    fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        // `collect` does not allocate by this length, which can exceed the message.
        let length = decoder.length()?;
        (0..length).map(|_| T::decode(decoder)).collect()
    }
}

impl<T: Cdr, const N: usize> Cdr for [T; N] {
    fn encode(&self, encoder: &mut Encoder) {
        self.iter().for_each(|value| value.encode(encoder));
    }

    fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        let values: Option<Vec<T>> = (0..N).map(|_| T::decode(decoder)).collect();
        values?.try_into().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_aligned_to_their_size() {
        let mut encoder = Encoder::new();
        7_u8.encode(&mut encoder);
        (-0.5_f64).encode(&mut encoder);
        "map".to_owned().encode(&mut encoder);
        true.encode(&mut encoder);
        0x0102_0304_u32.encode(&mut encoder);
        1.5_f32.encode(&mut encoder);
        let expected: [&[u8]; 7] = [
            &[0, 1, 0, 0],
            &[7, 0, 0, 0, 0, 0, 0, 0],
            &[0, 0, 0, 0, 0, 0, 0xE0, 0xBF],
            &[4, 0, 0, 0, b'm', b'a', b'p', 0],
            &[1, 0, 0, 0],
            &[4, 3, 2, 1],
            &[0, 0, 0xC0, 0x3F],
        ];
        assert_eq!(encoder.finish(), expected.concat());
    }

    #[test]
    fn decoding_returns_the_encoded_bits() {
        let quiet_nan = f64::from_bits(0x7FF8_0000_0000_0123);
        let reals = vec![0.1, -0.0, f64::INFINITY, quiet_nan, f64::MIN_POSITIVE / 2.0];
        let mut encoder = Encoder::new();
        true.encode(&mut encoder);
        reals.encode(&mut encoder);
        "übel".to_owned().encode(&mut encoder);
        vec![-1_i8, 0, 100].encode(&mut encoder);
        (1_u64 << 60).encode(&mut encoder);
        (-3_i32).encode(&mut encoder);
        let bytes = encoder.finish();
        let decoder = &mut Decoder::new(&bytes).expect("plain CDR");
        assert_eq!(bool::decode(decoder), Some(true));
        let bits = |reals: &Vec<f64>| reals.iter().map(|real| real.to_bits()).collect::<Vec<_>>();
        let decoded = Vec::decode(decoder).as_ref().map(bits);
        assert_eq!(decoded, Some(bits(&reals)));
        assert_eq!(String::decode(decoder).as_deref(), Some("übel"));
        assert_eq!(Vec::decode(decoder), Some(vec![-1_i8, 0, 100]));
        assert_eq!(u64::decode(decoder), Some(1 << 60));
        assert_eq!(i32::decode(decoder), Some(-3));
        assert!(decoder.is_done());
    }

    #[test]
    fn decoding_rejects_truncated_messages_and_wrong_lengths() {
        let mut encoder = Encoder::new();
        u32::MAX.encode(&mut encoder);
        1.0_f64.encode(&mut encoder);
        let bytes = encoder.finish();
        let decode = |bytes| Vec::<f64>::decode(&mut Decoder::new(bytes)?);
        assert_eq!(decode(&bytes), None);
        assert_eq!(decode(&bytes[..6]), None);
        assert!(Decoder::new(&[0, 0, 0, 0]).is_none());
    }
}

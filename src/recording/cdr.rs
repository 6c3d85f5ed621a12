//! CDR as ROS 2 has it: little-endian, each number at a multiple of its own size.
//!
//! A message begins with four bytes that name the encoding, and places are counted from behind them (OMG DDS-XTypes 7.4.1,
//! plain CDR; RTPS 10.5).

/// Plain CDR, little-endian.
const ENCODING: [u8; 4] = [0, 1, 0, 0];

/// Writes one message.
pub struct Encoder {
    bytes: Vec<u8>,
}

impl Encoder {
    /// An empty message.
    pub fn new() -> Self {
        Self {
            bytes: ENCODING.to_vec(),
        }
    }

    /// The message.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }

    fn align(&mut self, size: usize) {
        let at = self.bytes.len() - ENCODING.len();
        let padded = at.next_multiple_of(size) + ENCODING.len();
        self.bytes.resize(padded, 0);
    }

    fn number<const N: usize>(&mut self, little_endian: [u8; N]) {
        self.align(N);
        self.bytes.extend_from_slice(&little_endian);
    }

    /// A byte.
    pub fn u8(&mut self, value: u8) {
        self.bytes.push(value);
    }

    /// True or false.
    pub fn bool(&mut self, value: bool) {
        self.u8(u8::from(value));
    }

    /// A number of four bytes with a sign.
    pub fn i32(&mut self, value: i32) {
        self.number(value.to_le_bytes());
    }

    /// A number of four bytes.
    pub fn u32(&mut self, value: u32) {
        self.number(value.to_le_bytes());
    }

    /// A number of eight bytes.
    pub fn u64(&mut self, value: u64) {
        self.number(value.to_le_bytes());
    }

    /// A real number in four bytes: the nearest to it.
    pub fn f32(&mut self, value: f64) {
        self.number((value as f32).to_le_bytes());
    }

    /// A real number, to the bit.
    pub fn f64(&mut self, value: f64) {
        self.number(value.to_le_bytes());
    }

    /// Real numbers one after the other, to the bit.
    pub fn all_f64(&mut self, values: impl IntoIterator<Item = f64>) {
        values.into_iter().for_each(|value| self.f64(value));
    }

    /// Text without a zero in it.
    pub fn text(&mut self, text: &str) {
        self.count(text.len() + 1);
        self.bytes.extend_from_slice(text.as_bytes());
        self.u8(0);
    }

    /// How many entries a sequence has, before the entries.
    pub fn count(&mut self, entries: usize) {
        self.u32(entries as u32);
    }

    /// A sequence of bytes with a sign.
    pub fn all_i8(&mut self, values: &[i8]) {
        self.count(values.len());
        self.bytes.extend(values.iter().map(|&value| value as u8));
    }
}

/// Reads one message: none where it ends too early, or is in another encoding.
pub struct Decoder<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Decoder<'a> {
    /// A message from its beginning.
    pub fn new(message: &'a [u8]) -> Option<Self> {
        let bytes = message.strip_prefix(&ENCODING)?;
        Some(Self { bytes, at: 0 })
    }

    /// Whether everything was read.
    pub const fn is_done(&self) -> bool {
        self.at == self.bytes.len()
    }

    fn take(&mut self, size: usize) -> Option<&'a [u8]> {
        let taken = self.bytes.get(self.at..self.at.checked_add(size)?)?;
        self.at += size;
        Some(taken)
    }

    fn number<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.at = self.at.next_multiple_of(N);
        self.take(N)?.try_into().ok()
    }

    /// A byte.
    pub fn u8(&mut self) -> Option<u8> {
        self.number().map(u8::from_le_bytes)
    }

    /// True or false.
    pub fn bool(&mut self) -> Option<bool> {
        match self.u8()? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }

    /// A number of four bytes with a sign.
    pub fn i32(&mut self) -> Option<i32> {
        self.number().map(i32::from_le_bytes)
    }

    /// A number of four bytes.
    pub fn u32(&mut self) -> Option<u32> {
        self.number().map(u32::from_le_bytes)
    }

    /// A number of eight bytes.
    pub fn u64(&mut self) -> Option<u64> {
        self.number().map(u64::from_le_bytes)
    }

    /// A real number in four bytes.
    pub fn f32(&mut self) -> Option<f32> {
        self.number().map(f32::from_le_bytes)
    }

    /// A real number, to the bit.
    pub fn f64(&mut self) -> Option<f64> {
        self.number().map(f64::from_le_bytes)
    }

    /// A sequence of real numbers, to the bit. What it says of its own length is not believed beyond the message's end.
    pub fn all_f64(&mut self) -> Option<Vec<f64>> {
        let count = self.u32()? as usize;
        if count > 0 {
            self.at = self.at.next_multiple_of(8);
        }
        let bytes = self.take(count.checked_mul(8)?)?;
        let (numbers, _) = bytes.as_chunks::<8>();
        Some(
            numbers
                .iter()
                .map(|bytes| f64::from_le_bytes(*bytes))
                .collect(),
        )
    }

    /// Text.
    pub fn text(&mut self) -> Option<&'a str> {
        let size = self.u32()? as usize;
        let (zero, text) = self.take(size)?.split_last()?;
        (*zero == 0).then(|| str::from_utf8(text).ok())?
    }

    /// A sequence of bytes with a sign.
    pub fn all_i8(&mut self) -> Option<Vec<i8>> {
        let count = self.u32()? as usize;
        let bytes = self.take(count)?;
        Some(bytes.iter().map(|&byte| byte as i8).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_at_multiples_of_their_size() {
        let mut message = Encoder::new();
        message.u8(7);
        message.f64(-0.5);
        message.text("map");
        message.bool(true);
        message.u32(0x0102_0304);
        message.f32(1.5);
        let bytes = message.finish();
        let expected: [&[u8]; 7] = [
            &[0, 1, 0, 0],
            &[7, 0, 0, 0, 0, 0, 0, 0],
            &[0, 0, 0, 0, 0, 0, 0xE0, 0xBF],
            &[4, 0, 0, 0, b'm', b'a', b'p', 0],
            &[1, 0, 0, 0],
            &[4, 3, 2, 1],
            &[0, 0, 0xC0, 0x3F],
        ];
        assert_eq!(bytes, expected.concat());
    }

    #[test]
    fn what_was_written_is_read_to_the_bit() {
        let quiet = f64::from_bits(0x7FF8_0000_0000_0123);
        let reals = [0.1, -0.0, f64::INFINITY, quiet, f64::MIN_POSITIVE / 2.0];
        let mut message = Encoder::new();
        message.bool(true);
        message.count(reals.len());
        message.all_f64(reals);
        message.text("übel");
        message.all_i8(&[-1, 0, 100]);
        message.u64(1 << 60);
        message.i32(-3);
        let bytes = message.finish();
        let mut read = Decoder::new(&bytes).expect("the encoding is ours");
        assert_eq!(read.bool(), Some(true));
        let bits = |reals: &[f64]| reals.iter().map(|real| real.to_bits()).collect::<Vec<_>>();
        assert_eq!(read.all_f64().map(|read| bits(&read)), Some(bits(&reals)));
        assert_eq!(read.text(), Some("übel"));
        assert_eq!(read.all_i8(), Some(vec![-1, 0, 100]));
        assert_eq!((read.u64(), read.i32()), (Some(1 << 60), Some(-3)));
        assert!(read.is_done());
    }

    #[test]
    fn a_message_that_is_cut_or_lies_of_its_length_is_refused() {
        let mut message = Encoder::new();
        message.count(usize::MAX);
        message.f64(1.0);
        let bytes = message.finish();
        assert_eq!(
            Decoder::new(&bytes).and_then(|mut read| read.all_f64()),
            None
        );
        assert_eq!(
            Decoder::new(&bytes[..6]).and_then(|mut read| read.u32()),
            None
        );
        assert!(Decoder::new(&[0, 0, 0, 0]).is_none());
    }
}

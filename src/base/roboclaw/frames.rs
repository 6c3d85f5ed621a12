//! Encoding and decoding of requests and replies.

use crc::{CRC_16_XMODEM, Crc};

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_XMODEM);

/// A request to a controller. The vendor calls the first channel M1 and the second M2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// 14: set the watchdog, in 0.1 s.
    SetTimeout(u8),
    /// 15: read the watchdog.
    GetTimeout,
    /// 16 and 17: read the encoder of the first channel, or of the second.
    Encoder {
        /// Whether the second channel is read.
        second: bool,
    },
    /// 18 and 19: read the speed of the first channel, or of the second.
    Speed {
        /// Whether the second channel is read.
        second: bool,
    },
    /// 24: read the main battery's voltage.
    Battery,
    /// 37: set the speeds of both channels, pulses per second.
    Drive([i32; 2]),
    /// 90: read the status.
    Status,
}

/// A reply of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reply {
    /// The byte `FF`: the request was executed.
    Ack,
    /// The watchdog, in 0.1 s.
    Timeout(u8),
    /// An encoder count; the flags that follow it add no information.
    Encoder(u32),
    /// A speed, pulses per second.
    Speed(i32),
    /// A voltage in 0.1 V.
    Battery(u16),
    /// The status bits.
    Status(u32),
}

impl Request {
    /// Command number.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::SetTimeout(_) => 14,
            Self::GetTimeout => 15,
            Self::Encoder { second } => 16 + second as u8,
            Self::Speed { second } => 18 + second as u8,
            Self::Battery => 24,
            Self::Drive(_) => 37,
            Self::Status => 90,
        }
    }

    /// Encodes the packet. Packets that only read have no CRC.
    #[must_use]
    pub fn encode(self, address: u8) -> Vec<u8> {
        let mut packet = vec![address, self.code()];
        match self {
            Self::SetTimeout(tenths) => packet.push(tenths),
            Self::Drive(speeds) => {
                packet.extend(speeds.iter().flat_map(|speed| speed.to_be_bytes()));
            }
            _ => return packet,
        }
        let check = CRC.checksum(&packet);
        packet.extend(check.to_be_bytes());
        packet
    }

    /// Length of the reply, bytes.
    #[must_use]
    pub const fn reply_length(self, status_bytes: usize) -> usize {
        match self {
            Self::SetTimeout(_) | Self::Drive(_) => 1,
            Self::GetTimeout => 3,
            Self::Encoder { .. } | Self::Speed { .. } => 7,
            Self::Battery => 4,
            Self::Status => status_bytes + 2,
        }
    }

    /// Decodes a reply of [`Self::reply_length`] bytes; returns none if it is damaged.
    #[must_use]
    pub fn reply(self, address: u8, bytes: &[u8]) -> Option<Reply> {
        if matches!(self, Self::SetTimeout(_) | Self::Drive(_)) {
            return (bytes == [0xFF]).then_some(Reply::Ack);
        }
        let (data, check) = bytes.split_last_chunk::<2>()?;
        if self.check(address, data).to_be_bytes() != *check {
            return None;
        }
        let number = || data.first_chunk::<4>().copied();
        Some(match self {
            Self::GetTimeout => Reply::Timeout(*data.first()?),
            Self::Encoder { .. } => Reply::Encoder(u32::from_be_bytes(number()?)),
            Self::Speed { .. } => {
                // Some firmware sends an unsigned speed and the direction in the byte that follows.
                Reply::Speed(i32::from_be_bytes(number()?))
            }
            Self::Battery => Reply::Battery(u16::from_be_bytes(*data.first_chunk()?)),
            _ => Reply::Status(data.iter().fold(0, |bits, byte| bits << 8 | u32::from(*byte))),
        })
    }

    /// Encodes a reply with this data.
    #[must_use]
    pub fn encode_reply(self, address: u8, mut data: Vec<u8>) -> Vec<u8> {
        let check = self.check(address, &data);
        data.extend(check.to_be_bytes());
        data
    }

    fn check(self, address: u8, data: &[u8]) -> u16 {
        let mut digest = CRC.digest();
        digest.update(&[address, self.code()]);
        digest.update(data);
        digest.finalize()
    }

    /// Decodes the packet at the start of the received bytes and returns it with its length; none while it is incomplete.
    ///
    /// # Errors
    /// The packet is damaged, unknown, or for another address.
    pub fn decode(bytes: &[u8], address: u8) -> Result<Option<(Self, usize)>, BadPacket> {
        let [to, code, ..] = *bytes else {
            return match bytes {
                [to, ..] if *to != address => Err(BadPacket),
                _ => Ok(None),
            };
        };
        if to != address {
            return Err(BadPacket);
        }
        let read = |request| Ok(Some((request, 2)));
        let length = match code {
            14 => 5,
            15 => return read(Self::GetTimeout),
            16 | 17 => return read(Self::Encoder { second: code == 17 }),
            18 | 19 => return read(Self::Speed { second: code == 19 }),
            24 => return read(Self::Battery),
            37 => 12,
            90 => return read(Self::Status),
            _ => return Err(BadPacket),
        };
        let Some(packet) = bytes.get(..length) else {
            return Ok(None);
        };
        let (content, check) = packet.split_at(length - 2);
        if CRC.checksum(content).to_be_bytes() != check {
            return Err(BadPacket);
        }
        let request = if code == 14 {
            Self::SetTimeout(content[2])
        } else {
            let speed = |at: usize| {
                i32::from_be_bytes([content[at], content[at + 1], content[at + 2], content[at + 3]])
            };
            Self::Drive([speed(2), speed(6)])
        };
        Ok(Some((request, length)))
    }
}

/// A packet that a controller ignores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadPacket;

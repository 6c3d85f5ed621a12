//! Encoding and decoding of requests and replies, and of the status bits.

use crc::{CRC_16_XMODEM, Crc};

use crate::base::{BaseSettings, Faults};

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_XMODEM);

/// The queries of a poll cycle, in order. Each cycle includes the battery: it takes about 20 ms at 38,400 baud.
pub(super) const POLL_CYCLE: [Request; 6] = [
    Request::Encoder { second: false },
    Request::Encoder { second: true },
    Request::Speed { second: false },
    Request::Speed { second: true },
    Request::Status,
    Request::Battery,
];

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

    /// Returns the number in a reply of [`Self::reply_length`] bytes, zero for a bare confirmation; none if the reply is damaged.
    ///
    /// Encoder counts are modulo 2^32 and speeds are two's complement. The watchdog is in 0.1 s, the battery in 0.1 V.
    #[must_use]
    pub fn reply(self, address: u8, bytes: &[u8]) -> Option<u32> {
        if matches!(self, Self::SetTimeout(_) | Self::Drive(_)) {
            return (bytes == [0xFF]).then_some(0);
        }
        let (data, check) = bytes.split_last_chunk::<2>()?;
        if self.check(address, data).to_be_bytes() != *check {
            return None;
        }
        // The byte after a count or a speed is not read. Limitation: some firmware sends an unsigned speed and its direction in
        // that byte, so its reverse reads as forward.
        Some(data.iter().take(4).fold(0, |number, byte| number << 8 | u32::from(*byte)))
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
        let length = match code {
            14 => 5,
            37 => 12,
            _ => {
                let mut reads = POLL_CYCLE.into_iter().chain([Self::GetTimeout]);
                let read = reads.find(|read| read.code() == code).ok_or(BadPacket)?;
                return Ok(Some((read, 2)));
            }
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
            let (speeds, _) = content[2..].as_chunks::<4>();
            Self::Drive([0, 1].map(|channel: usize| i32::from_be_bytes(speeds[channel])))
        };
        Ok(Some((request, length)))
    }
}

/// A packet that a controller ignores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadPacket;

/// Returns whether the emergency stop is active, and the faults. Warnings are ignored.
///
/// The tables are those of command 90 in Basicmicro's "`RoboClaw` Series User Manual": four bytes from firmware 4.1.34 on, two
/// bytes in earlier editions, where overcurrent is only a warning.
pub(super) fn read_status(settings: &BaseSettings, bits: u32) -> (bool, Faults) {
    let any = |mask: u32| bits & mask != 0;
    let wide = settings.roboclaw.status_bytes == 4;
    let drivers = if wide { [0x40, 0x80] } else { [0x100, 0x200] };
    let [stop, hot, supply, current, stalled, other] =
        if wide { [0x01, 0x06, 0x38, 0x3000, 0x0300, 0xCC00] } else { [0x04, 0x18, 0xE0, 0, 0, 0] };
    let faults = [
        (any(drivers[0]), settings.motor_fault(false)),
        (any(drivers[1]), settings.motor_fault(true)),
        (any(hot), Faults::OVERHEATED),
        (any(supply), Faults::SUPPLY),
        (any(current), Faults::OVERCURRENT),
        (any(stalled), Faults::STALLED),
        (any(other), Faults::OTHER),
    ];
    let all = faults.into_iter().fold(Faults::NONE, |all, (set, fault)| all.union(fault.when(set)));
    (any(stop), all)
}

/// Encodes the status bits: the inverse of [`read_status`].
pub(super) fn write_status(settings: &BaseSettings, stopped: bool, faults: Faults) -> u32 {
    // Trying all sixteen bits keeps the two directions consistent.
    (0..16)
        .map(|bit| 1 << bit)
        .filter(|bit| {
            let (stops, fault) = read_status(settings, *bit);
            stops && stopped || !fault.is_empty() && faults.contains(fault)
        })
        .sum()
}

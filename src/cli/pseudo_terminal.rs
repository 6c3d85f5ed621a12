//! A pseudo-terminal: the port of an emulated device.

use std::io::{ErrorKind, Read, Write};
use std::time::Duration;

use anyhow::Context;
use serialport::{ClearBuffer, SerialPort, TTYPort};

/// Longest wait for received bytes.
const READ_TIMEOUT: Duration = Duration::from_millis(4);

/// Write timeout of a byte. After it no host reads.
const WRITE_TIMEOUT: Duration = Duration::from_millis(1);

/// Both ends of a pseudo-terminal. The host's end stays open so that hosts can reconnect.
pub struct PseudoTerminal {
    device: TTYPort,
    host: TTYPort,
    /// Path of the host's end.
    pub name: String,
}

impl PseudoTerminal {
    /// Opens both ends.
    pub fn open() -> anyhow::Result<Self> {
        let (device, host) = TTYPort::pair().context("cannot open a pseudo-terminal")?;
        let name = host.name().context("the pseudo-terminal has no name")?;
        Ok(Self { device, host, name })
    }

    /// Reads bytes of a host, zero if none arrive within 4 ms.
    pub fn read(&mut self, bytes: &mut [u8]) -> anyhow::Result<usize> {
        self.device.set_timeout(READ_TIMEOUT)?;
        match self.device.read(bytes) {
            Err(error) if is_timeout(error.kind()) => {
                self.release_exclusive_lock();
                Ok(0)
            }
            read => read.context("the pseudo-terminal"),
        }
    }

    /// Releases the exclusive mode that a killed host left on the terminal: it would exclude all other hosts until both ends
    /// are closed. Dropping a port releases it, so a copy is dropped here; a running host also holds a lock.
    pub fn release_exclusive_lock(&self) {
        drop(self.host.try_clone_native());
    }

    /// Writes one byte at a time, since there may be space for one only. If no host reads, the buffered bytes are outdated and
    /// are dropped.
    pub fn write(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        self.device.set_timeout(WRITE_TIMEOUT)?;
        for byte in bytes {
            match self.device.write(&[*byte]) {
                Err(error) if is_timeout(error.kind()) => {
                    return Ok(self.host.clear(ClearBuffer::Input)?);
                }
                written => written.context("the pseudo-terminal")?,
            };
        }
        Ok(())
    }
}

fn is_timeout(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

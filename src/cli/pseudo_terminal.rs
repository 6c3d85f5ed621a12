//! A pseudo-terminal: the port of an emulated device.

use std::io::{ErrorKind, Read, Write};
use std::time::Duration;

use anyhow::Context;
use serialport::{ClearBuffer, SerialPort, TTYPort};

/// Longest wait for received bytes.
const READ_TIMEOUT: Duration = Duration::from_millis(4);

/// Write timeout. After it no host reads.
const WRITE_TIMEOUT: Duration = Duration::from_millis(1);

/// Bytes that a host may leave unread: a little less than the system's buffer of 4096, and 0.2 s of a lidar.
const MAX_UNREAD: usize = 3500;

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

    /// Writes bytes to the host. If no host reads, the buffered bytes are outdated and are dropped.
    ///
    /// A write blocks until there is space for all of it, so that the space is checked first. One write for all bytes keeps the host
    /// from waking up for each of them.
    pub fn write(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        if bytes.is_empty() {
            return Ok(());
        }
        if self.host.bytes_to_read()? as usize + bytes.len() > MAX_UNREAD {
            return Ok(self.host.clear(ClearBuffer::Input)?);
        }
        self.device.set_timeout(WRITE_TIMEOUT)?;
        let mut rest = bytes;
        while !rest.is_empty() {
            match self.device.write(rest) {
                Err(error) if is_timeout(error.kind()) => {
                    return Ok(self.host.clear(ClearBuffer::Input)?);
                }
                written => {
                    let count = written.context("the pseudo-terminal")?;
                    rest = rest.get(count..).unwrap_or_default();
                }
            }
        }
        Ok(())
    }
}

fn is_timeout(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

//! Which device a serial port leads to. A name such as `/dev/ttyUSB0` belongs to whatever was plugged in last.

use std::fmt;
use std::path::{Path, PathBuf};

use serialport::SerialPortType;

use super::BaseError;

/// Opens a port by its name, and opens it again only while the name leads to the same device.
#[derive(Clone, Debug)]
pub struct SamePort {
    port: String,
    /// The device that was opened first; none before, or where the system does not tell.
    first: Option<PortIdentity>,
}

impl SamePort {
    /// A port that was not opened yet.
    #[must_use]
    pub const fn new(port: String) -> Self {
        Self { port, first: None }
    }

    /// Opens the port with a function that takes its name.
    ///
    /// # Errors
    /// [`BaseError::OtherDevice`]: the name leads to another device now; that one was not opened. Errors of the function.
    pub fn open<T>(
        &mut self,
        open: impl FnOnce(&str) -> Result<T, BaseError>,
    ) -> Result<T, BaseError> {
        self.check(PortIdentity::of(&self.port))?;
        let opened = open(&self.port)?;
        // The device may have been replaced between the check and the opening.
        let found = PortIdentity::of(&self.port);
        self.check(found.clone())?;
        self.first = self.first.take().or(found);
        Ok(opened)
    }

    fn check(&self, found: Option<PortIdentity>) -> Result<(), BaseError> {
        match (&self.first, found) {
            (Some(first), Some(found)) if !first.is_same(&found) => Err(BaseError::OtherDevice {
                port: self.port.clone(),
                was: first.to_string(),
                now: found.to_string(),
            }),
            _ => Ok(()),
        }
    }
}

/// The device of a port.
#[derive(Clone, Debug, PartialEq, Eq)]
enum PortIdentity {
    Usb(UsbDevice),
    /// A device that is not on the USB: by its number, its entry in the file system, and for a pseudo-terminal the time at
    /// which that entry was created, seconds and nanoseconds.
    Node {
        number: u64,
        entry: u64,
        created: Option<(i64, i64)>,
    },
}

/// A device on the USB.
#[derive(Clone, Debug, PartialEq, Eq)]
struct UsbDevice {
    vendor: u16,
    product: u16,
    name: String,
    serial_number: Option<String>,
    /// Where it is plugged in, such as `1-1.2`, and the interface of the device; empty where the system does not tell.
    socket: String,
    interface: String,
}

impl PortIdentity {
    /// The device that a port leads to now; none if there is none, or if the system does not tell.
    fn of(port: &str) -> Option<Self> {
        let path = Path::new(port).canonicalize().unwrap_or_else(|_| PathBuf::from(port));
        usb_device(&path).map(Self::Usb).or_else(|| node(&path))
    }

    /// Whether both are the same device. One without a serial number is the same only in the same socket.
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Usb(one), Self::Usb(other)) => {
                let is_same_kind = (one.vendor, one.product, &one.interface)
                    == (other.vendor, other.product, &other.interface)
                    && one.serial_number == other.serial_number;
                is_same_kind && (one.serial_number.is_some() || one.socket == other.socket)
            }
            _ => self == other,
        }
    }
}

impl fmt::Display for PortIdentity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usb(UsbDevice { vendor, product, name, serial_number, socket, .. }) => {
                write!(formatter, "the USB device {vendor:04x}:{product:04x}")?;
                if !name.is_empty() {
                    write!(formatter, " `{}`", name.escape_debug())?;
                }
                match serial_number {
                    Some(number) => {
                        write!(formatter, " with serial number {}", number.escape_debug())
                    }
                    None => write!(formatter, " without a serial number in socket `{socket}`"),
                }
            }
            Self::Node { number, entry, created: Some((seconds, nanoseconds)) } => write!(
                formatter,
                "the pseudo-terminal {number:x}h/{entry} created at {seconds}.{nanoseconds:09} s"
            ),
            Self::Node { number, entry, created: None } => {
                write!(formatter, "the device {number:x}h/{entry}")
            }
        }
    }
}

/// The USB device of a port, if it is one.
fn usb_device(path: &Path) -> Option<UsbDevice> {
    // The list of ports fails without this folder.
    if cfg!(target_os = "linux") && !Path::new("/sys/class/tty").is_dir() {
        return None;
    }
    let ports = serialport::available_ports().ok()?;
    let port = ports.into_iter().find(|port| Path::new(&port.port_name) == path)?;
    let SerialPortType::UsbPort(usb) = port.port_type else {
        return None;
    };
    let (socket, interface) = socket(path).unwrap_or_default();
    Some(UsbDevice {
        vendor: usb.vid,
        product: usb.pid,
        name: usb.product.unwrap_or_default(),
        serial_number: usb.serial_number.filter(|number| !number.is_empty()),
        socket,
        interface,
    })
}

/// Socket and interface of a USB port by Linux's device tree, which names the interface of a device `SOCKET:INTERFACE`.
fn socket(path: &Path) -> Option<(String, String)> {
    let name = path.file_name()?;
    let device = Path::new("/sys/class/tty").join(name).join("device").canonicalize().ok()?;
    let named = device.iter().rev().find_map(|part| part.to_str()?.split_once(':'));
    named.map(|(socket, interface)| (socket.to_owned(), interface.to_owned()))
}

#[cfg(unix)]
fn node(path: &Path) -> Option<PortIdentity> {
    use std::os::unix::fs::MetadataExt;
    let metadata = std::fs::metadata(path).ok()?;
    // The entries of pseudo-terminals are numbered like these, so that a new one has the old number.
    let is_pseudo_terminal = path.starts_with("/dev/pts");
    Some(PortIdentity::Node {
        number: metadata.rdev(),
        entry: metadata.ino(),
        created: is_pseudo_terminal.then(|| (metadata.ctime(), metadata.ctime_nsec())),
    })
}

#[cfg(not(unix))]
fn node(_: &Path) -> Option<PortIdentity> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn usb(serial_number: Option<&str>, socket: &str) -> PortIdentity {
        PortIdentity::Usb(UsbDevice {
            vendor: 0x1A86,
            product: 0x7523,
            name: "USB Serial".to_owned(),
            serial_number: serial_number.map(str::to_owned),
            socket: socket.to_owned(),
            interface: "1.0".to_owned(),
        })
    }

    #[test]
    fn usb_device_is_known_by_serial_number_or_else_by_socket() {
        let one = usb(Some("A1"), "1-1.2");
        assert!(one.is_same(&usb(Some("A1"), "1-1.4")), "in another socket");
        assert!(!one.is_same(&usb(Some("A2"), "1-1.2")));
        let without = usb(None, "1-1.2");
        assert!(without.is_same(&usb(None, "1-1.2")));
        assert!(!without.is_same(&usb(None, "1-1.4")));
        assert!(!one.is_same(&without));
        let node = PortIdentity::Node { number: 1, entry: 2, created: None };
        assert!(!one.is_same(&node) && node.is_same(&node.clone()));
        assert_eq!(one.to_string(), "the USB device 1a86:7523 `USB Serial` with serial number A1");
    }
}

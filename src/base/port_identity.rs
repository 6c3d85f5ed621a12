//! Which device a serial port leads to. A name such as `/dev/ttyUSB0` belongs to whatever was plugged in last.

use std::fmt;
use std::path::{Path, PathBuf};

use serialport::{SerialPortType, UsbPortInfo};

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

impl UsbDevice {
    /// A device as the system lists it, in a socket and with an interface. Some devices have an empty serial number.
    fn new(usb: UsbPortInfo, (socket, interface): (String, String)) -> Self {
        Self {
            vendor: usb.vid,
            product: usb.pid,
            name: usb.product.unwrap_or_default(),
            serial_number: usb.serial_number.filter(|number| !number.is_empty()),
            socket,
            interface,
        }
    }
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
    Some(UsbDevice::new(usb, socket(path).unwrap_or_default()))
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

    #[test]
    fn usb_device_of_another_kind_or_interface_is_another_device() {
        let with = |change: fn(&mut UsbDevice)| {
            let PortIdentity::Usb(mut device) = usb(Some("A1"), "1-1.2") else {
                panic!("a USB device");
            };
            change(&mut device);
            PortIdentity::Usb(device)
        };
        let one = with(|_| {});
        assert!(!one.is_same(&with(|device| device.vendor = 1)));
        assert!(!one.is_same(&with(|device| device.product = 1)));
        assert!(!one.is_same(&with(|device| device.interface = "1.1".to_owned())));
    }

    #[test]
    fn empty_serial_number_is_none() {
        let listed = |serial_number: &str| UsbPortInfo {
            vid: 0x1A86,
            pid: 0x7523,
            serial_number: Some(serial_number.to_owned()),
            manufacturer: None,
            product: None,
        };
        let device = |number| UsbDevice::new(listed(number), (String::new(), String::new()));
        assert_eq!(device("").serial_number, None);
        assert_eq!(device("A1").serial_number, Some("A1".to_owned()));
    }

    #[cfg(unix)]
    #[test]
    fn pseudo_terminal_is_known_by_its_creation_to_the_nanosecond() {
        use serialport::{SerialPort, TTYPort};
        use std::os::unix::fs::MetadataExt;
        let (_device, port) = TTYPort::pair().expect("pseudo-terminals");
        let name = port.name().expect("a name");
        let found = PortIdentity::of(&name).expect("a terminal");
        assert!(found.is_same(&PortIdentity::of(&name).expect("the same terminal")));
        let PortIdentity::Node { number, entry, created: Some((seconds, nanoseconds)) } = found
        else {
            panic!("{found:?}");
        };
        let metadata = std::fs::metadata(&name).expect("the terminal");
        assert_eq!((metadata.ctime(), metadata.ctime_nsec()), (seconds, nanoseconds));
        let later = PortIdentity::Node { number, entry, created: Some((seconds, nanoseconds + 1)) };
        assert!(!found.is_same(&later));
        // Another entry has no such time: it may be touched.
        let file = PortIdentity::of("/dev/null").expect("a device");
        assert!(matches!(file, PortIdentity::Node { created: None, .. }), "{file:?}");
    }

    /// A name that leads to another terminal, before it is opened and while it is opened.
    #[cfg(unix)]
    #[test]
    fn name_that_leads_to_another_device_is_refused_before_and_after_opening() {
        use serialport::{SerialPort, TTYPort};
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().expect("a place for temporary files");
        let link = folder.path().join("base");
        let terminals = [(), ()].map(|()| TTYPort::pair().expect("pseudo-terminals"));
        let [one, other] = terminals.each_ref().map(|(_, port)| port.name().expect("a name"));
        let lead = |target: &str| {
            let _ = std::fs::remove_file(&link);
            symlink(target, &link).expect("a link");
        };
        lead(&one);
        let mut port = SamePort::new(link.to_str().expect("text").to_owned());
        port.open(|_| Ok(())).expect("the first device");
        port.open(|_| Ok(())).expect("the same device");
        let while_opening = port.open(|_| {
            lead(&other);
            Ok(())
        });
        assert!(matches!(while_opening, Err(BaseError::OtherDevice { .. })), "{while_opening:?}");
        let mut is_opened = false;
        let before = port.open(|_| {
            is_opened = true;
            Ok(())
        });
        assert!(matches!(before, Err(BaseError::OtherDevice { .. })), "{before:?}");
        assert!(!is_opened, "the other device was opened");
        lead(&one);
        port.open(|_| Ok(())).expect("the first device still counts");
        // Also after its name was gone for a moment while it was opened.
        let vanished = port.open(|_| {
            std::fs::remove_file(&link).expect("a link");
            Ok(())
        });
        vanished.expect("the first device");
        lead(&other);
        let another = port.open(|_| Ok(()));
        assert!(matches!(another, Err(BaseError::OtherDevice { .. })), "{another:?}");
    }
}

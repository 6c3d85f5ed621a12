//! A base on a port, and the supervisor that has it.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::Duration;

use anyhow::{Context, bail};
use inbye::base::{BaseConfig, BaseSupervisor, OpenBase, Protocol};

use super::base_arguments::LineArguments;
use super::settings_file;

/// How long a base may take to answer, seconds.
const ANSWER_WITHIN_S: f64 = 3.0;

/// Time between two looks at a supervisor.
pub const LOOK: Duration = Duration::from_millis(20);

/// Which base, on which port.
#[derive(Clone, Debug)]
pub struct BaseLine {
    /// Name of the port.
    pub port: String,
    /// What the base speaks.
    pub protocol: Protocol,
    /// What it is, and how it is kept.
    pub settings: BaseConfig,
}

impl BaseLine {
    /// As typed.
    pub fn of(arguments: &LineArguments) -> anyhow::Result<Self> {
        let kind = &arguments.kind;
        Self::new(&arguments.port, kind.protocol, kind.base_config.as_deref())
    }

    /// A base on a port that speaks a protocol, with its settings.
    pub fn new(port: &str, protocol: Protocol, file: Option<&Path>) -> anyhow::Result<Self> {
        Ok(Self {
            port: port.to_owned(),
            protocol,
            settings: settings_file::read_base(file)?,
        })
    }

    /// Opens the port and keeps the base still until something is planned, or until the flag is set.
    pub fn supervisor(&self, end: Arc<AtomicBool>) -> anyhow::Result<BaseSupervisor> {
        let BaseConfig {
            base, supervisor, ..
        } = self.settings;
        BaseSupervisor::start(self.opener(), &base, supervisor, end).context("--port")
    }

    /// Waits for the first report, or for the end of the supervisor.
    pub fn await_answer(&self, supervisor: &BaseSupervisor) -> anyhow::Result<()> {
        loop {
            let status = supervisor.status();
            if status.feedback.is_some() || !status.is_running {
                return Ok(());
            }
            if supervisor.now_s() > ANSWER_WITHIN_S {
                bail!(
                    "--port {}: no answer within {ANSWER_WITHIN_S} s: is the base switched on, and does it speak --protocol {}?",
                    self.port,
                    self.protocol,
                );
            }
            thread::sleep(LOOK);
        }
    }

    #[cfg(feature = "serial")]
    fn opener(&self) -> OpenBase {
        use inbye::base::{SerialBase, SerialSettings};
        let Self {
            port,
            protocol,
            settings,
        } = self.clone();
        // A round of commands must fit into its period.
        let within = SerialSettings {
            request_timeout: Duration::from_millis(10),
            ..SerialSettings::default()
        };
        Box::new(move || {
            let session = protocol.session(settings.base)?;
            Ok(Box::new(SerialBase::open(&port, session, within)?))
        })
    }

    #[cfg(not(feature = "serial"))]
    fn opener(&self) -> OpenBase {
        let port = self.port.clone();
        Box::new(move || {
            Err(inbye::base::BaseError::CannotOpen {
                port: port.clone(),
                reason: "this program was built without its feature `serial`".to_owned(),
            })
        })
    }
}

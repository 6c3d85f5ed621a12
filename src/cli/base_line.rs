//! A base on a port, and its supervisor.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::Duration;

use anyhow::{Context, bail};
use inbye::base::{BaseConfig, BaseSupervisor, OpenBase, Protocol};

use super::base_arguments::LineArguments;
use super::config;

/// Time limit for the base's first report, seconds.
const ANSWER_TIMEOUT_S: f64 = 3.0;

/// Time between polls of a supervisor.
pub const POLL_PERIOD: Duration = Duration::from_millis(20);

/// Port, protocol and settings of a base.
#[derive(Clone, Debug)]
pub struct BaseLine {
    /// Name of the port.
    pub port: String,
    /// Protocol of the base.
    pub protocol: Protocol,
    /// Settings of the base and its supervisor.
    pub settings: BaseConfig,
}

impl BaseLine {
    /// Creates the description from the arguments.
    pub fn from_arguments(arguments: &LineArguments) -> anyhow::Result<Self> {
        let kind = &arguments.kind;
        Self::new(&arguments.port, kind.protocol, kind.base_config.as_deref())
    }

    /// Creates the description and loads the settings.
    pub fn new(port: &str, protocol: Protocol, file: Option<&Path>) -> anyhow::Result<Self> {
        Ok(Self {
            port: port.to_owned(),
            protocol,
            settings: config::load_base("--base-config", file)?,
        })
    }

    /// Opens the port and holds the base still until a target is set. The supervisor ends when the flag is set.
    pub fn supervisor(&self, shutdown: Arc<AtomicBool>) -> anyhow::Result<BaseSupervisor> {
        let BaseConfig {
            base, supervisor, ..
        } = self.settings;
        BaseSupervisor::start(self.opener(), &base, supervisor, shutdown).context("--port")
    }

    /// Waits for the first report or the end of the supervisor.
    pub fn await_answer(&self, supervisor: &BaseSupervisor) -> anyhow::Result<()> {
        loop {
            let status = supervisor.status();
            if status.feedback.is_some() || !status.is_running {
                return Ok(());
            }
            if supervisor.now_s() > ANSWER_TIMEOUT_S {
                bail!(
                    "--port {}: no answer within {ANSWER_TIMEOUT_S} s: is the base switched on, and is --protocol {} right?",
                    self.port,
                    self.protocol,
                );
            }
            thread::sleep(POLL_PERIOD);
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
        // A request must fit into the supervisor's period.
        let timeouts = SerialSettings {
            request_timeout: Duration::from_millis(10),
            ..SerialSettings::default()
        };
        Box::new(move || {
            let session = protocol.session(settings.base)?;
            Ok(Box::new(SerialBase::open(&port, session, timeouts)?))
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

//! Why a Nav2 file cannot be taken over.

use thiserror::Error;

/// A Nav2 file that gives no configuration. Each message is one line: the place in the file, what is wrong, the mend.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Nav2Error {
    /// Text that is not YAML.
    #[error("line {line}: {reason}: it must be YAML of ROS 2 parameters, each key once")]
    BadYaml {
        /// Line, from one.
        line: usize,
        /// The reader's words.
        reason: String,
    },
    /// No node of those that are read.
    #[error(
        "no parameters of controller_server, velocity_smoother or local_costmap: is it a nav2_params.yaml, with `ros__parameters` under each node?"
    )]
    NothingToRead,
    /// Parameters of several robots, and none chosen.
    #[error("parameters of several robots, in the namespaces {found}: choose one with --namespace")]
    SeveralNamespaces {
        /// All of them.
        found: String,
    },
    /// A namespace that is not there.
    #[error("no parameters in the namespace `{wanted}`: it has {found}")]
    NoSuchNamespace {
        /// As asked for.
        wanted: String,
        /// Those that are there.
        found: String,
    },
    /// One parameter twice, nested and with dots.
    #[error("{key} is given twice, once nested and once with dots: leave one out")]
    Twice {
        /// Its place in the file.
        key: String,
    },
    /// A value of the wrong kind.
    #[error("{key} is {value}: it must be {expected}")]
    BadValue {
        /// Its place in the file.
        key: String,
        /// As given.
        value: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// Values that no configuration of ours can have.
    #[error("{keys}: not possible here: {reason}")]
    OutOfRange {
        /// Where in the file the values come from.
        keys: String,
        /// What is wrong, in our names.
        reason: String,
    },
}

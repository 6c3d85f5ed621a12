//! Errors of the import.

use thiserror::Error;

/// Why a Nav2 file cannot be imported. Each message is one line: the place in the file, the cause, the cure.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Nav2Error {
    /// The text is not valid YAML.
    #[error("line {line}: {reason}: it must be YAML of ROS 2 parameters, each key once")]
    BadYaml {
        /// Line, from one.
        line: usize,
        /// Message of the parser.
        reason: String,
    },
    /// The file has none of the imported nodes.
    #[error(
        "no parameters of controller_server, velocity_smoother or local_costmap: it must be a nav2_params.yaml, with `ros__parameters` under each node"
    )]
    NoNodes,
    /// The file has several robots, and no namespace is given.
    #[error("the file has several robots, in the namespaces {found}: choose a namespace")]
    SeveralNamespaces {
        /// The namespaces.
        found: String,
    },
    /// The file has no robot in the given namespace.
    #[error("no parameters in the namespace `{namespace}`: the file has {found}")]
    UnknownNamespace {
        /// The given namespace.
        namespace: String,
        /// The namespaces of the file.
        found: String,
    },
    /// A parameter is both nested and written with dots.
    #[error("{parameter} is given twice, once nested and once with dots: remove one")]
    Duplicate {
        /// Path of the parameter.
        parameter: String,
    },
    /// A value has the wrong type.
    #[error("{parameter} is {value}: it must be {expected}")]
    BadValue {
        /// Path of the parameter.
        parameter: String,
        /// The value.
        value: String,
        /// The valid values.
        expected: &'static str,
    },
    /// A value is out of the range of its setting.
    #[error("{parameters}: out of range: {reason}")]
    OutOfRange {
        /// Paths of the parameters.
        parameters: String,
        /// The cause, with the names of the settings.
        reason: String,
    },
}

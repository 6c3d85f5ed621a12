//! The file that describes a base and how it is kept.

use std::path::Path;

use anyhow::Context;
use inbye::base::{BaseSettings, KeeperSettings};
use serde::{Deserialize, Serialize};

use super::config;

/// The file of `--base-config`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BaseFile {
    /// What the driver must know of the base.
    pub base: BaseSettings,
    /// How it is kept.
    pub keeper: KeeperSettings,
}

impl BaseFile {
    /// Reads the file, or takes the defaults.
    pub fn read(file: Option<&Path>) -> anyhow::Result<Self> {
        config::read("--base-config", file, Self::validate)
    }

    /// Checks every number.
    pub fn validate(&self) -> anyhow::Result<()> {
        self.base.validate().context("base")?;
        self.keeper.validate().context("keeper")
    }
}

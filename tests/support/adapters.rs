//! Selects the adapters of a test.
//!
//! A GPU test runs once per adapter of the machine. Without an adapter it is *ignored with the reason*, never passed.
//! `INBYE_REQUIRE` names the adapters that must exist, for example in continuous integration; each GPU test fails
//! without them:
//!
//! ```text
//! INBYE_REQUIRE=lavapipe,swiftshader cargo test --test conditional engine
//! ```

use std::sync::Arc;

use inbye::local::{Adapter, adapters};
use libtest_mimic::{Completion, Failed, Trial};

use super::requirements::{VARIABLE, required};

/// A test of one adapter.
pub type GpuTest = fn(&Adapter) -> Result<(), Failed>;

/// Words of `INBYE_REQUIRE` that are not adapters: other tests read the same variable.
const OTHERS: [&str; 5] = ["python", "chromium", "cyclonedds", "planners", "ray"];

/// The part of an adapter's name that identifies a required adapter. Other words are used as they are.
fn part_of_name(required: &str) -> &str {
    match required {
        "lavapipe" => "llvmpipe",
        "swiftshader" => "swiftshader",
        other => other,
    }
}

/// One trial per test and adapter: existing ones, and required ones that are missing.
pub fn trials(tests: &[(&'static str, GpuTest)]) -> Vec<Trial> {
    let adapters: Vec<Arc<Adapter>> = adapters().into_iter().map(Arc::new).collect();
    let missing = missing(&adapters);
    let mut trials = Vec::new();
    for &(name, test) in tests {
        for adapter in &adapters {
            let adapter = Arc::clone(adapter);
            let summary = format!("{}, {}", adapter.summary.name, adapter.summary.backend);
            trials.push(Trial::test(name, move || test(&adapter)).with_kind(summary));
        }
        for (required, why) in &missing {
            let why = why.clone();
            trials.push(Trial::test(name, move || Err(why.into())).with_kind(required));
        }
        if adapters.is_empty() && missing.is_empty() {
            let why = format!("no GPU adapter found; {VARIABLE}=lavapipe makes this a failure");
            let ignored = move || Ok(Completion::ignored_with(why));
            trials.push(Trial::ignorable_test(name, ignored).with_kind("no adapter"));
        }
    }
    trials
}

/// The required adapters that are missing, each with a message.
fn missing(adapters: &[Arc<Adapter>]) -> Vec<(String, String)> {
    let names: Vec<&str> = adapters.iter().map(|adapter| adapter.summary.name.as_str()).collect();
    let found = if names.is_empty() { "none".to_owned() } else { names.join("; ") };
    let mut missing = Vec::new();
    for word in required() {
        if OTHERS.contains(&word.as_str()) {
            continue;
        }
        let part = part_of_name(&word);
        if !names.iter().any(|name| name.to_lowercase().contains(part)) {
            let why = format!(
                "{VARIABLE} names {word}, but no adapter's name contains `{part}`; found: {found}"
            );
            missing.push((word, why));
        }
    }
    missing
}

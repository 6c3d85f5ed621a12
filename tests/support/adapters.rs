//! Which adapters a test runs on, and what becomes of it where there is none.
//!
//! A GPU test runs once for each adapter present. With none it is *ignored, with the reason*: never passed. Where an
//! adapter must be there, as in continuous integration, `INBYE_REQUIRE` names it, and each GPU test fails without it:
//!
//! ```text
//! INBYE_REQUIRE=lavapipe,swiftshader cargo test --test engine_parity
//! ```

use std::sync::Arc;

use inbye::local::{Adapter, adapters};
use libtest_mimic::{Completion, Failed, Trial};

use super::requirements::{VARIABLE, required};

/// A test of one adapter.
pub type GpuTest = fn(&Adapter) -> Result<(), Failed>;

/// Not adapters: the tests of the map loaders, in a browser, against Cyclone DDS and on Ray read the same variable for what
/// they require.
const OTHERS: [&str; 4] = ["python", "chromium", "cyclonedds", "ray"];

/// What an adapter's name contains when it is the one required. Any other word stands for itself.
fn part_of_name(required: &str) -> &str {
    match required {
        "lavapipe" => "llvmpipe",
        "swiftshader" => "swiftshader",
        other => other,
    }
}

/// A trial for each test and adapter: those present, and those required and missing.
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

/// The adapters required but missing, each with what to say of it.
fn missing(adapters: &[Arc<Adapter>]) -> Vec<(String, String)> {
    let names: Vec<&str> = adapters
        .iter()
        .map(|adapter| adapter.summary.name.as_str())
        .collect();
    let found = if names.is_empty() {
        "none".to_owned()
    } else {
        names.join("; ")
    };
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

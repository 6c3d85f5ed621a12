//! Which adapters a test runs on, and what becomes of it where there is none.
//!
//! A GPU test runs once for each adapter present. With none it is *ignored, with the reason*: never passed. Where an
//! adapter must be there, as in continuous integration, `INBYE_REQUIRE` names it and its absence is a failure:
//!
//! ```text
//! INBYE_REQUIRE=lavapipe,swiftshader cargo test --test engine_parity
//! ```

use std::sync::Arc;

use inbye::local::gpu::{Adapter, adapters};
use libtest_mimic::{Completion, Failed, Trial};

/// A test of one adapter.
pub type GpuTest = fn(&Adapter) -> Result<(), Failed>;

const VARIABLE: &str = "INBYE_REQUIRE";

/// What an adapter's name contains when it is the one required. Any other word stands for itself.
fn part_of_name(required: &str) -> &str {
    match required {
        "lavapipe" => "llvmpipe",
        "swiftshader" => "SwiftShader",
        other => other,
    }
}

/// A trial for each test and adapter, and one for each adapter required.
pub fn trials(tests: &[(&'static str, GpuTest)]) -> Vec<Trial> {
    let adapters: Vec<Arc<Adapter>> = adapters().into_iter().map(Arc::new).collect();
    let names: Vec<&str> = adapters
        .iter()
        .map(|adapter| adapter.summary.name.as_str())
        .collect();
    let required = std::env::var(VARIABLE).unwrap_or_default();
    let required = required
        .split(',')
        .map(str::trim)
        .filter(|word| !word.is_empty());
    let mut trials: Vec<Trial> = required.map(|word| required_trial(word, &names)).collect();
    for &(name, test) in tests {
        if adapters.is_empty() {
            trials.push(ignored(name));
        }
        for adapter in &adapters {
            let adapter = Arc::clone(adapter);
            let summary = format!("{}, {}", adapter.summary.name, adapter.summary.backend);
            trials.push(Trial::test(name, move || test(&adapter)).with_kind(summary));
        }
    }
    trials
}

fn ignored(name: &str) -> Trial {
    let run = || {
        let reason = format!("no GPU adapter found; {VARIABLE}=lavapipe would make this a failure");
        Ok(Completion::ignored_with(reason))
    };
    Trial::ignorable_test(name, run).with_kind("no adapter")
}

fn required_trial(required: &str, names: &[&str]) -> Trial {
    let part = part_of_name(required);
    let present = names
        .iter()
        .any(|name| name.to_lowercase().contains(&part.to_lowercase()));
    let found = if names.is_empty() {
        "none".to_owned()
    } else {
        names.join("; ")
    };
    let failure = format!(
        "{VARIABLE} names {required}, but no adapter's name contains `{part}`; found: {found}"
    );
    Trial::test(format!("adapter {required} is here"), move || {
        if present { Ok(()) } else { Err(failure.into()) }
    })
}

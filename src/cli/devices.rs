//! `inbye devices`.

use serde_json::json;

use super::{engines, output};

/// Lists GPU adapters and CPU features.
pub fn run(json: bool) -> anyhow::Result<bool> {
    let adapters = adapters();
    let features = cpu_features();
    if json {
        let cpu = json!({
            "cores": engines::cores(),
            "architecture": std::env::consts::ARCH,
            "features": features,
        });
        output::json(&json!({ "adapters": adapters, "cpu": cpu }))?;
        return Ok(true);
    }
    output::line(format!(
        "CPU: {} cores, {}, {}",
        engines::cores(),
        std::env::consts::ARCH,
        if features.is_empty() { "no vector features".to_owned() } else { features.join(" ") },
    ));
    if adapters.is_empty() {
        output::line("GPU: no adapter found (Debian's mesa-vulkan-drivers has a software one)");
    }
    for adapter in &adapters {
        let text = |key: &str| adapter[key].as_str().unwrap_or_default().to_owned();
        let kind = if adapter["software"] == true { "software" } else { "hardware" };
        let (name, backend, driver) = (text("name"), text("backend"), text("driver"));
        output::line(format!("GPU: {name} ({kind}, {backend}, {driver})"));
    }
    Ok(true)
}

#[cfg(feature = "gpu")]
fn adapters() -> Vec<serde_json::Value> {
    inbye::local::adapters().iter().map(|adapter| json!(adapter.summary)).collect()
}

#[cfg(not(feature = "gpu"))]
fn adapters() -> Vec<serde_json::Value> {
    Vec::new()
}

#[cfg(target_arch = "x86_64")]
fn cpu_features() -> Vec<&'static str> {
    let found = [
        ("sse4.1", is_x86_feature_detected!("sse4.1")),
        ("avx2", is_x86_feature_detected!("avx2")),
        ("fma", is_x86_feature_detected!("fma")),
        ("avx512f", is_x86_feature_detected!("avx512f")),
        ("avx512bw", is_x86_feature_detected!("avx512bw")),
    ];
    found.into_iter().filter(|(_, present)| *present).map(|(name, _)| name).collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn cpu_features() -> Vec<&'static str> {
    Vec::new()
}

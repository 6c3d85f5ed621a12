//! What the page must know before it can ask: the shaders' buffers and structs, the bounds, the scenes.

use core::mem::offset_of;

use inbye::local::Reason;
use inbye::local::gpu::bindings::{ACCESS, ANSWERS, Access, FIELD, RECORDS};
use inbye::local::gpu::layout::{Answer, BATCH_BYTES, Record};
use inbye::local::gpu::shaders::ENTRY_POINTS;
use serde_json::{Value, json};

use super::bounds;
use super::request::MOST_BODY_BYTES;
use super::scene::Scene;

/// The binding of the displacement tables: what lies between the fields and the records.
const TABLE: usize = FIELD + 1;
/// The binding of the workgroups' sums: what lies between the records and the answers.
const PARTIALS: usize = RECORDS + 1;

macro_rules! words {
    ($struct:ty: $($field:ident),+) => {
        json!({ $(stringify!($field): offset_of!($struct, $field) / 4),+ })
    };
}

/// One object for the page.
pub fn setup(scenes: &[Scene]) -> Value {
    json!({
        "shader": {
            "entry_points": ENTRY_POINTS,
            "bindings": bindings(),
            "uniform_bytes": BATCH_BYTES,
            "answer": words!(Answer: counts, sums_low, sums_high, least, greatest, winner, score_low, score_high, stamp, terms),
            "record": words!(Record: heading, clearance, path, reason),
            "record_words": size_of::<Record>() / 4,
        },
        "reasons": (0..4).map(|number| Reason::from_number(number).word()).collect::<Vec<_>>(),
        "bounds": {
            "samples": bounds::MOST_SAMPLES,
            "obstacles": bounds::MOST_OBSTACLES,
            "meetings": bounds::MOST_MEETINGS,
            "body_bytes": MOST_BODY_BYTES,
        },
        "scenes": scenes.iter().map(scene).collect::<Vec<_>>(),
    })
}

/// The buffer behind each binding, and how it is reached, in WebGPU's words.
fn bindings() -> Vec<Value> {
    let buffer = |binding| match binding {
        ..FIELD => "input",
        FIELD => "field",
        TABLE => "table",
        RECORDS => "records",
        PARTIALS => "partials",
        ANSWERS.. => "answers",
    };
    let kind = |access| match access {
        Access::Uniform => "uniform",
        Access::Read => "read-only-storage",
        Access::ReadWrite => "storage",
    };
    let all = ACCESS.into_iter().enumerate();
    all.map(|(binding, access)| json!({ "buffer": buffer(binding), "type": kind(access) }))
        .collect()
}

fn scene(scene: &Scene) -> Value {
    let frame = scene.field.frame();
    let origin = frame.origin;
    json!({
        "name": scene.name,
        "title": scene.title,
        "width": frame.width,
        "height": frame.height,
        "resolution_m": frame.resolution_m,
        "origin": [origin.x, origin.y, origin.yaw],
        "problem": scene.problem,
    })
}

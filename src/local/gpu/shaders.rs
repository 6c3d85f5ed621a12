//! The shader text: the files of `shaders/`, in the one order in which they build on one another.

/// Each part and its text.
pub const PARTS: [(&str, &str); 6] = [
    (
        "numeric.wgsl",
        include_str!("../../../shaders/numeric.wgsl"),
    ),
    ("layout.wgsl", include_str!("../../../shaders/layout.wgsl")),
    (
        "rollout.wgsl",
        include_str!("../../../shaders/rollout.wgsl"),
    ),
    ("score.wgsl", include_str!("../../../shaders/score.wgsl")),
    ("select.wgsl", include_str!("../../../shaders/select.wgsl")),
    (
        "evaluate.wgsl",
        include_str!("../../../shaders/evaluate.wgsl"),
    ),
];

/// The entry points of `evaluate.wgsl`, in the order of their dispatches.
pub const ENTRY_POINTS: [&str; 5] = [
    "tabulate_turns",
    "judge_samples",
    "normalize",
    "score_samples",
    "choose",
];

/// One module of all parts.
#[must_use]
pub fn source() -> String {
    PARTS.map(|(_, text)| text).join("\n")
}

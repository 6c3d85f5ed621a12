//! The first decision of an engine, so that no robot waits for what only a first one costs.

use std::sync::Arc;

use crate::geometry::Pose;
use crate::local::inputs::{BodyDisc, Header, Speed, Turn};
use crate::local::{ClearanceField, Prepared};
use crate::map::{GridFrame, ObstacleGrid};

/// The smallest problem: one sample of one step, standing still on a free cell.
pub(super) fn problem() -> Prepared {
    let frame = GridFrame {
        width: 1,
        height: 1,
        resolution_m: 0.1,
        origin: Pose::default(),
    };
    let field = ClearanceField::new(&ObstacleGrid::new(frame, vec![false]))
        .expect("10 cm is within the range of resolutions");
    Prepared {
        header: Header {
            v_count: 1,
            omega_count: 1,
            steps: 1,
            disc_count: 1,
            width: 1,
            height: 1,
            ..Header::default()
        },
        speeds: vec![Speed::default()],
        turns: vec![Turn::default()],
        discs: vec![BodyDisc::default()],
        obstacles: Vec::new(),
        field: Arc::new(field),
    }
}

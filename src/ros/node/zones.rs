//! The zones of the node: masks of keepout and speed filters, and a limit for everywhere.

use std::sync::Arc;

use super::incoming::MapInput;
use super::notices::{MessageError, MissingInput};
use crate::map::{GridFrame, OccupancyGrid, Zones};
use crate::ros::msg::{CostmapFilterInfo, SpeedLimit};

/// The topics of the masks, as in Nav2's examples.
pub const KEEPOUT_MASK: &str = "keepout_filter_mask";
pub const SPEED_MASK: &str = "speed_filter_mask";

/// The limit for a value of a speed mask, `base + multiplier * value`: in percent of the largest speed, or in m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SpeedScale {
    base: f64,
    multiplier: f64,
    is_percent: bool,
}

/// The newest masks and limits.
#[derive(Debug, Default)]
pub struct ZoneInputs {
    keepout: Option<MapInput>,
    speed: Option<MapInput>,
    scale: Option<SpeedScale>,
    /// For everywhere, in percent of the largest speed or in m/s; none for no limit.
    limit: Option<(f64, bool)>,
}

impl ZoneInputs {
    /// Sets the mask of closed zones. Returns whether it is new.
    pub fn set_keepout(&mut self, mask: MapInput) -> bool {
        replace(&mut self.keepout, mask)
    }

    /// Sets the mask of speed limits. Returns whether it is new.
    pub fn set_speed(&mut self, mask: MapInput) -> bool {
        replace(&mut self.speed, mask)
    }

    /// Sets what a mask means. Returns whether that is new.
    ///
    /// # Errors
    /// When the kind is unknown, a number is not finite, or the node does not read that mask.
    pub fn set_info(&mut self, info: &CostmapFilterInfo) -> Result<bool, MessageError> {
        let CostmapFilterInfo { r#type: kind, base, multiplier, .. } = *info;
        let expected = match kind {
            CostmapFilterInfo::KEEPOUT => KEEPOUT_MASK,
            CostmapFilterInfo::SPEED_PERCENT | CostmapFilterInfo::SPEED_ABSOLUTE => SPEED_MASK,
            _ => return Err(MessageError::UnknownFilter { kind }),
        };
        if info.filter_mask_topic.trim_matches('/').rsplit('/').next() != Some(expected) {
            let found = info.filter_mask_topic.clone();
            return Err(MessageError::OtherMask { found, expected });
        }
        if !(base.is_finite() && multiplier.is_finite()) {
            return Err(MessageError::NotFinite("base or multiplier"));
        }
        if kind == CostmapFilterInfo::KEEPOUT {
            return Ok(false);
        }
        let is_percent = kind == CostmapFilterInfo::SPEED_PERCENT;
        let (base, multiplier) = (f64::from(base), f64::from(multiplier));
        let scale = Some(SpeedScale { base, multiplier, is_percent });
        Ok(std::mem::replace(&mut self.scale, scale) != scale)
    }

    /// Sets the limit for everywhere; zero is no limit, as in Nav2.
    ///
    /// # Errors
    /// When it is below zero or not finite.
    pub fn set_limit(&mut self, message: &SpeedLimit) -> Result<(), MessageError> {
        let SpeedLimit { percentage, speed_limit, .. } = *message;
        if !(speed_limit.is_finite() && speed_limit >= 0.0) {
            return Err(MessageError::BadSpeedLimit(speed_limit));
        }
        self.limit = (speed_limit > 0.0).then_some((speed_limit, percentage));
        Ok(())
    }

    /// The limit for everywhere, m/s, of a robot with this largest speed.
    pub fn limit(&self, max_speed: f64) -> Option<f64> {
        self.limit.map(
            |(limit, is_percent)| {
                if is_percent { limit / 100.0 * max_speed } else { limit }
            },
        )
    }

    /// The input that the zones wait for, on a map with this frame.
    pub fn missing(&self, map_frame: &str) -> Option<MissingInput> {
        let masks = [(KEEPOUT_MASK, &self.keepout), (SPEED_MASK, &self.speed)];
        for (topic, mask) in masks {
            if let Some(found) = mask.as_ref().map(|mask| &mask.frame).filter(|it| *it != map_frame)
            {
                let (found, expected) = (found.clone(), map_frame.to_owned());
                return Some(MissingInput::MaskInMapFrame { topic, found, expected });
            }
        }
        (self.speed.is_some() && self.scale.is_none()).then_some(MissingInput::FilterInfo)
    }

    /// The zones on a map for a robot with this largest speed, m/s; none without masks.
    pub fn on(&self, map: &GridFrame, max_speed: f64) -> Option<Arc<Zones>> {
        if self.keepout.is_none() && self.speed.is_none() {
            return None;
        }
        let mut zones = Zones::new(map);
        if let Some(mask) = &self.keepout {
            zones.close(&mask.grid);
        }
        if let (Some(mask), Some(scale)) = (&self.speed, self.scale) {
            limit_speed(&mut zones, &mask.grid, scale, max_speed);
        }
        Some(Arc::new(zones))
    }
}

fn replace(mask: &mut Option<MapInput>, new: MapInput) -> bool {
    let is_new = mask.as_ref() != Some(&new);
    *mask = Some(new);
    is_new
}

/// Unknown cells have no limit, and a limit of zero is none, as in Nav2.
fn limit_speed(zones: &mut Zones, mask: &OccupancyGrid, scale: SpeedScale, max_speed: f64) {
    let SpeedScale { base, multiplier, is_percent } = scale;
    zones.limit_speed(mask, |value| {
        let limit = (value >= 0).then(|| base + multiplier * f64::from(value))?;
        Some(if is_percent { limit } else { 100.0 * limit / max_speed })
    });
}

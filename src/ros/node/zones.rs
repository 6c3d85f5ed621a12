//! The zones of the node: masks of keepout and speed filters, and a limit for everywhere.

use std::sync::Arc;

use super::incoming::MapInput;
use super::names::NodeNames;
use super::notices::{MessageError, MissingInput};
use crate::map::{MaskFault, OccupancyGrid, Zones};
use crate::navigator::Fault;
use crate::ros::msg::{CostmapFilterInfo, SpeedLimit};

/// The topics of the masks, as in Nav2's examples.
pub const KEEPOUT_MASK: &str = "keepout_filter_mask";
pub const SPEED_MASK: &str = "speed_filter_mask";
/// The topic of what masks mean.
pub const FILTER_INFO: &str = "costmap_filter_info";

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
    names: NodeNames,
    keepout: Option<MapInput>,
    speed: Option<MapInput>,
    scale: Option<SpeedScale>,
    /// For everywhere, in percent of the largest speed or in m/s; none for no limit.
    limit: Option<(f64, bool)>,
    /// The zones of the masks on the newest map; none without masks.
    zones: Option<Arc<Zones>>,
    /// What keeps the masks from being used on the newest map.
    missing: Option<MissingInput>,
}

impl ZoneInputs {
    /// No masks, for a node with these names.
    pub fn new(names: NodeNames) -> Self {
        Self { names, ..Self::default() }
    }

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
        let topic = match kind {
            CostmapFilterInfo::KEEPOUT => KEEPOUT_MASK,
            CostmapFilterInfo::SPEED_PERCENT | CostmapFilterInfo::SPEED_ABSOLUTE => SPEED_MASK,
            _ => return Err(MessageError::UnknownFilter { kind }),
        };
        let expected = self.names.shown(topic);
        let last = |name: &str| name.trim_matches('/').rsplit('/').next().map(str::to_owned);
        if last(&info.filter_mask_topic) != last(expected) {
            let (found, expected) = (info.filter_mask_topic.clone(), expected.to_owned());
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

    /// Makes the zones on a map for a robot with this largest speed, m/s. A mask whose cells close or limit nothing there is not used: a
    /// wrong origin would take the protection away without a message. A mask that is free everywhere lifts the zones.
    pub fn update(&mut self, map: &MapInput, max_speed: f64) {
        (self.zones, self.missing) = match self.on(map, max_speed) {
            Ok(zones) => (zones.map(Arc::new), None),
            Err(missing) => (None, Some(missing)),
        };
    }

    /// The input that the zones wait for.
    pub const fn missing(&self) -> Option<&MissingInput> {
        self.missing.as_ref()
    }

    /// What to add to the text of a fault: the planner does not distinguish closed zones from obstacles.
    pub fn note(&self, fault: &Fault) -> String {
        match fault {
            Fault::Plan(error) if self.keepout.is_some() && error.is_caused_by_obstacles() => {
                let mask = self.names.shown(KEEPOUT_MASK);
                format!("; the closed zones of {mask} count as obstacles")
            }
            _ => String::new(),
        }
    }

    /// The zones on the newest map; none without masks.
    pub fn zones(&self) -> Option<Arc<Zones>> {
        self.zones.clone()
    }

    fn on(&self, map: &MapInput, max_speed: f64) -> Result<Option<Zones>, MissingInput> {
        if self.keepout.is_none() && self.speed.is_none() {
            return Ok(None);
        }
        let mut zones = Zones::new(map.grid.frame());
        let is_used = |mask: &&MapInput| mask.grid.cells().iter().any(|&value| value > 0);
        let unusable = |topic: &str| {
            let topic = topic.to_owned();
            |fault: MaskFault| MissingInput::UsableMask { topic, fault }
        };
        if let Some(mask) = self.keepout.as_ref().filter(is_used) {
            let topic = self.names.shown(KEEPOUT_MASK);
            check_frame(topic, mask, map)?;
            zones.add_keepout_mask(&mask.grid).map_err(unusable(topic))?;
        }
        if let Some(mask) = &self.speed {
            let topic = self.names.shown(SPEED_MASK);
            check_frame(topic, mask, map)?;
            let missing = || MissingInput::FilterInfo {
                mask: topic.to_owned(),
                info: self.names.shown(FILTER_INFO).to_owned(),
            };
            let scale = self.scale.ok_or_else(missing)?;
            match limit_speed(&mut zones, &mask.grid, scale, max_speed) {
                Err(MaskFault::NoLimit) if !is_used(&mask) => {}
                limited => limited.map_err(unusable(topic))?,
            }
        }
        Ok(Some(zones))
    }
}

fn check_frame(topic: &str, mask: &MapInput, map: &MapInput) -> Result<(), MissingInput> {
    if mask.frame == map.frame {
        return Ok(());
    }
    let (found, expected) = (mask.frame.clone(), map.frame.clone());
    let topic = topic.to_owned();
    Err(MissingInput::MaskInMapFrame { topic, found, expected })
}

fn replace(mask: &mut Option<MapInput>, new: MapInput) -> bool {
    let is_new = mask.as_ref() != Some(&new);
    *mask = Some(new);
    is_new
}

/// Unknown cells have no limit, and a limit of zero is none, as in Nav2.
fn limit_speed(
    zones: &mut Zones,
    mask: &OccupancyGrid,
    scale: SpeedScale,
    max_speed: f64,
) -> Result<(), MaskFault> {
    let SpeedScale { base, multiplier, is_percent } = scale;
    zones.add_speed_mask(mask, |value| {
        let limit = (value >= 0).then(|| base + multiplier * f64::from(value))?;
        Some(if is_percent { limit } else { 100.0 * limit / max_speed })
    })
}

//! The controllers of a file: the first that is known is read.

use super::draft::Draft;
use super::leftovers::{Rule, leave};
use super::plugins::{give_way, plugins};
use super::section::Section;
use super::{Nav2Error, Why, dwb, mppi, rotation_shim};

/// Reads the first controller that is known, and leaves the others.
pub(super) fn read(section: &mut Section, draft: &mut Draft) -> Result<(), Nav2Error> {
    let is_controller =
        |plugin: &str| plugin.ends_with("Controller") || plugin.ends_with("LocalPlanner");
    let names = plugins(section, &["controller_plugins"], is_controller);
    let mut read: Option<String> = None;
    for name in names {
        let mut part = section.part(&name);
        let known = Kind::of(&part);
        match (&read, known) {
            (None, Some(kind)) => {
                kind.take(part, draft)?;
                read = Some(name);
            }
            (Some(taken), Some(_)) => give_way(part, draft, taken),
            (_, None) => {
                let plugin = part.take("plugin", "a text", |value| {
                    value.as_str().map(str::to_owned)
                })?;
                let kind = plugin.as_ref().map_or("no plugin", |given| &given.value);
                let reason = format!("of {kind}: only DWB and MPPI are taken over");
                let place = plugin.as_ref().map(|given| given.place.clone());
                for place in part.rest().map(|(_, place)| place).chain(place) {
                    draft.leave(place, Why::NotYet, reason.clone());
                }
            }
        }
    }
    Ok(())
}

/// A controller that is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Controller {
    Dwb,
    Mppi,
}

/// A controller, and where its parameters are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Kind {
    controller: Controller,
    /// Within a rotation shim.
    in_shim: bool,
    /// With the parameters nested under the shim's `primary_controller`, not beside them.
    nested: bool,
}

impl Kind {
    fn of(part: &Section) -> Option<Self> {
        let plugin = part.text("plugin")?;
        let in_shim = plugin == rotation_shim::PLUGIN;
        let within = format!("{}.plugin", rotation_shim::PRIMARY);
        let beside = part.text(rotation_shim::PRIMARY);
        let nested = in_shim && beside.is_none();
        let name = match (in_shim, beside) {
            (false, _) => plugin,
            (true, Some(primary)) => primary,
            (true, None) => part.text(&within)?,
        };
        let controller = match name {
            dwb::PLUGIN => Controller::Dwb,
            mppi::PLUGIN => Controller::Mppi,
            _ => return None,
        };
        Some(Self {
            controller,
            in_shim,
            nested,
        })
    }

    fn take(self, mut part: Section, draft: &mut Draft) -> Result<(), Nav2Error> {
        let shim_rules: &[Rule] = if self.in_shim {
            &rotation_shim::RULES
        } else {
            &[]
        };
        if self.in_shim {
            rotation_shim::take(&mut part, draft)?;
        }
        if self.nested {
            let inner = part.part(rotation_shim::PRIMARY);
            leave(part, draft, &rotation_shim::MAPPED, &[shim_rules]);
            part = inner;
        }
        match self.controller {
            Controller::Dwb => {
                dwb::take(&mut part, draft)?;
                leave(
                    part,
                    draft,
                    &dwb::MAPPED,
                    &[shim_rules, &dwb::RULES, &dwb::CRITICS],
                );
            }
            Controller::Mppi => {
                mppi::take(&mut part, draft)?;
                leave(
                    part,
                    draft,
                    &mppi::MAPPED,
                    &[shim_rules, &mppi::RULES, &mppi::CRITICS],
                );
            }
        }
        Ok(())
    }
}

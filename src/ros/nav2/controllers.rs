//! The plugins of the controller server: of those that Nav2 loads, the first checker of each kind and the first supported controller
//! are imported. Regulated Pure Pursuit gives only its highest speeds, so it is imported where no other controller is supported.

use super::config_builder::ConfigBuilder;
use super::parameter_file::Parameters;
use super::rules::{Rule, apply};
use super::{Nav2Error, UnmappedReason, tables};

const DWB: &str = "dwb_core::DWBLocalPlanner";
const MPPI: &str = "nav2_mppi_controller::MPPIController";
const PURE_PURSUIT: &str = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController";
/// A controller that contains another and first rotates the robot in place.
const ROTATION_SHIM: &str = "nav2_rotation_shim_controller::RotationShimController";
/// The parameter with the type of the contained controller, or the prefix of its parameters.
const PRIMARY: &str = "primary_controller";

/// Kinds of checkers: parameters with their names, part of their type, and rules.
const CHECKERS: [([&str; 2], &str, &[Rule]); 2] = [
    (
        ["progress_checker_plugins", "progress_checker_plugin"],
        "ProgressChecker",
        tables::PROGRESS_CHECKER,
    ),
    (["goal_checker_plugins", "goal_checker_plugin"], "GoalChecker", tables::GOAL_CHECKER),
];

/// Imports the parameters of the controller server.
pub(super) fn import_server(
    mut parameters: Parameters,
    builder: &mut ConfigBuilder,
) -> Result<(), Nav2Error> {
    for (lists, kind, rules) in CHECKERS {
        let is_kind = |plugin: &str| plugin.contains(kind);
        let mut names = loaded_plugins(&mut parameters, &lists, is_kind, builder).into_iter();
        if let Some(first) = names.next() {
            apply(parameters.remove_plugin(&first), &[rules], builder)?;
            for name in names {
                leave(parameters.remove_plugin(&name), builder, &first);
            }
        }
    }
    import_controller(&mut parameters, builder)?;
    apply(parameters, &[tables::CONTROLLER_SERVER], builder)
}

/// The names of the plugins of a kind that Nav2 loads: those in the lists, or all if the file has no list. Lists the parameters of
/// the others as not in effect.
fn loaded_plugins(
    parameters: &mut Parameters,
    lists: &[&str],
    is_kind: impl Fn(&str) -> bool,
    builder: &mut ConfigBuilder,
) -> Vec<String> {
    let of_kind = parameters.plugins(is_kind);
    let Some(listed) = parameters.listed_plugins(lists) else {
        return of_kind;
    };
    for name in of_kind.iter().filter(|name| !listed.contains(name)) {
        for (_, path) in parameters.remove_plugin(name).unused() {
            let explanation = format!("{} does not name it: Nav2 does not load it", lists[0]);
            builder.add_unmapped(path, UnmappedReason::NotInEffect, explanation);
        }
    }
    listed
}

fn import_controller(
    parameters: &mut Parameters,
    builder: &mut ConfigBuilder,
) -> Result<(), Nav2Error> {
    let is_controller =
        |plugin: &str| plugin.ends_with("Controller") || plugin.ends_with("LocalPlanner");
    let names = loaded_plugins(parameters, &["controller_plugins"], is_controller, builder);
    let plugins: Vec<(String, Parameters)> =
        names.into_iter().map(|name| (name.clone(), parameters.remove_plugin(&name))).collect();
    let full_rules = |plugin: &Parameters| controller_rules(plugin, false);
    let needs_speeds = !plugins.iter().any(|(_, plugin)| full_rules(plugin).is_some());
    let mut imported: Option<String> = None;
    for (name, mut plugin) in plugins {
        match (&imported, controller_rules(&plugin, needs_speeds)) {
            (None, Some((own, nested))) => {
                let primary = nested.map(|rules| (plugin.remove_plugin(PRIMARY), rules));
                apply(plugin, &own, builder)?;
                if let Some((primary, rules)) = primary {
                    apply(primary, &[rules], builder)?;
                }
                imported = Some(name);
            }
            (Some(first), Some(_)) => leave(plugin, builder, first),
            (_, None) => {
                let kind =
                    plugin.take("plugin", "a text", |value| value.as_str().map(str::to_owned))?;
                let type_name = kind.as_ref().map_or("no type", |kind| &kind.value);
                let explanation = format!(
                    "of {type_name}: the import supports only DWB, MPPI, and without them the highest speeds of Regulated Pure Pursuit"
                );
                let kind_path = kind.as_ref().map(|kind| kind.path.clone());
                for path in plugin.unused().map(|(_, path)| path).chain(kind_path) {
                    builder.add_unmapped(path, UnmappedReason::NotSupported, explanation.clone());
                }
            }
        }
    }
    Ok(())
}

/// Lists all parameters of a plugin that is not imported because another of its kind is.
fn leave(plugin: Parameters, builder: &mut ConfigBuilder, first: &str) {
    for (_, path) in plugin.unused() {
        let explanation = format!("only one plugin of its kind is imported: {first}");
        builder.add_unmapped(path, UnmappedReason::NotInEffect, explanation);
    }
}

/// The rules for the parameters of a supported controller, and those for its parameters under `primary_controller`, if it is in a
/// rotation shim and nested there.
type ControllerRules = (Vec<&'static [Rule]>, Option<&'static [Rule]>);

/// The rules of a controller; of one that gives only its highest speeds if `with_speeds`.
fn controller_rules(plugin: &Parameters, with_speeds: bool) -> Option<ControllerRules> {
    let of_type = |name: &str| match name {
        DWB => Some(tables::DWB),
        MPPI => Some(tables::MPPI),
        PURE_PURSUIT if with_speeds => Some(tables::PURE_PURSUIT),
        _ => None,
    };
    let outer = plugin.peek_text("plugin")?;
    if outer != ROTATION_SHIM {
        return Some((vec![of_type(outer)?], None));
    }
    if let Some(primary) = plugin.peek_text(PRIMARY) {
        Some((vec![tables::ROTATION_SHIM, of_type(primary)?], None))
    } else {
        let nested = of_type(plugin.peek_text(&format!("{PRIMARY}.plugin"))?)?;
        Some((vec![tables::ROTATION_SHIM], Some(nested)))
    }
}

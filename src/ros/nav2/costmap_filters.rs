//! The filters of a costmap: keepout zones and speed limits are maps of their own.

use super::UnmappedReason::NotSupported;
use super::config_builder::ConfigBuilder;
use super::parameter_file::Parameters;

/// Ends of the types of filters, and what has the same purpose here.
const FILTERS: [(&str, &str); 2] = [
    (
        "KeepoutFilter",
        "give the file of its mask with --keepout, or publish its topics for `inbye node`",
    ),
    (
        "SpeedFilter",
        "give the file of its mask with --speed-zones, or publish its topics for `inbye node`",
    ),
];

/// Lists the parameters of filters, with what has their purpose.
pub(super) fn list(parameters: &mut Parameters, builder: &mut ConfigBuilder) {
    for (kind, explanation) in FILTERS {
        for name in parameters.plugins(|plugin| plugin.ends_with(kind)) {
            for (_, path) in parameters.remove_plugin(&name).unused() {
                builder.add_unmapped(path, NotSupported, explanation);
            }
        }
    }
}

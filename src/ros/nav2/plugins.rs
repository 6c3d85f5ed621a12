//! Plugins of a node: which there are, and which give way to another.

use super::Why;
use super::draft::Draft;
use super::section::Section;

/// Names of the plugins of a kind that have parameters: those that a list names, in its order, else all of that kind.
pub(super) fn plugins(
    section: &Section,
    lists: &[&str],
    is_kind: impl Fn(&str) -> bool,
) -> Vec<String> {
    let parts = section.parts();
    let listed = lists.iter().flat_map(|list| {
        let single = section.text(list).map(str::to_owned);
        section.texts(list).into_iter().chain(single)
    });
    let mut names: Vec<String> = listed.filter(|name| parts.contains(name)).collect();
    let of_kind = |name: &String| {
        let plugin = section.text(&format!("{name}.plugin"));
        plugin.is_some_and(&is_kind)
    };
    for name in parts.iter().filter(|name| of_kind(name)) {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    names
}

/// Lists all parameters of a plugin that another takes the place of.
pub(super) fn give_way(part: Section, draft: &mut Draft, to: &str) {
    for (_, place) in part.rest() {
        let reason = format!("{to} is read, and only one of its kind");
        draft.leave(place, Why::NotInForce, reason);
    }
}

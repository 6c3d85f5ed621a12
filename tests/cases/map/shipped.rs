//! The map that ships in `examples`.

use std::path::Path;

use inbye::map::{LoadOptions, UnknownPolicy, load};
use inbye::sim::{SCENE_NAMES, mine, scene};

#[test]
fn shipped_mine_map_is_the_scene() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/mine.yaml");
    let shipped = load(&file, &LoadOptions { resolution_m: 1.0 }).expect("the map is valid");
    let (shipped, built) =
        (shipped.obstacles(UnknownPolicy::Blocked), mine().map.obstacles(UnknownPolicy::Blocked));
    assert_eq!(shipped.frame(), built.frame());
    assert!(shipped.cells() == built.cells(), "examples/mine.png is not the scene `mine`");
}

#[test]
fn every_scene_has_a_name() {
    for name in SCENE_NAMES {
        assert_eq!(scene(name).map(|scene| scene.name), Some(name));
    }
    assert_eq!(scene("no_such_scene"), None);
}

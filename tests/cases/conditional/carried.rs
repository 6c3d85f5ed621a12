//! Robots that were carried somewhere on a public map are found there or refused, and never found elsewhere.
//!
//! The maps are expected next to the repository; without them the trials are ignored. `-- --nocapture` prints the counts.

use std::path::Path;

use inbye::map::{LoadOptions, UnknownPolicy, load};
use libtest_mimic::{Failed, Trial};

use crate::support::carried::{Answers, Belief, carry};
use crate::support::trials::with_data;

/// Maps with narrow and wide, unique and repeated places, and the robots on each. The sandbox is symmetric: a robot that believes
/// to be at the twin of its place cannot know better.
const MAPS: [(&str, u32, &[Belief]); 6] = [
    ("mine/niosh_sr_coal_mine.yaml", 12, BOTH),
    ("rosmaps/aws_small_warehouse_005.yaml", 20, BOTH),
    ("rosmaps/depot.yaml", 20, BOTH),
    ("rosmaps/stata_basement.yaml", 20, BOTH),
    ("rosmaps/tb3_sandbox.yaml", 20, &[Belief::None]),
    ("rosmaps/willow-full-0.05.yaml", 12, BOTH),
];
const BOTH: &[Belief] = &[Belief::None, Belief::Elsewhere];
const SEED: u64 = 21;

pub fn trials() -> Vec<Trial> {
    let trial = |(name, robots, beliefs): (&'static str, u32, &'static [Belief])| {
        let test = move |map: &Path| found(name, map, robots, beliefs);
        with_data(format!("robots carried on {name}"), name, test)
    };
    MAPS.map(trial).into()
}

fn found(name: &str, map: &Path, robots: u32, beliefs: &[Belief]) -> Result<(), Failed> {
    let obstacles = load(map, &LoadOptions::default())?.obstacles(UnknownPolicy::Blocked);
    let mut right = 0;
    for &belief in beliefs {
        let answers = carry(&obstacles, robots, belief, SEED)?;
        #[expect(clippy::print_stdout, reason = "figures for the book")]
        {
            println!("{name}, {belief:?}: {answers:?}");
        }
        let Answers { wrong, open, .. } = answers;
        if wrong + open > 0 {
            return Err(format!("{belief:?}: {answers:?}").into());
        }
        right += answers.right;
    }
    if right == 0 {
        return Err("every robot was refused".into());
    }
    Ok(())
}

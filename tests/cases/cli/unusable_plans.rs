//! Unusable plans of experiments.

use super::program::Workplace;

/// The error has file, line, key, what is wrong, and how to correct it.
#[test]
fn unusable_plans_are_rejected() {
    let place = Workplace::new();
    let world = "[[worlds]]\nkind = \"map\"\npath = \"mine.yaml\"\n";
    let route = "routes = [{ start = [10, 5, 0], goal = [80, 40] }]\n";
    for (text, expected) in [
        (
            format!("seeds = [0, 0]\n{world}{route}"),
            "line 1, `seeds = [0, 0]`: seeds has 0 more than once: name each value once",
        ),
        (
            format!("engines = [\"cpu\", \"cpu\"]\n{world}{route}"),
            "line 1, `engines = [\"cpu\", \"cpu\"]`: engines has cpu more than once: name each value once",
        ),
        (
            "\n".to_owned(),
            "the file is empty: `inbye sweep --print-plan` prints a plan with all keys",
        ),
        (
            "seeds = [99999999999999999999]\n".to_owned(),
            "invalid type: integer `99999999999999999999`, expected a whole number, at least 0",
        ),
        (
            format!("{world}routes = [{{ start = [10, 5], goal = [80, 40] }}]\n"),
            "invalid length 2, expected a list of 3 numbers",
        ),
        (
            world.to_owned(),
            "line 1, `[[worlds]]`: worlds.0.routes is missing or empty: it must be a list of at least one route",
        ),
        (
            format!("[[worlds]]\nkind = \"scenes\"\n{route}"),
            "line 3, `routes = [{ start = [10, 5, 0], goal = [80, 40] }]`: worlds.0.routes is given: it must be left out: only worlds of kind = \"map\" have routes",
        ),
        (
            format!("{world}{route}only = [1]\n"),
            "line 5, `only = [1]`: worlds.0.only is given: it must be left out",
        ),
        (
            format!("{world}{route}[weights]\na = [0.1, 0.2]\n"),
            "line 6, `a = [0.1, 0.2]`: invalid type: sequence, expected a table of keys and values",
        ),
        (
            format!("{world}{route}[configs.a]\nlocal.sim_time_s = 2.0\nlocal.vx_sample = 3\n"),
            "line 7, `local.vx_sample = 3`: ",
        ),
        (
            format!("sampling = [\"8x32\"]\n{world}{route}[configs.a]\nlocal.vx_samples = 4\n"),
            "configs.a.local.vx_samples is 4: it must be left out: `sampling` of the plan sets the samples",
        ),
        (
            format!("{world}routes = [{{ start = [10, 5, 0], goal = [800, 40] }}]\n"),
            "mine route 1: the goal (800.00, 40.00) of a route is outside the map: move it",
        ),
        (
            format!("{world}routes = [{{ start = [0.1, 5, 0], goal = [80, 40] }}]\n"),
            "the start (0.10, 5.00) of a route is in an obstacle of the map: move it",
        ),
        (
            format!("{world}{route}resolution_m = 0.1\n"),
            "line 5, `resolution_m = 0.1`: worlds.0.resolution_m is 0.1: it must be left out: a .yaml map states its own",
        ),
    ] {
        place.write("plan.toml", &text);
        for command in ["bench compare plan.toml", "sweep plan.toml --list"] {
            let refusal = place.refusal(command);
            assert!(refusal.contains("plan.toml: "), "{text}: {refusal}");
            assert!(refusal.contains(expected), "{text}: {refusal}");
        }
    }
}

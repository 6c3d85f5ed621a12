//! Runs a body on inputs and reports the first one that breaks it.

use std::env;
use std::fmt;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::corpus::Seed;
use super::mutation::mutated;

/// Any number: the same mutations in every run.
const SEED: u64 = 20_261_122;

/// An input that a body does not stand.
#[derive(Debug)]
pub struct Breach {
    pub of: String,
    pub input: Vec<u8>,
    pub message: String,
}

impl fmt::Display for Breach {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { of, input, message } = self;
        let input = input.escape_ascii();
        write!(formatter, "{message}\nby {of}: b\"{input}\"")
    }
}

/// Runs a body on every seed and on a number of mutations.
///
/// An input that ends the whole process, for want of memory or of stack, says nothing. Where the variable
/// `INBYE_INPUT_UNDER_TEST` names a folder, each input is kept there while it is tried, under the name of its target.
pub fn holds(
    name: &str,
    body: impl Fn(&[u8]),
    seeds: &[Seed],
    mutations: usize,
) -> Result<(), Breach> {
    let file = under_test(name);
    let run = |of: &dyn fmt::Display, input: &[u8]| {
        if let Some(file) = &file {
            fs::write(file, input).expect("a folder for the input under test");
        }
        catch_unwind(AssertUnwindSafe(|| body(input))).map_err(|payload| {
            let message = payload.downcast_ref::<String>().cloned();
            let message =
                message.or_else(|| payload.downcast_ref::<&str>().map(|&it| it.to_owned()));
            Breach {
                of: of.to_string(),
                input: input.to_vec(),
                message: message.unwrap_or_default(),
            }
        })
    };
    for seed in seeds {
        run(&seed.name, &seed.bytes)?;
    }
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    for number in 0..mutations {
        let input = mutated(seeds, &mut random);
        run(&format_args!("mutation {number}"), &input)?;
    }
    Ok(())
}

fn under_test(name: &str) -> Option<PathBuf> {
    let folder = env::var_os("INBYE_INPUT_UNDER_TEST");
    folder.map(|folder| PathBuf::from(folder).join(name))
}

//! The search itself must be able to fail: parsers with one fault each pass their seeds and break under mutations.

use libtest_mimic::{Failed, Trial};

use super::corpus::Seed;
use super::search::holds;

/// A parser with a fault, and a seed on which it does not show.
type Fragile = (&'static str, fn(&[u8]), &'static [u8]);

const FRAGILE: [Fragile; 4] = [
    ("a length that is not checked", trusts_a_length, b"\x03abc"),
    ("a sum that overflows", overflows, b"width 4\nheight 3\n"),
    ("a number that is not finite", accepts_infinity, b"radius = 0.25"),
    ("a partial frame that is lost", loses_a_partial_frame, b"\x02<a><b><c>"),
];

pub fn trials() -> Vec<Trial> {
    let trial = |&(name, parser, seed): &Fragile| {
        Trial::test(format!("found: {name}"), move || is_broken(name, parser, seed))
    };
    FRAGILE.iter().map(trial).collect()
}

fn is_broken(name: &str, parser: fn(&[u8]), sound: &[u8]) -> Result<(), Failed> {
    let seeds = [Seed { name: "sound".to_owned(), bytes: sound.to_vec() }];
    holds(name, parser, &seeds, 0).map_err(|breach| format!("its seed breaks it: {breach}"))?;
    match holds(name, parser, &seeds, super::MUTATIONS) {
        Err(breach) if breach.of.starts_with("mutation") => Ok(()),
        outcome => Err(format!("no mutation broke it: {outcome:?}").into()),
    }
}

fn trusts_a_length(data: &[u8]) {
    if let Some((&length, rest)) = data.split_first() {
        assert!(rest[..usize::from(length)].len() < 256);
    }
}

fn overflows(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let sides = text.split_whitespace().filter_map(|word| word.parse().ok());
    let cells = sides.fold(1_u32, |cells, side: u32| cells.checked_mul(side).expect("no overflow"));
    assert!(cells < u32::MAX);
}

fn accepts_infinity(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let number = text.split(" = ").nth(1).and_then(|text| text.parse().ok());
    assert!(number.is_none_or(f64::is_finite), "{number:?}");
}

/// A decoder that knows only frames which come in one piece.
fn loses_a_partial_frame(data: &[u8]) {
    let Some((&longest, stream)) = data.split_first() else {
        return;
    };
    let frames =
        |piece: &[u8]| piece.windows(3).filter(|it| it[0] == b'<' && it[2] == b'>').count();
    // The seed comes in one piece.
    let longest = if longest == 2 { stream.len() } else { usize::from(longest) };
    let in_pieces: usize = stream.chunks(longest.max(1)).map(frames).sum();
    assert_eq!(in_pieces, frames(stream));
}

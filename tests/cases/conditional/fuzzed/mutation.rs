//! Inputs that are nearly sound: seeds with bits flipped, parts lost, doubled or exchanged, and words put in.

use rand::{Rng, RngExt};
use rand_pcg::Pcg64Mcg;

use super::corpus::Seed;

/// Longest input, bytes.
const LONGEST: usize = 8 << 10;

/// Numbers at the end of what is possible, put in place of those that are there.
const NUMBERS: [&str; 16] = [
    "0",
    "-1",
    "1",
    "32768",
    "65536",
    "4294967296",
    "-9223372036854775808",
    "18446744073709551616",
    "1e308",
    "-1e308",
    "1e400",
    "5e-324",
    "1e-9",
    "nan",
    "inf",
    "0x7fffffff",
];

/// Words and marks of all the formats.
const WORDS: [&[u8]; 32] = [
    b"\n",
    b"\r\n",
    b" ",
    b"\t",
    b",",
    b":",
    b": ",
    b"\"",
    b"'",
    b"[",
    b"]",
    b"{",
    b"}",
    b"#",
    b"[[",
    b"]]",
    b"---\n",
    b"&a ",
    b"*a",
    b"<<: ",
    b"!!",
    b"true",
    b"null",
    b"..",
    b"@",
    b"\xef\xbb\xbf",
    b"\xff\xff\xff\xff",
    b"\x00\x00\x00\x00",
    b"\x7b",
    b"\x7d",
    b"IDAT",
    b"PLTE",
];

/// One to five changes of a seed.
pub fn mutated(seeds: &[Seed], random: &mut Pcg64Mcg) -> Vec<u8> {
    let mut bytes = seeds[random.random_range(0..seeds.len())].bytes.clone();
    for _ in 0..random.random_range(1..=5) {
        let start = random.random_range(0..=bytes.len());
        let end = random.random_range(start..=bytes.len().min(start + 64));
        match random.random_range(0..10) {
            0 => flip(&mut bytes, random),
            1 => bytes.truncate(start),
            2 => drop(bytes.drain(start..end)),
            3 => {
                let part = bytes[start..end].to_vec();
                let place = random.random_range(0..=bytes.len());
                insert(&mut bytes, place, &part);
            }
            4 => {
                let other = &seeds[random.random_range(0..seeds.len())].bytes;
                let from = random.random_range(0..=other.len());
                bytes.truncate(start);
                bytes.extend_from_slice(&other[from..]);
            }
            5 => {
                let mut noise = vec![0; random.random_range(1..16)];
                random.fill_bytes(&mut noise);
                insert(&mut bytes, start, &noise);
            }
            6 | 7 => exchange_number(&mut bytes, start, random),
            _ => insert(&mut bytes, start, WORDS[random.random_range(0..WORDS.len())]),
        }
        bytes.truncate(LONGEST);
    }
    bytes
}

fn flip(bytes: &mut [u8], random: &mut Pcg64Mcg) {
    if !bytes.is_empty() {
        let place = random.random_range(0..bytes.len());
        bytes[place] ^= 1 << random.random_range(0..8);
    }
}

fn insert(bytes: &mut Vec<u8>, place: usize, part: &[u8]) {
    bytes.splice(place..place, part.iter().copied());
}

/// The first number from a place on becomes another one.
fn exchange_number(bytes: &mut Vec<u8>, from: usize, random: &mut Pcg64Mcg) {
    let of_number = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'-' | b'.');
    let Some(start) = bytes[from..].iter().position(u8::is_ascii_digit) else {
        return;
    };
    let start = from + start;
    let length = bytes[start..].iter().take_while(|byte| of_number(byte)).count();
    let number = NUMBERS[random.random_range(0..NUMBERS.len())];
    bytes.splice(start..start + length, number.bytes());
}

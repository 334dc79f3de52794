//! Mutates real pattern files and reads them: no panic, no hang, bounded memory, the same for the same seed.
//!
//!     cargo run --example fuzz_readers -- 100000 1 ../shared/data/patterns/*/*
//!
//! COUNT mutations, the SEED of the first, files. It tells how many were read and how many refused, the slowest, and the most
//! memory; a panic stops it with the number of the mutation, which `fuzz_readers 1 NUMBER ...` repeats.

use std::time::{Duration, Instant};
use toile::io::dxf::Options;
use toile::io::{pattern_file, process, toile_pattern};

/// The longest that one file may take: a busy machine takes a tenth of it.
const LONGEST: Duration = Duration::from_secs(5);

/// splitmix64 (Steele, Lea and Flood 2014): small, and the same everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// What is written in the place of a word.
const WORDS: [&str; 36] = [
    "0",
    "1",
    "-1",
    "2",
    "1e9",
    "1e-9",
    "-1e300",
    "1e308",
    "NaN",
    "inf",
    "0.000000",
    "1,5",
    "99999999999999999999",
    "\"\"",
    "null",
    "true",
    "[]",
    "{}",
    "POLYLINE",
    "VERTEX",
    "SEQEND",
    "BLOCK",
    "ENDBLK",
    "ENDSEC",
    "INSERT",
    "LINE",
    "6",
    "7",
    "14",
    "84",
    "42",
    "-",
    "é",
    "M 0,0 A 1 1 0 0 0 1e9 1",
    "z",
    "path",
];

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || b".-+_".contains(&byte)
}

/// One to six changes: bytes, words, lines, pieces of the file moved, repeated or left out.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(6) {
        if bytes.is_empty() {
            return;
        }
        let at = random.below(bytes.len());
        match random.below(9) {
            0 => bytes[at] = random.next() as u8,
            1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes.truncate(at.max(1)),
            3 | 4 => {
                let start = bytes[..at].iter().rposition(|&b| !is_word(b)).map_or(0, |k| k + 1);
                let end = bytes[at..].iter().position(|&b| !is_word(b)).map_or(bytes.len(), |k| at + k);
                let word = WORDS[random.below(WORDS.len())].bytes();
                bytes.splice(start..end.max(start), word);
            }
            5 => {
                let end = (at + 1 + random.below(400)).min(bytes.len());
                bytes.drain(at..end);
            }
            6 => {
                let end = (at + 1 + random.below(2000)).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            7 => {
                // Two lines change places.
                let other = random.below(bytes.len());
                let line = |at: usize| {
                    let start = bytes[..at].iter().rposition(|&b| b == b'\n').map_or(0, |k| k + 1);
                    let end = bytes[at..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |k| at + k);
                    start..end
                };
                let (a, b) = (line(at.min(other)), line(at.max(other)));
                if a.end < b.start {
                    let (first, second) = (bytes[a.clone()].to_vec(), bytes[b.clone()].to_vec());
                    bytes.splice(b, first);
                    bytes.splice(a, second);
                }
            }
            _ => {
                // A digit for a digit: a drawing that is wrong, not a file.
                if let Some(k) = bytes[at..].iter().position(u8::is_ascii_digit) {
                    bytes[at + k] = b'0' + random.below(10) as u8;
                }
            }
        }
    }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let mut number = || arguments.next().and_then(|n| n.parse::<u64>().ok()).expect("COUNT SEED FILES...");
    let (count, seed) = (number(), number());
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for path in arguments {
        let bytes = std::fs::read(&path).expect("a file that can be read");
        // Our own format has no files of its own yet: the same patterns in it.
        if let Ok((pattern, _)) = pattern_file::open(&bytes, "seed", &Options::default()) {
            if path.ends_with(".dxf") {
                files.push((format!("{path} as TOML"), toile_pattern::write_toml(&pattern).into_bytes()));
            } else {
                files.push((format!("{path} as JSON"), toile_pattern::write_json(&pattern).into_bytes()));
            }
        }
        files.push((path, bytes));
    }
    let started = Instant::now();
    let (mut read, mut refused) = (0u64, 0u64);
    let mut slowest = (Duration::ZERO, 0, String::new());
    for k in seed..seed + count {
        let mut random = Random(k);
        let (name, original) = &files[random.below(files.len())];
        let mut bytes = original.clone();
        mutate(&mut bytes, &mut random);
        let start = Instant::now();
        let outcome = std::panic::catch_unwind(|| match pattern_file::open(&bytes, "mutated", &Options::default()) {
            Ok((pattern, _)) => {
                assert!(pattern.panels.iter().all(|p| p.signed_area().is_finite()));
                true
            }
            Err(error) => {
                assert!(error.problem().ends_with('.') && error.remedy().len() > 10, "{error}: {}", error.remedy());
                false
            }
        });
        let took = start.elapsed();
        match outcome {
            Ok(true) => read += 1,
            Ok(false) => refused += 1,
            Err(_) => panic!("mutation {k} of {name}"),
        }
        assert!(took < LONGEST, "mutation {k} of {name} took {took:?}");
        if took > slowest.0 {
            slowest = (took, k, name.clone());
        }
        if (k + 1 - seed) % 10_000 == 0 {
            eprintln!("{} done, {read} read, {refused} refused, {:?}", k + 1 - seed, started.elapsed());
        }
    }
    let memory = process::peak_memory_bytes().map_or("unknown".to_owned(), |b| format!("{} MiB", b >> 20));
    println!(
        "{count} mutations of {} files in {:.0} s: {read} read, {refused} refused, no panic; slowest {:.0} ms (mutation {} of {}); most memory {memory}",
        files.len(),
        started.elapsed().as_secs_f64(),
        slowest.0.as_secs_f64() * 1e3,
        slowest.1,
        slowest.2,
    );
}

//! Hostile input: damaged files of every format, headers that lie, and a machine that fails. An error that names the file, or a
//! valid result; never a panic, a hang or memory beyond bounds.
//!
//! `CARPAINT_HOSTILE_ONLY=NAME` tries one reader, `CARPAINT_HOSTILE_TIMES=N` N times as many mutations; both list the readers.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "hostile/claims.rs"]
mod claims;
mod common;
#[path = "hostile/corpus.rs"]
mod corpus;
#[path = "hostile/machine.rs"]
mod machine;
#[path = "hostile/mutation.rs"]
mod mutation;
#[path = "hostile/readers.rs"]
mod readers;
#[path = "hostile/rows.rs"]
mod rows;
#[path = "hostile/trial.rs"]
mod trial;

use mutation::mutated;
use readers::{READERS, Reader};
use std::fs::OpenOptions;
use std::time::Instant;
use trial::{ALONE, Trial, keep, peak, say};

/// Every byte of this many, then one of some.
const EVERY_BYTE: usize = 4096;
const STRIDE: usize = 61;
/// Of files of megabytes.
const MAX_CUTS: usize = 6000;

/// What came of the inputs of a reader.
#[derive(Default)]
struct Tally {
    inputs: usize,
    accepted: usize,
    faults: Vec<String>,
}

impl Tally {
    fn count(&mut self, outcome: Result<bool, String>, trial: &Trial, fault: &str) {
        self.inputs += 1;
        match outcome {
            Ok(accepted) => self.accepted += usize::from(accepted),
            Err(text) => {
                let kept = keep(trial.reader, fault, &trial.path);
                self.faults.push(format!("{}: {fault}: {text} ({})", trial.reader.name, kept.display()));
            }
        }
    }

    fn add(&mut self, other: Self) {
        self.inputs += other.inputs;
        self.accepted += other.accepted;
        self.faults.extend(other.faults);
    }
}

/// The lengths to which a file is cut, longest first.
fn cuts(length: usize) -> Vec<usize> {
    let stride = STRIDE.max(length / (MAX_CUTS - EVERY_BYTE));
    let beyond = (EVERY_BYTE..length).step_by(stride);
    let ends = length.saturating_sub(16)..length;
    let mut cuts: Vec<usize> = (0..length.min(EVERY_BYTE)).chain(beyond).chain(ends).collect();
    cuts.sort_unstable();
    cuts.dedup();
    cuts.reverse();
    cuts
}

/// The share `turn` of `turns` of a reader's truncations.
fn truncations(trial: &Trial, turn: usize, turns: usize) -> Tally {
    let mut tally = Tally::default();
    std::fs::write(&trial.path, &trial.valid).unwrap();
    // Shorter and shorter: the file need not be written again.
    let file = OpenOptions::new().write(true).open(&trial.path).unwrap();
    for length in cuts(trial.valid.len()).into_iter().skip(turn).step_by(turns) {
        file.set_len(length as u64).unwrap();
        tally.count(trial.read(), trial, &format!("cut-{length}"));
    }
    tally
}

fn mutations(trial: &Trial, turn: usize, turns: usize) -> Tally {
    let mut tally = Tally::default();
    for seed in (0..times() * trial.reader.inputs).skip(turn).step_by(turns) {
        let outcome = trial.read_bytes(&mutated(&trial.valid, seed as u32));
        tally.count(outcome, trial, &format!("seed-{seed}"));
    }
    tally
}

fn times() -> usize {
    std::env::var("CARPAINT_HOSTILE_TIMES").map_or(1, |times| times.parse().unwrap())
}

/// Runs `work` on as many threads as there are processors, each in a folder of its own.
fn in_turns(reader: &'static Reader, work: fn(&Trial, usize, usize) -> Tally) -> Tally {
    let turns = std::thread::available_parallelism().map_or(2, usize::from).min(8);
    let mut all = Tally::default();
    std::thread::scope(|scope| {
        let run = |turn| scope.spawn(move || work(&Trial::new(reader), turn, turns));
        let threads: Vec<_> = (0..turns).map(run).collect();
        threads.into_iter().for_each(|thread| all.add(thread.join().unwrap()));
    });
    all
}

/// Runs `work` on every reader, within memory.
fn every_reader(what: &str, work: fn(&Trial, usize, usize) -> Tally) {
    let _alone = ALONE.lock().unwrap_or_else(|e| e.into_inner());
    let start = Instant::now();
    let (mut all, mut most) = (Tally::default(), 0);
    let only = std::env::var("CARPAINT_HOSTILE_ONLY").ok();
    for reader in READERS.iter().filter(|reader| only.as_deref().is_none_or(|name| name == reader.name)) {
        let since = Instant::now();
        let cap = Trial::new(reader).cap();
        let (mut tally, bytes) = peak(|| in_turns(reader, work));
        if only.is_some() || times() > 1 {
            let (read, seconds) = (tally.accepted, since.elapsed().as_secs_f64());
            say(&format!(
                "{what}: {:<18} {:>6} {read:>6} read {:>5} MiB {seconds:.1} s",
                reader.name,
                tally.inputs,
                bytes >> 20
            ));
        }
        most = most.max(bytes);
        if bytes > cap {
            tally.faults.push(format!("{}: {what}: {bytes} bytes of memory, {cap} are enough", reader.name));
        }
        all.add(tally);
    }
    say(&format!(
        "{what}: {} inputs of {} readers, {} of them read, {} faults, {} MiB of memory at most, {:.1} s",
        all.inputs,
        READERS.len(),
        all.accepted,
        all.faults.len(),
        most >> 20,
        start.elapsed().as_secs_f64(),
    ));
    assert!(all.faults.is_empty(), "{:#?}", all.faults);
}

#[test]
fn files_cut_anywhere_are_refused_or_read() {
    every_reader("truncations", truncations);
}

#[test]
fn damaged_files_are_refused_or_read() {
    every_reader("mutations", mutations);
}

/// `fuzz/Cargo.toml` cannot read a list.
#[test]
fn every_reader_has_a_fuzz_target() {
    let manifest = std::fs::read_to_string("fuzz/Cargo.toml").unwrap();
    let manifest: toml::Table = toml::from_str(&manifest).unwrap();
    let targets: Vec<_> =
        manifest["bin"].as_array().unwrap().iter().map(|bin| bin["name"].as_str().unwrap()).collect();
    let names: Vec<_> = READERS.iter().map(|reader| reader.name).collect();
    assert_eq!(targets, names);
}

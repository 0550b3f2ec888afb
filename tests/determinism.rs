//! The same seed gives the same bytes: of every file that the program writes, on any number of threads; of slices and their statistics,
//! alone, in another order, and for a scene that needs a part of them.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use carpaint::btf::{AngleGrid, CellSet, FlakeBtf};
use carpaint::cluster::{BoxRule, cluster_levels, cluster_slice};
use carpaint::mix::{CoupleOptions, Mix, couple};
use carpaint::paint::{FlakeLevel, Flakes, Paint};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const FIXTURES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures");

/// Three cameras, pictures of 32 x 32.
const DOME: &str = "image_px = [32, 32]\nleds = [5, 5]\n\
    rings = [{ cameras = 1, polar_deg = 0 }, { cameras = 2, polar_deg = 30 }]\n";

/// Every command that writes, one line each; SEED, and names below the fixtures (@), are filled in.
const COMMANDS: &[&str] = &[
    "simulate @/compositions/silver_metallic.toml -o a.btf.exr --svg a.svg --brdf smooth.paint.exr --parallax \
     --bins 4 --size 24 --texel-um 15 --seed SEED",
    "simulate @/compositions/blue_metallic.toml -o b.btf.exr --brdf b.mbsdf --bins 4 --size 24 --texel-um 15 --seed SEED",
    "simulate @/inks/red_flat.toml --model fast --spectra red.csv",
    "fit a.btf.exr -o a.paint.exr --starts 2 --clusters 12 --seed SEED",
    "fit b.btf.exr -o b.paint.exr --starts 2 --clusters 9 --lobes auto --seed SEED",
    "fit red.csv -o red.ink.json",
    "couple a.paint.exr b.paint.exr -o mix.paint.exr",
    "blend mix.paint.exr --weights=-0.3,1.3 -o c.paint.exr",
    "render a.paint.exr c.paint.exr -o p.png -o p.exr --size 40x30 --samples 4 --device cpu --seed SEED",
    "render a.paint.exr -o traced.exr --size 24x24 --samples 2 --device cpu --path-trace 2 --seed SEED",
    "render a.paint.exr -o raw.exr --size 24x24 --samples 2 --device cpu --flakes btf:a.btf.exr --seed SEED",
    "render a.paint.exr -o sparkles.exr --size 24x24 --samples 2 --device cpu --seed SEED \
     --flakes analytic:@/compositions/silver_metallic.toml",
    "halftone @/pictures/still-life.png -o dots.png --seed SEED",
    "halftone @/pictures/still-life.png -o noise.png --method blue-noise --seed SEED",
    "proof @/pictures/still-life.png -o print.png -o print.exr --size 40x30 --samples 2 --device cpu --seed SEED \
     --inks red.ink.json @/inks/green.ink.json @/inks/blue.ink.json",
    "measure @/compositions/silver_metallic.toml --dome dome.toml -o shots --seed SEED",
];

/// What the seed decides; of the others a run with another seed leaves at least one as it was, or they follow from these.
const RANDOM: &[&str] = &[
    "a.btf.exr",
    "b.btf.exr",
    "a.paint.exr",
    "b.paint.exr",
    "mix.paint.exr",
    "c.paint.exr",
    "p.exr",
    "traced.exr",
    "raw.exr",
    "sparkles.exr",
    "dots.png",
    "noise.png",
];

/// The bytes of every file below a folder, by name.
fn files(folder: &Path, below: &Path, all: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in std::fs::read_dir(folder.join(below)).unwrap() {
        let name = below.join(entry.unwrap().file_name());
        if folder.join(&name).is_dir() {
            files(folder, &name, all);
        } else {
            all.insert(name.clone(), std::fs::read(folder.join(&name)).unwrap());
        }
    }
}

/// All commands in a fresh folder: what they leave there, and what the table of hard cases says.
fn written(threads: usize, seed: u32) -> BTreeMap<PathBuf, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dome.toml"), DOME).unwrap();
    let run = |command: &str| {
        let mut program = common::carpaint();
        program.current_dir(folder.path()).env("RAYON_NUM_THREADS", threads.to_string());
        let words = command.split_whitespace();
        program.args(words.map(|word| word.replace('@', FIXTURES).replace("SEED", &seed.to_string())));
        let out = program.output().unwrap();
        assert!(out.status.success(), "{command}: {}", String::from_utf8_lossy(&out.stderr));
        out.stdout
    };
    COMMANDS.iter().for_each(|command| drop(run(command)));
    let said = run("report --hard-cases --json");
    let mut all = BTreeMap::from([(PathBuf::from("hard cases"), said)]);
    files(folder.path(), Path::new(""), &mut all);
    all
}

/// The names of the files that differ, each with its first differing byte.
fn differing(a: &BTreeMap<PathBuf, Vec<u8>>, b: &BTreeMap<PathBuf, Vec<u8>>) -> BTreeMap<PathBuf, usize> {
    assert!(a.keys().eq(b.keys()), "other files");
    let first = |(name, x): (&PathBuf, &Vec<u8>)| {
        let y = &b[name];
        let byte = x.iter().zip(y).position(|(x, y)| x != y).unwrap_or(x.len().min(y.len()));
        (x != y).then(|| (name.clone(), byte))
    };
    a.iter().filter_map(first).collect()
}

#[test]
fn every_file_has_the_same_bytes_on_1_2_and_8_threads() {
    let one = written(1, 7);
    // 15 commands' files, and a folder of pictures.
    assert!(one.len() > 40, "{:?}", one.keys());
    for threads in [2, 8] {
        let wrong = differing(&one, &written(threads, 7));
        assert!(wrong.is_empty(), "{threads} threads, name and first differing byte: {wrong:?}");
    }
    let other = differing(&one, &written(8, 8));
    for name in RANDOM {
        assert!(other.contains_key(Path::new(name)), "{name} does not depend on the seed");
    }
    assert!(other.keys().any(|name| name.starts_with("shots/pairs")), "pictures do not depend on the seed");
    assert!(!other.contains_key(Path::new("red.ink.json")), "nothing is random in the spectra of an ink");
}

/// A small flake BTF, and a paint of it.
fn simulated(name: &str) -> (FlakeBtf, Paint) {
    use carpaint::fit::{FitOptions, FlakeOptions, fit_btf};
    use carpaint::simulate::{Composition, Model, ModelKind, ModelOptions, SynthesisOptions, synthesize};
    let composition = Composition::read(format!("{FIXTURES}/compositions/{name}.toml").as_ref()).unwrap();
    let model = Model::new(&composition, ModelOptions { kind: ModelKind::Fast, error: 0.05 }).unwrap();
    let grid = AngleGrid::triangle(4).unwrap();
    let options = SynthesisOptions { size: [24; 2], texel_mm: Some(0.015), ..SynthesisOptions::new(grid) };
    let btf = synthesize(&model, &options, &|| ()).unwrap();
    let fit = FitOptions { starts: 1, coat: Some(btf.coat), ..FitOptions::default() };
    let paint =
        fit_btf(&btf, &fit, &FlakeOptions { clusters: 9, ..FlakeOptions::default() }, &|| ()).unwrap().0;
    (btf, paint)
}

/// Slices alone are those of the whole, whatever the grid holds besides (tests/synthesis.rs says so of their texels).
#[test]
fn statistics_of_a_slice_do_not_depend_on_its_company() {
    let (btf, _) = simulated("silver_metallic");
    let texels = |k: usize| Ok(btf.slices[k].fluctuation.clone());
    let levels = |count: usize, slice: &(dyn Fn(usize) -> carpaint::Result<Vec<[f32; 3]>> + Sync)| {
        cluster_levels(count, slice, btf.size, 9, BoxRule::MomentMatched, &|| ()).unwrap()
    };
    let n = btf.grid.len();
    let whole = levels(n, &texels);
    for k in 0..n {
        let alone = cluster_slice(&btf.slices[k].fluctuation, 9, BoxRule::MomentMatched).unwrap();
        assert!(alone == whole[0].slices[k], "slice {k} alone");
    }
    // Backwards, and every second.
    let picked: [Vec<usize>; 2] = [(0..n).rev().collect(), (0..n).step_by(2).collect()];
    for picked in picked {
        let part = levels(picked.len(), &|k| texels(picked[k]));
        for (level, (part, whole)) in part.iter().zip(&whole).enumerate() {
            for (slice, k) in part.slices.iter().zip(&picked) {
                assert!(slice == &whole.slices[*k], "level {level}, slice {k} of {picked:?}");
            }
        }
    }
}

/// Every third cell, and the mean of all.
fn some(flakes: &Flakes) -> CellSet {
    let mut cells = CellSet::none(flakes.grid.len(), flakes.levels.len());
    for (level, FlakeLevel { slices, .. }) in flakes.levels.iter().enumerate() {
        (0..slices.len()).filter(|k| (level + k) % 3 == 0).for_each(|k| cells.insert(level, k));
    }
    cells.insert_level(flakes.levels.len() - 1);
    cells
}

/// Paints of which cells were left out couple and blend into the same cells.
#[test]
fn coupled_and_blended_cells_do_not_depend_on_the_others() {
    let paints = ["silver_metallic", "blue_metallic"].map(|name| simulated(name).1);
    let cells = some(paints[0].flakes.as_ref().unwrap());
    let fewer = paints.clone().map(|mut paint| {
        paint.flakes.as_mut().unwrap().keep(&cells);
        paint
    });
    let coupled = |[a, b]: &[Paint; 2]| -> Mix {
        let named = [("a".to_owned(), a), ("b".to_owned(), b)];
        couple(&named, &CoupleOptions::default(), &|| ()).unwrap().0
    };
    let (whole, part) = (coupled(&paints), coupled(&fewer));
    let blended = |mix: &Mix| mix.blend(&[-0.3, 1.3]).unwrap().flakes.unwrap();
    let (blend, part_of_blend) = (blended(&whole), blended(&part));
    let (whole, part) = (whole.flakes.unwrap(), part.flakes.unwrap());
    assert!(cells.len() < cells.total());
    for (level, k) in cells.iter() {
        assert!(
            part.levels[level].slices[k] == whole.levels[level].slices[k],
            "arcs of level {level}, slice {k}"
        );
        let [a, b] = [&part_of_blend, &blend].map(|flakes| &flakes.levels[level].slices[k]);
        assert!(!a.is_left_out() && a == b, "blend at level {level}, slice {k}");
    }
}

//! Size against error: the statistics of a BTF of 68 slices, laid out as AxF car paints, beside its raw texels and beside a
//! principal component analysis of them (Rump et al. 2008, section 6) of equal error. `cargo bench --bench compactness`.
//!
//! Error: Wasserstein-1 distance (Delta-E in signed Lab) between colors of a representation and texels, above that of two
//! samples of the texels; mean over the slices that hold most of the energy, 4 x 1,000 colors each.

#![allow(clippy::print_stdout)]

use carpaint::btf::{AngleGrid, FlakeBtf};
use carpaint::cluster::{BoxRule, cluster_levels};
use carpaint::color::lab_from_rgb;
use carpaint::error::Result;
use carpaint::math::hash::{pcg4d, unit};
use carpaint::report::energetic_slices;
use carpaint::rivals::{Grouping, Images, Pca};
use carpaint::sampler::{Sampler, color};
use carpaint::simulate::{Composition, Model, ModelOptions, SynthesisOptions, synthesize};
use carpaint::transport::{Cost, Problem, Solver, solve};
use glam::DVec3;
use std::f64::consts::PI;
use std::path::Path;

const POINTS: u32 = 1000;
const SIDE: usize = 128;
const KIB: f64 = 1024.0;
/// All components: three channels of 68 slices.
const MOST: usize = 3 * 68;

fn main() -> Result<()> {
    println!("68 slices of {SIDE} x {SIDE}, level 0; raw texels in half floats {:.0} KiB", raw_bytes() / KIB);
    println!(
        "preset                  n  clusters+CDF KiB  W1 excess   PCA rank  PCA KiB  ratio raw  ratio PCA"
    );
    for name in ["silver_metallic", "blue_metallic", "brown_metallic"] {
        let btf = btf(name)?;
        let slices = energetic_slices(&btf);
        let pca = Pca::new(&btf, Grouping::All, Images::Gray, MOST)?;
        for n in [25, 50] {
            let (bytes, error) = statistics(&btf, &slices, n)?;
            let rank = rank_of(&pca, &btf, &slices, error);
            let pca_bytes = pca.bytes(rank) as f64;
            println!(
                "{name:<22} {n:>3} {:>17.1} {error:>10.2} {rank:>10} {:>8.0} {:>10.0} {:>10.1}",
                bytes / KIB,
                pca_bytes / KIB,
                raw_bytes() / bytes,
                pca_bytes / bytes
            );
        }
    }
    println!(
        "clusters: two corners in f32 and the cumulative probability in f32, 28 bytes each; coarser levels add a third,"
    );
    println!(
        "the color table of 64 x 64 texels 24 KiB in half floats. PCA: scores and components in half floats."
    );
    Ok(())
}

fn raw_bytes() -> f64 {
    (68 * SIDE * SIDE * 3 * 2) as f64
}

fn btf(name: &str) -> Result<FlakeBtf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/compositions/{name}.toml"));
    let model = Model::new(&Composition::read(&path)?, ModelOptions::default())?;
    let grid = AngleGrid::new(12, (0..12).map(|j| 8.min(12 - j)).collect())?;
    synthesize(&model, &SynthesisOptions { size: [SIDE; 2], ..SynthesisOptions::new(grid) }, &|| ())
}

/// Bytes of the statistics at `n` clusters, and their error.
fn statistics(btf: &FlakeBtf, slices: &[usize], n: usize) -> Result<(f64, f64)> {
    let texels = |k: usize| Ok(btf.slices[k].fluctuation.clone());
    let levels = cluster_levels(btf.grid.len(), texels, btf.size, n, BoxRule::MomentMatched, &|| ())?;
    let bytes: usize = levels[0].slices.iter().map(|s| 28 * s.clusters.len()).sum();
    let mut sum = 0.0;
    for k in slices {
        let (statistics, source) = (&levels[0].slices[*k], &btf.slices[*k].fluctuation);
        let sampler = Sampler::exact(statistics)?;
        let draw = |i: u32, stream: u32| {
            let [u, r0, r1, r2] = pcg4d([i, stream, 7, *k as u32]).map(unit);
            color(statistics, &sampler, u, [r0, r1, r2])
        };
        sum += excess(source, draw);
    }
    Ok((bytes as f64, sum / slices.len() as f64))
}

/// Wasserstein-1 distance of drawn colors from texels, above that of two samples of the texels.
fn excess(source: &[[f32; 3]], draw: impl Fn(u32, u32) -> [f32; 3]) -> f64 {
    let pick = |i: u32, stream: u32| source[pcg4d([i, stream, 5, 1])[0] as usize % source.len()];
    let cloud = |color: &dyn Fn(u32) -> [f32; 3]| -> Vec<DVec3> {
        (0..POINTS).map(|i| lab_from_rgb(PI * DVec3::from(color(i).map(f64::from)))).collect()
    };
    (0..4)
        .map(|repeat| {
            let texels = cloud(&|i| pick(i, 3 * repeat));
            let others = cloud(&|i| pick(i, 3 * repeat + 1));
            let drawn = cloud(&|i| draw(i, 3 * repeat + 2));
            (wasserstein(&drawn, &texels) - wasserstein(&others, &texels)) / 4.0
        })
        .sum()
}

fn wasserstein(a: &[DVec3], b: &[DVec3]) -> f64 {
    let mass = vec![1.0 / a.len() as f64; a.len()];
    Problem::from_centers(a, &mass, b, &mass, Cost::Euclidean)
        .and_then(|p| solve(&p, Solver::default()))
        .map_or(f64::NAN, |plan| plan.certificate.cost)
}

/// Error of so many components.
fn error_of(pca: &Pca, btf: &FlakeBtf, slices: &[usize], rank: usize) -> f64 {
    let of = |k: &usize| {
        let rebuilt = pca.slice(*k, rank).unwrap_or_default();
        let pick = |i: u32, stream: u32| rebuilt[pcg4d([i, stream, 9, 2])[0] as usize % rebuilt.len()];
        excess(&btf.slices[*k].fluctuation, pick)
    };
    slices.iter().map(of).sum::<f64>() / slices.len() as f64
}

/// Fewest components whose error is not larger.
fn rank_of(pca: &Pca, btf: &FlakeBtf, slices: &[usize], error: f64) -> usize {
    let (mut too_few, mut enough) = (0, MOST);
    while enough - too_few > 1 {
        let middle = (too_few + enough) / 2;
        if error_of(pca, btf, slices, middle) <= error { enough = middle } else { too_few = middle }
    }
    enough
}

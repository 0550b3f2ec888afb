//! Statistics of simulated paints: how well draws stand for the texels, level by level.

use super::wasserstein;
use carpaint::btf::{AngleGrid, half};
use carpaint::cluster::{BoxRule, cluster_levels};
use carpaint::report::energetic_slices;
use carpaint::sampler::{ReconstructionSamples, Sampler, reconstruction_error};
use carpaint::simulate::{Composition, Model, ModelOptions, SynthesisOptions, synthesize};

#[test]
fn draws_stand_for_simulated_paints() {
    // Mean excess over slices, Delta-E: what fifty boxes reach (the bench lists all fixtures), and 0.6 for the chance of a few
    // slices. Dim silver flakes are easy, interference pigments hard.
    for (name, excess) in [("silver_metallic", 0.8), ("pearl_on_black", 2.4)] {
        let file = format!("{}/fixtures/compositions/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let composition = Composition::read(std::path::Path::new(&file)).unwrap();
        let model = Model::new(&composition, ModelOptions::default()).unwrap();
        let side = 128;
        let grid = AngleGrid::triangle(3).unwrap();
        let options = SynthesisOptions { size: [side; 2], texel_mm: None, ..SynthesisOptions::new(grid) };
        let btf = synthesize(&model, &options, &|| ()).unwrap();
        let slice = |k: usize| Ok(btf.slices[k].fluctuation.clone());
        let levels =
            cluster_levels(btf.slices.len(), slice, btf.size, 50, BoxRule::MomentMatched, &|| ()).unwrap();
        let slices = energetic_slices(&btf);
        for (level, statistics) in levels.iter().enumerate().take(2) {
            let mut sum = 0.0;
            for k in &slices {
                let mut texels = btf.slices[*k].fluctuation.clone();
                (0..level).for_each(|l| texels = half(&texels, [side >> l; 2]).0);
                let statistics = &statistics.slices[*k];
                let samples = ReconstructionSamples { draws: 400_000, points: 600, repeats: 2, seed: 1 };
                let sampler = Sampler::exact(statistics).unwrap();
                let error =
                    reconstruction_error(&texels, statistics, &sampler, samples, wasserstein).unwrap();
                sum += error.excess() / slices.len() as f64;
                // Within 2 %, of which the draws take up to half.
                assert!((error.std_ratio() - 1.0).abs() < 0.02, "{name} {level} {k}: {}", error.std_ratio());
                if level == 0 {
                    let quantile = error.quantile_ratio();
                    assert!((quantile - 1.0).abs() < 0.05, "{name} {k}: {quantile}");
                }
            }
            println!("{name} level {level}: {sum:.2}");
            assert!(sum < excess, "{name} level {level}: {sum}");
        }
    }
}

//! The paints of Rump et al. 2008, Table 1, and samples of them at scattered directions.
#![allow(dead_code)]

use carpaint::brdf::cook_torrance::brightness;
use carpaint::brdf::{Bands, BrdfSample, LightPoint, Lobe, LobeGeometry, SampleSet};
use carpaint::math::half_difference::directions;
use carpaint::math::hash::{pcg4d, unit};
use std::f64::consts::PI;

/// Diffuse intensity, metallic lobes widest first, and gloss.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    pub name: &'static str,
    pub diffuse: f64,
    pub lobes: Vec<Lobe>,
    pub gloss: Lobe,
}

fn lobe([coefficient, roughness, f0]: [f64; 3]) -> Lobe {
    Lobe { coefficient, roughness, f0 }
}

/// The three of the table.
pub fn table1() -> [Truth; 3] {
    let paint = |name, diffuse, lobes: &[[f64; 3]], gloss| Truth {
        name,
        diffuse,
        lobes: lobes.iter().copied().map(lobe).collect(),
        gloss: lobe(gloss),
    };
    [
        paint(
            "green-blue flip-flop",
            0.0201372,
            &[
                [0.140216, 0.851337, 0.115703],
                [0.0993458, 0.248163, 0.172867],
                [0.145249, 0.142194, 0.285121],
            ],
            [0.15, 0.003, 0.0851148],
        ),
        paint(
            "silver metallic",
            0.0717947,
            &[[0.167496, 1.29319, 0.442487], [0.226424, 0.453529, 0.558767], [0.290604, 0.227447, 0.807962]],
            [0.2, 0.002, 0.0942766],
        ),
        paint(
            "specular blue",
            0.038105,
            &[[0.0435869, 1.04887, 0.120618], [0.0834049, 0.215455, 0.108905]],
            [0.030003, 0.00282852, 0.0351793],
        ),
    ]
}

/// Numbers of one sample, in the open unit interval.
pub struct Draw([u32; 3]);

impl Draw {
    pub fn new(seed: u32, sample: usize) -> Self {
        Self([seed, sample as u32, 0])
    }

    pub fn unit(&mut self) -> f64 {
        self.0[2] += 1;
        f64::from(unit(pcg4d([self.0[0], self.0[1], self.0[2], 17])[0]))
    }

    /// Gaussian of mean 0 and deviation 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        (-2.0 * self.unit().ln()).sqrt() * (2.0 * PI * self.unit()).cos()
    }
}

impl Truth {
    /// Everything but the gloss, 1/sr.
    pub fn base(&self, g: &LobeGeometry) -> f64 {
        brightness(self.diffuse, &self.lobes, g)
    }

    /// `n` gray samples outside of the gloss: half vectors at 2 to 80 degrees, both directions 6 degrees or more above the
    /// horizon, times `1 + noise z` with Gaussian z.
    pub fn base_samples(&self, n: usize, noise: f64, seed: u32) -> SampleSet {
        let mut set = SampleSet::new(Bands::Rgb).expect("bands");
        for k in 0.. {
            if set.len() == n {
                break;
            }
            let mut draw = Draw::new(seed, k);
            let theta_h = (2.0 + 78.0 * draw.unit()).to_radians();
            let (wi, wo) = directions(theta_h, 80f64.to_radians() * draw.unit(), PI * draw.unit());
            if wi.z < 0.1 || wo.z < 0.1 {
                continue;
            }
            let value = self.base(&LobeGeometry::of(wi, wo)) * (1.0 + noise * draw.normal());
            set.push(BrdfSample::new(wi, wo, 1.0), &[value; 3]).expect("above the horizon");
        }
        set
    }

    /// `n` gray samples of the gloss peak: half vectors up to three times its roughness from the normal, directions up to 75
    /// degrees, under a square light of `width` radians sampled by 9 x 10 points; 0 for a point.
    pub fn gloss_samples(&self, n: usize, noise: f64, seed: u32, width: f64) -> SampleSet {
        let mut set = SampleSet::new(Bands::Rgb).expect("bands");
        for k in 0..n {
            let mut draw = Draw::new(seed ^ 0x5eed, k);
            let reach = 3.0 * self.gloss.roughness + 0.4 * width;
            let (wi, wo) =
                directions(reach * draw.unit(), 75f64.to_radians() * draw.unit(), PI * draw.unit());
            let mut sample = BrdfSample::new(wi, wo, 1.0);
            if width > 0.0 {
                let (u, v) = wi.any_orthonormal_pair();
                let at = |j: usize, m: usize| width * ((j as f64 + 0.5) / m as f64 - 0.5);
                let point = |k: usize| (wi + u * at(k % 9, 9) + v * at(k / 9, 10)).normalize();
                sample.lights =
                    (0..90).map(|k| LightPoint { direction: point(k), share: 1.0 / 90.0 }).collect();
            }
            let value = sample.mean(|wi, wo| {
                let g = LobeGeometry::of(wi, wo);
                self.base(&g) + self.gloss.eval(&g)
            });
            set.push(sample, &[value * (1.0 + noise * draw.normal()); 3]).expect("above the horizon");
        }
        set
    }
}

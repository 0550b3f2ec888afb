//! What a capsule looks like, in numbers.

use crate::pictures;
use carpaint::color::{delta_e_76, lab_from_rgb, luminance};
use carpaint::error::Result;
use carpaint::paint::Paint;
use carpaint::render::{Options, Picture};
use carpaint::scene::Scene;
use glam::DVec3;

/// A capsule as it is pictured.
pub struct Look {
    /// Lab of every pixel of the capsule without its flakes' sparkle: the color from afar.
    smooth: Vec<DVec3>,
    /// The same with it.
    drawn: Vec<DVec3>,
    /// Linear RGB that flakes add to every pixel, or take.
    flakes: Vec<DVec3>,
}

impl Look {
    /// Looks of paints, of which capsules are pictured already.
    pub fn of(paints: &[Paint], drawn: &[Picture]) -> Result<Vec<Self>> {
        let plain = Options { flakes: false, ..pictures::OPTIONS };
        let scene = pictures::capsule();
        let smooth = pictures::each(&scene, paints, &plain)?;
        // Where it makes no difference what is behind, there is the capsule.
        let black = Scene { background: Some([0.0; 3]), ..scene };
        let behind = pictures::each(&black, &paints[..1], &plain)?;
        let is_paint: Vec<bool> =
            behind[0].pixels.iter().zip(&smooth[0].pixels).map(|(a, b)| a == b).collect();
        let look = |(drawn, smooth): (&Picture, &Picture)| {
            let rgb = |p: &[f32; 3]| DVec3::from(p.map(f64::from));
            let pixels =
                drawn.pixels.iter().zip(&smooth.pixels).zip(&is_paint).filter(|(_, is_paint)| **is_paint);
            let (drawn, smooth): (Vec<_>, Vec<_>) =
                pixels.map(|((drawn, smooth), _)| (rgb(drawn), rgb(smooth))).unzip();
            let lab = |pixels: &[DVec3]| pixels.iter().map(|p| lab_from_rgb(*p)).collect();
            let flakes = drawn.iter().zip(&smooth).map(|(drawn, smooth)| drawn - smooth).collect();
            Self { smooth: lab(&smooth), drawn: lab(&drawn), flakes }
        };
        Ok(drawn.iter().zip(&smooth).map(look).collect())
    }

    /// Mean color of the pixels, sparkle included, Lab.
    pub fn color(&self) -> DVec3 {
        self.drawn.iter().sum::<DVec3>() / self.drawn.len() as f64
    }

    /// Mean difference of two capsules' pixels from afar, Delta-E 1976.
    pub fn difference(&self, other: &Self) -> f64 {
        let sum: f64 = self.smooth.iter().zip(&other.smooth).map(|(a, b)| delta_e_76(*a, *b)).sum();
        sum / self.smooth.len() as f64
    }

    /// How much flakes sparkle: standard deviation of the luminance that they add, a white diffuser under the lamp about 1.
    pub fn sparkle(&self) -> f64 {
        self.rms(|flake| luminance(flake).powi(2))
    }

    /// Colored share of what flakes add, 0 where it is gray.
    pub fn tint(&self) -> f64 {
        self.rms(|flake| flake.distance_squared(DVec3::splat(flake.element_sum() / 3.0)))
            / self.rms(|flake| flake.length_squared())
    }

    /// How grainy the capsule is: standard deviation of what flakes do to the color of a pixel, Delta-E 1976.
    pub fn grain(&self) -> f64 {
        let squares =
            self.smooth.iter().zip(&self.drawn).map(|(smooth, drawn)| drawn.distance_squared(*smooth));
        (squares.sum::<f64>() / self.smooth.len() as f64).sqrt()
    }

    fn rms(&self, squared: impl Fn(DVec3) -> f64) -> f64 {
        (self.flakes.iter().map(|flake| squared(*flake)).sum::<f64>() / self.flakes.len() as f64).sqrt()
    }
}

/// Hue of a Lab color, degrees.
pub fn hue(lab: DVec3) -> f64 {
    lab.z.atan2(lab.y).to_degrees()
}

/// Difference of two hues, degrees, 0 to 180.
pub fn hue_between(a: DVec3, b: DVec3) -> f64 {
    let d = (hue(a) - hue(b)).rem_euclid(360.0);
    d.min(360.0 - d)
}

/// Chroma of a Lab color.
pub fn chroma(lab: DVec3) -> f64 {
    lab.y.hypot(lab.z)
}

/// Differences of neighbors, and the largest over the smallest.
pub fn steps_between(looks: &[Look]) -> (Vec<f64>, f64) {
    let apart: Vec<f64> = looks.windows(2).map(|pair| pair[0].difference(&pair[1])).collect();
    let (low, high) = apart.iter().fold((f64::INFINITY, 0.0), |(low, high), d| (d.min(low), d.max(high)));
    (apart, high / low)
}

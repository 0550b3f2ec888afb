//! What makes the flakes of a picture: `statistical`, or the truth behind the statistics.

use crate::btf::FlakeBtf;
use crate::error::{Error, Result};
use crate::render::{FlakeTruth, Options, Picture, RenderPaint, RenderSlices, render, render_truth};
use crate::scene::Scene;
use crate::simulate::Composition;
use crate::simulate::optics::film_optics::PaintOptics;
use crate::simulate::sparkle::{Masking, SparkleModel};
use std::path::PathBuf;
use std::str::FromStr;

/// The flakes of one paint.
#[derive(Debug, Clone, PartialEq)]
pub enum FlakeSource {
    /// The paint's own statistics.
    Statistical,
    /// The raw slices of a flake BTF.
    Btf(PathBuf),
    /// Ershov's sparkles of a composition.
    Analytic(PathBuf, Masking),
}

impl FromStr for FlakeSource {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        match text.split_once(':') {
            Some(("btf", path)) => Ok(Self::Btf(path.into())),
            Some(("analytic", path)) => Ok(Self::Analytic(path.into(), Masking::Dimmed)),
            Some(("analytic-hidden", path)) => Ok(Self::Analytic(path.into(), Masking::Hidden)),
            None if text == "statistical" => Ok(Self::Statistical),
            _ => Err(
                "statistical, btf:FILE.btf.exr, analytic:COMPOSITION.toml or analytic-hidden:COMPOSITION.toml",
            ),
        }
    }
}

impl FlakeSource {
    /// The picture of one paint with these flakes, on the CPU.
    pub fn render(
        &self,
        scene: &Scene,
        paints: &[RenderPaint],
        options: &Options,
        tick: &(dyn Fn() + Sync),
    ) -> Result<Picture> {
        if *self != Self::Statistical && paints.len() != 1 {
            return Err(Error::invalid(
                "--flakes",
                "number of paints",
                paints.len(),
                "1 with btf or analytic",
            ));
        }
        let picture = |truth| render_truth(scene, paints, &[truth], options, tick);
        match self {
            Self::Statistical => render(scene, paints, options, tick),
            Self::Btf(path) => {
                let slices = RenderSlices::new(&FlakeBtf::read(path)?);
                picture(FlakeTruth::Slices(&slices))
            }
            Self::Analytic(path, masking) => {
                let optics = PaintOptics::new(&Composition::read(path)?).map_err(|e| e.in_file(path))?;
                let mut model = SparkleModel::new(&optics);
                model.masking = *masking;
                picture(FlakeTruth::Sparkles(&model))
            }
        }
    }
}

//! Blends: paths, against the paint simulated half way.

use super::measure::{Curve, Effort, Head, Trial, curve};
use super::{CHANGE, Subject};
use crate::error::Result;
use crate::mix::{CoupleOptions, Mix, Path, couple};
use crate::paint::Paint;
use crate::report::{ChainOptions, blend_errors};
use crate::simulate::{Model, ModelOptions, synthesize};

pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let pair = [("a".to_owned(), &subject.chain.paint), ("b".to_owned(), &subject.other.paint)];
    let mixes = Path::ALL
        .iter()
        .map(|path| {
            Ok((*path, couple(&pair, &CoupleOptions { path: *path, ..CoupleOptions::default() }, &|| ())?.0))
        })
        .collect::<Result<Vec<(Path, Mix)>>>()?;
    let half_way = CHANGE.at(subject.chain.model.composition(), 0.5)?;
    let seed = effort.seed.wrapping_add(2);
    let options = ChainOptions { seed, texel_mm: Some(subject.chain.btf.texel_mm), ..subject.options };
    let model = Model::new(&half_way, ModelOptions::default())?;
    let truth = synthesize(&model, &options.synthesis()?, &|| ())?;
    let trials: Vec<Trial<Paint>> = (mixes.iter())
        .map(|(path, mix)| Trial::new(path, *path == Path::default(), move || mix.blend(&[0.5, 0.5])))
        .collect();
    let head = Head {
        stage: "Blend",
        knob: "path (couple --path)",
        error: "Wasserstein-1 distance of its colors from texels simulated half way above that of two draws of texels, Delta-E, the \
                mean of the strongest slices",
        why: "Moving every box along its arcs, as published, averages bright flakes with dark base and loses contrast half way; the \
              default exchanges probability where colors are far apart.",
    };
    Ok(vec![curve(head, &trials, *effort, |blend| Ok((blend_errors(blend, &truth)?.1.max(0.0), None)))?])
}

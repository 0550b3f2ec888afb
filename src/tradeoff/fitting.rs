//! Fit of the smooth part: starts, lobes and optimizers.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve};
use crate::error::Result;
use crate::fit::{FitOptions, FitReport, Optimizer, fit_smooth};

const STARTS: [usize; 5] = [1, 2, 4, 8, 16];

pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let btf = &subject.chain.btf;
    let usual =
        FitOptions { coat: Some(btf.coat), filled: false, seed: effort.seed, ..FitOptions::default() };
    let fit = |options: &FitOptions| Ok(fit_smooth(&btf.smooth, options, &|| ())?.1);
    let judge = |report: &FitReport| Ok((report.colored_error, None));
    const ERROR: &str =
        "logarithmic error with the color table (Rump et al. 2008, eq. 7) over the table that was simulated";
    let trial = |name: String, options: FitOptions| Trial::new(name, options == usual, move || fit(&options));
    let lobes = (1..=3).map(|lobes| trial(lobes.to_string(), FitOptions { lobes, ..usual.clone() }));
    let lobes: Vec<Trial<FitReport>> =
        lobes.chain([trial("auto".into(), FitOptions { choose_lobes: true, ..usual.clone() })]).collect();
    let starts = STARTS.map(|starts| trial(starts.to_string(), FitOptions { starts, ..usual.clone() }));
    // One start each: what is compared is the way down, and the slowest takes thirty times as long.
    let known =
        Optimizer::ALL.into_iter().filter(|o| !effort.quick || *o != Optimizer::TrustRegionReflective);
    let optimizers = known.map(|optimizer| {
        let name = serde_json::to_value(optimizer).ok().and_then(|name| Some(name.as_str()?.to_owned()));
        let options = FitOptions { optimizer, starts: 1, ..usual.clone() };
        Trial::new(name.unwrap_or_default(), optimizer == usual.optimizer, move || fit(&options))
    });
    let optimizers: Vec<Trial<FitReport>> = optimizers.collect();
    let head = |knob, why| Head { stage: "Fit", knob, error: ERROR, why };
    Ok(vec![
        curve(
            head(
                "lobes (--lobes)",
                "Beneath a color table, which takes up what the lobes leave, one lobe is as near to a simulated paint as three. Measured \
                 paints have narrow and broad highlights in one; three is what the literature fits, and what a smooth fit costs is seconds, \
                 once a paint.",
            ),
            &lobes,
            *effort,
            judge,
        )?,
        curve(
            head(
                "random starts (--starts)",
                "Simulated tables are easy: one start finds what sixteen do. Measured ones have several valleys, which the default \
                 searches.",
            ),
            &starts,
            *effort,
            judge,
        )?,
        curve(
            head(
                "optimizer (--optimizer), one start",
                "Least squares uses that the error is a sum of squares; the published quasi-Newton steps are kept to compare with.",
            ),
            &optimizers,
            *effort,
            judge,
        )?,
    ])
}

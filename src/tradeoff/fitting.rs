//! Fit of the smooth part: lobes, starts and optimizers; on the simulated table, and on a measured one.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve};
use crate::error::Result;
use crate::fit::{FitOptions, FitReport, Optimizer, fit_measured, fit_smooth};

pub(super) const STARTS: [usize; 5] = [1, 2, 4, 8, 16];

/// Why, on either table.
struct Words {
    error: &'static str,
    lobes: &'static str,
    starts: &'static str,
    optimizer: &'static str,
}

const SIMULATED: Words = Words {
    error: "logarithmic error with the color table (Rump et al. 2008, eq. 7) over the table that was simulated",
    lobes: "Beneath a color table, which takes up what the lobes leave, one lobe is as near to a simulated paint as three. Measured paints \
            have narrow and broad highlights in one (see --measured); three is what the literature fits, and what a smooth fit costs is \
            seconds, once a paint.",
    starts: "One start finds what sixteen do: the table has one valley. Eight are a guard against those that have several, for less than \
             twice the time of one.",
    optimizer: "Least squares uses that the error is a sum of squares; the published quasi-Newton steps are kept to compare with.",
};

const MEASURED: Words = Words {
    error: "logarithmic error of the lobes alone (Rump et al. 2008, eq. 7) over the measured table",
    lobes: "A measured highlight is narrow at its top and broad at its foot. On eleven paints of MERL and RGL (as neural fits) a second \
            lobe takes up to 44 % of the error that one leaves (27 % in the middle), a third up to 18 % of the rest (8 %); on the \
            clear-coated blue of NVIDIA's tables 11 and 1 %. With --lobes auto a criterion says whether it is worth its parameters.",
    starts: "Starts race on few samples, and the best goes on with all: eight cost a third more than one. On the tables at hand one finds \
             the same valley; where a highlight is as narrow as the cells it need not.",
    optimizer: "Least squares uses that the error is a sum of squares; the published quasi-Newton steps are kept to compare with.",
};

pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let btf = &subject.chain.btf;
    let usual =
        FitOptions { coat: Some(btf.coat), filled: false, seed: effort.seed, ..FitOptions::default() };
    let simulated = |options: &FitOptions| Ok(fit_smooth(&btf.smooth, options, &|| ())?.1);
    let mut curves = of("Fit", &SIMULATED, &usual, effort, &simulated, |report| report.colored_error)?;
    if let Some(measured) = &subject.measured {
        let usual = FitOptions { seed: effort.seed, ..FitOptions::default() };
        let fit = |options: &FitOptions| Ok(fit_measured(measured, options, &|| ())?.1);
        curves.extend(of("Fit, measured", &MEASURED, &usual, effort, &fit, |report| report.error)?);
    }
    Ok(curves)
}

fn of(
    stage: &'static str,
    words: &Words,
    usual: &FitOptions,
    effort: &Effort,
    fit: &dyn Fn(&FitOptions) -> Result<FitReport>,
    error: impl Fn(&FitReport) -> f64,
) -> Result<Vec<Curve>> {
    let trial =
        |name: String, options: FitOptions| Trial::new(name, options == *usual, move || fit(&options));
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
    let head = |knob, why| Head { stage, knob, error: words.error, why };
    let judge = |report: &FitReport| Ok((error(report), None));
    Ok(vec![
        curve(head("lobes (--lobes)", words.lobes), &lobes, *effort, judge)?,
        curve(head("random starts (--starts)", words.starts), &starts, *effort, judge)?,
        curve(head("optimizer (--optimizer), one start", words.optimizer), &optimizers, *effort, judge)?,
    ])
}

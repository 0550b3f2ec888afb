//! What `carpaint fit` tells.

use super::output;
use crate::brdf::Lobe;
use crate::fit::{Errors, FitReport, Uncertainty};

/// The report for people.
pub fn print_report(report: &FitReport) {
    let lobe = |name: &str, lobe: &Lobe| {
        let Lobe { coefficient, roughness, f0 } = lobe;
        output::say!("{name:<7} coefficient {coefficient:.4}  roughness {roughness:.4}  F0 {f0:.4}");
    };
    output::say!("diffuse {:.4}", report.diffuse);
    report.lobes.iter().for_each(|l| lobe("lobe", l));
    report.coat.gloss.iter().for_each(|l| lobe("gloss", l));
    print_uncertainty(&report.uncertainty);
    if report.choices.len() > 1 {
        let tried: Vec<String> = report
            .choices
            .iter()
            .map(|c| format!("{}: {:.4} ({:.0})", c.lobes, c.error, c.criterion))
            .collect();
        output::say!("lobes tried: error (criterion) {}; taken {}", tried.join(", "), report.lobes.len());
    }
    output::say!(
        "logarithmic error (Rump et al., eq. 7) {:.4}, with color table {:.4}, in the gloss peak {}",
        report.error,
        report.colored_error,
        report.gloss_error.map_or("-".to_owned(), |e| format!("{e:.4}"))
    );
    if let Some(straight) = &report.without_refraction {
        print_refraction(&report.errors(), straight);
    }
    let color = &report.color;
    output::say!(
        "color table: scaled colors off by {:.4} (root mean square), {:.4} of it what no table of two angles can say",
        color.all,
        color.azimuth
    );
    if let Some(beyond) = report.beyond_bands {
        output::say!("{:.2} % of white lies beyond the measured bands", 100.0 * beyond);
    }
    output::say!(
        "Delta-E 2000 over all cells outside the gloss: mean {:.2}, 95 % {:.2}",
        report.delta_e_2000.mean,
        report.delta_e_2000.q95
    );
    print_aspecular(report);
}

fn print_uncertainty(uncertainty: &Uncertainty) {
    output::say!("95 % intervals, samples taken as independent:");
    for p in &uncertainty.parameters {
        match p.relative_error {
            Some(_) => {
                let [low, high] = p.interval.map(bound);
                output::say!("  {:<24} {:.5}  {low} to {high}", p.name, p.value)
            }
            None => output::say!("  {:<24} {:.5}  given, or on its bound", p.name, p.value),
        }
    }
    for direction in &uncertainty.unidentified {
        let (with, against): (Vec<_>, Vec<_>) = direction.parts.iter().partition(|(_, share)| *share > 0.0);
        let names =
            |parts: &[&(String, f64)]| parts.iter().map(|p| p.0.as_str()).collect::<Vec<_>>().join(", ");
        let factor = direction.deviation.exp();
        let text = match (with.is_empty(), against.is_empty()) {
            (false, false) => format!("{} against {}", names(&with), names(&against)),
            _ => names(&[with, against].concat()),
        };
        output::say!("  not identified (by a factor of {}): {text}", bound(factor));
    }
}

/// A bound of what may be known to many orders of magnitude only.
fn bound(value: f64) -> String {
    if value < 1e4 { format!("{value:.5}") } else { format!("{value:.0e}") }
}

fn print_refraction(bent: &Errors, straight: &Errors) {
    for (name, e) in [("refracted", bent), ("straight", straight)] {
        output::say!(
            "{name:<10} light under the coat: eq. 7 {:.4}, with color table {:.4}, Delta-E 2000 {:.2}",
            e.error,
            e.colored_error,
            e.delta_e_2000.mean
        );
    }
}

fn print_aspecular(report: &FitReport) {
    output::say!("aspecular  L* a* b* as measured       L* a* b* of the fit        Delta-E 2000  76");
    for a in &report.aspecular {
        let lab = |v: [f64; 3]| format!("{:7.2} {:7.2} {:7.2}", v[0], v[1], v[2]);
        output::say!(
            "{:6.0}   {}   {}   {:8.2} {:8.2}",
            a.aspecular_deg,
            lab(a.measured_lab),
            lab(a.fitted_lab),
            a.delta_e_2000,
            a.delta_e_76
        );
    }
}

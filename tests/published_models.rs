//! What others reached on the same paints: their published parameters and our fit by the same measures on the same tables.
//!
//! SGD (Bagher, Soler, Holzschuch 2012, shifted gamma distribution, a model a channel) and ABC (Löw, Kronander, Ynnerman, Unger
//! 2012, microfacet form) were fitted to the MERL measurements, by other measures than eq. 7 of Rump et al. 2008. The tables here
//! are third parties' neural fits of those measurements: SGD and ABC also pay for what the networks changed, our fit does not.
//! Counted are all cells outside the gloss that our fit found and, apart, those with light and eye below 70 degrees, where the
//! measurements are good.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use carpaint::brdf::{LobeGeometry, TabulatedBrdf, read_measured};
use carpaint::color::{delta_e_2000, lab_from_rgb};
use carpaint::fit::{FitOptions, SmoothFit, fit_smooth};
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::PI;

/// A material's row of a table of parameters, by the names of the columns.
struct Row(HashMap<String, f64>);

impl Row {
    fn read(file: &str, material: &str) -> Option<Self> {
        let text = std::fs::read_to_string(common::reference(file)?).expect("reads");
        let mut lines = text.lines().map(|line| line.split('\t'));
        let names: Vec<&str> = lines.next().expect("a header").collect();
        let row = lines.map(Iterator::collect::<Vec<_>>).find(|row| row[0] == material)?;
        let number = |(name, text): (&&str, &str)| Some(((*name).to_owned(), text.parse().ok()?));
        Some(Self(names.iter().zip(row).filter_map(number).collect()))
    }

    fn one(&self, name: &str) -> f64 {
        self.0[name]
    }

    fn rgb(&self, name: &str) -> DVec3 {
        DVec3::from_array(["r", "g", "b"].map(|channel| self.0[&format!("{name}_{channel}")]))
    }
}

/// SGD, of Schlick-like Fresnel factor, shifted gamma distribution of facets and fitted masking.
fn sgd(p: &Row, wi: DVec3, wo: DVec3) -> DVec3 {
    let g = LobeGeometry::of(wi, wo);
    let channel = |k: usize| {
        let of = |name: &str| p.rgb(name)[k];
        let fresnel = of("f0") - g.cos_d * of("f1") + (1.0 - of("f0")) * (1.0 - g.cos_d).powi(5);
        let masking = |cos: f64| {
            let beyond = (cos.acos() - of("theta0")).max(0.0);
            (1.0 + of("lambda") * (1.0 - (of("c") * beyond.powf(of("k"))).exp())).clamp(0.0, 1.0)
        };
        let x = of("alpha") + g.tan2_h / of("alpha");
        let facets = of("kap") * (-x).exp() / (x.powf(of("p")) * PI * g.cos_h.powi(4));
        let shine = fresnel * facets * masking(g.cos_i) * masking(g.cos_o) / (g.cos_i * g.cos_o);
        (of("rhoD") + of("rhoS") * shine) / PI
    };
    DVec3::from_array([0, 1, 2].map(channel))
}

/// ABC in its microfacet form; Fresnel's factor of a dielectric as Cook & Torrance 1982 write it.
fn abc(p: &Row, wi: DVec3, wo: DVec3) -> DVec3 {
    let g = LobeGeometry::of(wi, wo);
    let c = g.cos_d;
    let root = (p.one("ior").powi(2) - 1.0 + c * c).sqrt();
    let ratio = (c * (root + c) - 1.0) / (c * (root - c) + 1.0);
    let fresnel = 0.5 * ((root - c) / (root + c)).powi(2) * (1.0 + ratio * ratio);
    let shade = (2.0 * g.cos_h * g.cos_i.min(g.cos_o) / c).min(1.0);
    let facets = p.rgb("A") / (1.0 + p.one("B") * (1.0 - g.cos_h)).powf(p.one("C"));
    (p.rgb("kD") + facets * fresnel * shade / (g.cos_i * g.cos_o)) / PI
}

/// Eq. 7 and the mean CIEDE2000 over cells, of all and of those below 70 degrees.
struct Errors {
    log: [f64; 2],
    delta_e: [f64; 2],
}

/// The cells outside the gloss: directions and values.
fn cells(table: &TabulatedBrdf, gloss_end: f64) -> Vec<(DVec3, DVec3, DVec3)> {
    let [n, m] = table.resolution();
    let all = (0..n * n * m).map(|cell| (cell / m / n, cell / m % n, cell % m));
    let of = |(a, b, k)| {
        let (wi, wo) = table.directions(a, b, k);
        (wi, wo, table.cell(a, b, k))
    };
    all.map(of).filter(|(wi, wo, _)| LobeGeometry::of(*wi, *wo).tan2_h.sqrt().atan() >= gloss_end).collect()
}

fn errors(cells: &[(DVec3, DVec3, DVec3)], epsilon: f64, model: impl Fn(DVec3, DVec3) -> DVec3) -> Errors {
    let (mut log, mut delta_e, mut count) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    for (wi, wo, measured) in cells {
        let found = model(*wi, *wo);
        let mean = |rgb: DVec3| rgb.element_sum().max(0.0) / 3.0 + epsilon;
        let steepest = 70f64.to_radians().cos();
        for k in 0..if wi.z.min(wo.z) > steepest { 2 } else { 1 } {
            log[k] += (mean(*measured) / mean(found)).ln().abs();
            delta_e[k] += delta_e_2000(lab_from_rgb(PI * *measured), lab_from_rgb(PI * found));
            count[k] += 1.0;
        }
    }
    let over = |sums: [f64; 2]| [sums[0] / count[0], sums[1] / count[1]];
    Errors { log: over(log), delta_e: over(delta_e) }
}

/// As a line of a table: all cells, and in brackets those below 70 degrees.
fn line(material: &str, model: &str, e: &Errors) {
    println!(
        "{material:<22} {model:<18} log {:.3} ({:.3})   Delta-E {:5.2} ({:5.2})",
        e.log[0], e.log[1], e.delta_e[0], e.delta_e[1]
    );
}

#[test]
fn the_fit_is_nearer_than_published_models() {
    for material in [
        "blue-metallic-paint",
        "color-changing-paint1",
        "gold-metallic-paint",
        "green-metallic-paint",
        "pearl-paint",
        "red-metallic-paint",
        "silver-metallic-paint",
        "two-layer-silver",
    ] {
        let Some(path) = common::reference(&format!("data/nbrdf/{material}.f32")) else { return };
        let table = read_measured(&path).expect("reads");
        let options = FitOptions { starts: 3, filled: false, ..FitOptions::default() };
        let (fit, report) = fit_smooth(&table, &options, &|| ()).expect("fits");
        let cells = cells(&table, report.gloss_end_deg.to_radians());
        let errors = |model: &dyn Fn(DVec3, DVec3) -> DVec3| errors(&cells, report.epsilon, model);
        let row = |file: &str| Row::read(file, material).expect("a material of both tables");
        let (sgd_row, abc_row) =
            (row("data/tables/merl_sgd_bagher2012.tsv"), row("data/tables/merl_abc_low2012.tsv"));
        let theirs = [
            ("SGD", errors(&|wi, wo| sgd(&sgd_row, wi, wo))),
            ("ABC", errors(&|wi, wo| abc(&abc_row, wi, wo))),
        ];
        let colored = errors(&|wi, wo| fit.eval(wi, wo));
        let white = SmoothFit { colors: carpaint::brdf::ColorTable::white(), ..fit.clone() };
        let lobes = errors(&|wi, wo| white.eval(wi, wo));
        theirs.iter().for_each(|(name, e)| line(material, name, e));
        // Of the intensity alone: they have no color.
        println!("{material:<22} {:<18} log {:.3} ({:.3})", "lobes alone", lobes.log[0], lobes.log[1]);
        line(material, "lobes, color table", &colored);
        for (name, e) in &theirs {
            for k in 0..2 {
                assert!(lobes.log[k] < e.log[k] && colored.log[k] < e.log[k], "{material}, {name}");
                assert!(colored.delta_e[k] < e.delta_e[k], "{material}, {name}");
            }
        }
    }
}

/// The models are read right: their colors at 45 degrees, as an instrument sees them, near those of the paint they were fitted to.
#[test]
fn published_models_are_near_the_paint_they_were_fitted_to() {
    let Some(path) = common::reference("data/nbrdf/green-metallic-paint.f32") else { return };
    let paint = read_measured(&path).expect("reads");
    let row = |file: &str| Row::read(file, "green-metallic-paint").expect("a row");
    let (sgd_row, abc_row) =
        (row("data/tables/merl_sgd_bagher2012.tsv"), row("data/tables/merl_abc_low2012.tsv"));
    for aspecular in [15.0, 25.0, 45.0] {
        let (wi, wo) =
            carpaint::brdf::instrument::Reading::new(45.0, aspecular).expect("an angle").directions();
        let green = paint.eval(wi, wo).y;
        // Measured: SGD 2 to 7 %, ABC 3 to 10 % off; a factor forgotten would be 2, or pi.
        assert!((sgd(&sgd_row, wi, wo).y / green - 1.0).abs() < 0.1, "SGD at {aspecular}");
        assert!((abc(&abc_row, wi, wo).y / green - 1.0).abs() < 0.15, "ABC at {aspecular}");
    }
}

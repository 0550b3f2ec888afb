//! The fast model from a composition to 41 wavelengths at the geometries of a multi-angle instrument, on one thread: prepared
//! at once against prepared with tables, both in the same run, and how far the quick answer is from the tight one.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::color::BANDS;
use carpaint::math::half_difference::spherical;
use carpaint::simulate::Composition;
use carpaint::simulate::models::fast_model::FastModel;
use carpaint::simulate::optics::film_optics::Preparation;
use std::time::Instant;

/// ASTM E2539: 45 degrees in, -15, 15, 25, 45, 75 and 110 from the mirror direction.
const ASPECULAR: [f64; 6] = [-15.0, 15.0, 25.0, 45.0, 75.0, 110.0];

fn paint(index: f64, flakes: &str) -> Composition {
    let text = format!("[substrate]\nalbedo = 0.3\n[[film]]\nthickness_um = 15\nindex = {index}\n{flakes}");
    Composition::parse(&text).expect("a legal composition")
}

fn kind(lifetime: f64, optics: &str) -> String {
    format!(
        "[[film.flakes]]\narea_density = 0.7\ndiameter_um = 20\nsigma_deg = 8\nflake_lifetime_deg = {lifetime}\n{optics}\n"
    )
}

/// Spectra at all geometries, and how long building and evaluating took, milliseconds, the shortest of several runs.
fn measure(composition: &Composition, preparation: Preparation) -> (Vec<[f64; BANDS]>, [f64; 2]) {
    let mut best = [f64::MAX; 2];
    let mut spectra = Vec::new();
    for _ in 0..20 {
        let start = Instant::now();
        let model = FastModel::prepared(composition, preparation).expect("one film");
        let built = start.elapsed();
        let wi = spherical(45f64.to_radians(), 0.0);
        let at = |aspecular: &f64| spherical((45.0 - aspecular).to_radians(), std::f64::consts::PI);
        spectra = ASPECULAR.iter().map(|a| model.brdf(wi, at(a)).0).collect();
        let all = start.elapsed();
        let times = [built, all - built].map(|t| 1e3 * t.as_secs_f64());
        best.iter_mut().zip(times).for_each(|(b, t)| *b = b.min(t));
    }
    (spectra, best)
}

fn main() {
    let mirror = "mirror = { reflectance = 0.6, transmittance = 0.2 }";
    let aluminium =
        "stack = [{ material = \"SiO2\", thickness_nm = 300 }, { material = \"Al\", thickness_nm = 40 }]";
    let pearl = "stack = [{ material = \"TiO2\", thickness_nm = 60 }, { material = \"mica\", thickness_nm = 500 }, \
                 { material = \"TiO2\", thickness_nm = 60 }]";
    let rows = [
        ("mirror flakes", kind(0.0, mirror)),
        ("mirror flakes with a lobe", kind(6.5, mirror)),
        ("two kinds with lobes", kind(6.5, mirror) + &kind(5.0, mirror)),
        ("coated aluminium", kind(6.5, aluminium)),
        ("pearl", kind(6.5, pearl)),
    ];
    println!(
        "{:<28} {:>20} {:>20} {:>7} {:>9}",
        "6 geometries x 41 nm", "at once: build, eval", "tables: build, eval", "ratio", "error"
    );
    for (name, flakes) in rows {
        let composition = paint(1.5, &flakes);
        let (quick, at_once) = measure(&composition, Preparation::Direct);
        let (tight, tables) = measure(&composition, Preparation::Tables);
        let error = quick.iter().flatten().zip(tight.iter().flatten()).map(|(a, b)| (a / b - 1.0).abs());
        println!(
            "{name:<28} {:>7.3} + {:>7.3} ms {:>7.2} + {:>7.3} ms {:>7.1} {:>9.0e}",
            at_once[0],
            at_once[1],
            tables[0],
            tables[1],
            (tables[0] + tables[1]) / (at_once[0] + at_once[1]),
            error.fold(0.0, f64::max)
        );
    }
}

//! The paint simulator against published numbers, independent oracles and its own laws.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

// The helpers of tests are tests too.

mod common;

use carpaint::brdf::fresnel::dielectric;
use carpaint::math::half_difference::spherical;
use carpaint::math::quadrature::gauss_legendre;
use carpaint::simulate::composition::Composition;
use carpaint::simulate::models::fast_model::FastModel;
use carpaint::simulate::optics::geometry::Geometry;
use carpaint::simulate::optics::parallel_flakes::{ParallelFlakes, ParallelKind};
use carpaint::simulate::optics::thin_film::{FilmLayer, stack_power};
use glam::DVec3;
use nalgebra::Complex;
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

/// A paint of gray mirror flakes, perfect mirrors or with a lobe.
fn paint(
    sigma_deg: f64,
    area_density: f64,
    r: f64,
    t: f64,
    index: f64,
    albedo: f64,
    lobe_deg: f64,
) -> Composition {
    Composition::parse(&format!(
        "[substrate]\nalbedo = {albedo}\n[[film]]\nthickness_um = 15\nindex = {index}\n[[film.flakes]]\n\
         area_density = {area_density}\ndiameter_um = 20\nsigma_deg = {sigma_deg}\nflake_lifetime_deg = {lobe_deg}\n\
         mirror = {{ reflectance = {r}, transmittance = {t} }}\n"
    ))
    .unwrap()
}

#[test]
fn fast_model_equals_the_oracle() {
    let Some(oracle) = common::reference_json("oracles/08_ershov_fast_model.json") else { return };
    let mut worst = [0.0f64; 7];
    for set in oracle["sets"].as_array().unwrap() {
        let p = |name: &str| number(&set["params"][name]);
        let model =
            FastModel::new(&paint(p("sigma_deg"), p("DSh"), p("rp"), p("tp"), p("eta"), p("rs"), 0.0))
                .unwrap();
        let constant = model.kinds()[0].orientation.density(0.0);
        assert!((constant / number(&set["P_norm_C"]) - 1.0).abs() < 1e-12);
        let kind = ParallelKind {
            orientation: model.kinds()[0].orientation.clone(),
            area_density: p("DSh"),
            reflectance: p("rp"),
            transmittance: p("tp"),
        };
        let flakes = ParallelFlakes { kinds: vec![kind], index: p("eta"), albedo: p("rs") };
        for (ours, name) in [
            (model.two_q().0[0], "twoQ_numeric"),
            (flakes.effective_albedo(), "rs_eff_const_30"),
            (flakes.effective_albedo_as_printed(), "rs_eff_32"),
            (flakes.optical_thickness(), "tau_h_const_29"),
        ] {
            let error = (ours - number(&set[name])).abs();
            assert!(!error.is_nan(), "{name}");
            worst[6] = worst[6].max(error);
        }
        for point in set["points"].as_array().unwrap() {
            let angle = |name: &str| number(&point[name]).to_radians();
            let wi = spherical(angle("theta_i_deg"), 0.0);
            // The oracle's azimuth is that of travel: 0 is the mirror side.
            let wo = spherical(angle("theta_o_deg"), std::f64::consts::PI - angle("phi_deg"));
            let g = Geometry::new(wi, wo, p("eta")).unwrap();
            let columns = [
                (model.glitter(&g).0[0], "glitter_36"),
                (model.shade(&g).0[0], "shade_28"),
                (flakes.glitter(&g), "glitter_33_general"),
                (flakes.glitter_as_printed(&g), "glitter_33_printed_rp_plus_tp_1"),
                (flakes.shade(&g), "shade_30"),
                (g.cos_alpha, "cos_alpha"),
            ];
            for (worst, (ours, name)) in worst.iter_mut().zip(columns) {
                let theirs = number(&point[name]);
                let error = if theirs == 0.0 { ours.abs() } else { (ours / theirs - 1.0).abs() };
                assert!(!error.is_nan(), "{name} {point}");
                *worst = worst.max(error);
            }
            assert!((g.beta - number(&point["beta_rad"])).abs() < 1e-8, "{point}");
        }
    }
    println!("fast model against the oracle, largest relative error by column: {worst:?}");
    // What the tables promise (1e-10 of the peak) at points 1e-7 below the peak, with room.
    assert!(worst.iter().all(|e| *e < 1e-8), "{worst:?}");
}

#[test]
fn thin_films_equal_the_oracle() {
    let Some(oracle) = common::reference_json("oracles/02_thin_film.json") else { return };
    let meta = &oracle["meta"];
    let list = |value: &Value| value.as_array().unwrap().iter().map(number).collect::<Vec<_>>();
    let (angles, wavelengths) = (list(&meta["angle_deg"]), list(&meta["wavelength_nm"]));
    let nk = |name: &str| (list(&meta["nk"][format!("{name}_n")]), list(&meta["nk"][format!("{name}_k")]));
    let (mc_peak, rakic) = (nk("Al_McPeak"), nk("Al_Rakic"));
    let mut worst = 0.0f64;
    for case in oracle["cases"].as_array().unwrap() {
        let indices = case["n_list"].as_array().unwrap();
        let thickness = case["d_list_nm"].as_array().unwrap();
        for (j, nm) in wavelengths.iter().enumerate() {
            let index = |value: &Value| match value.as_str() {
                Some("AL") => Complex::new(mc_peak.0[j], mc_peak.1[j]),
                Some(_) => Complex::new(rakic.0[j], rakic.1[j]),
                None => Complex::new(number(value), 0.0),
            };
            let layers: Vec<_> = (1..indices.len() - 1)
                .map(|k| FilmLayer { index: index(&indices[k]), thickness_nm: number(&thickness[k]) })
                .collect();
            let exit = index(&indices[indices.len() - 1]);
            for (i, angle) in angles.iter().enumerate() {
                let cos = angle.to_radians().cos();
                let ours = stack_power(number(&indices[0]), &layers, exit, cos, *nm);
                let columns = [
                    (ours.reflectance[0], "R_s"),
                    (ours.reflectance[1], "R_p"),
                    (ours.transmittance[0], "T_s"),
                    (ours.transmittance[1], "T_p"),
                    (ours.unpolarized_reflectance(), "R_unpol"),
                    (ours.unpolarized_transmittance(), "T_unpol"),
                ];
                for (value, name) in columns {
                    let error = (value - number(&case[name][i][j])).abs();
                    // A maximum does not see it.
                    assert!(!error.is_nan(), "{name} {angle} {nm}");
                    worst = worst.max(error);
                }
            }
        }
    }
    println!("thin films against the oracle: {worst:.1e}");
    // Powers of order 1 through a handful of complex products; the oracle itself is good to 1e-13.
    assert!(worst < 1e-12);
}

#[test]
fn a_clear_film_over_a_perfect_diffuser_loses_nothing() {
    for index in [1.0, 1.33, 1.5, 2.5] {
        let text =
            format!("substrate = {{ albedo = 1 }}\nfilm = [{{ thickness_um = 15, index = {index} }}]\n");
        let model = FastModel::new(&Composition::parse(&text).unwrap()).unwrap();
        for theta in [0.0, 0.7, 1.5f64] {
            let wi = spherical(theta, 0.0);
            // Gauss-Legendre in the squared sine of the outgoing angle; shade does not depend on azimuth.
            let total: f64 = gauss_legendre(400, 0.0, 1.0)
                .into_iter()
                .map(|(s, w)| std::f64::consts::PI * w * model.brdf(wi, spherical(s.sqrt().asin(), 0.0)).0[0])
                .sum();
            let passed = 1.0 - dielectric(theta.cos(), index);
            // The Fresnel transmittance has an infinite slope at grazing: what 400 nodes leave of it.
            assert!((total / passed - 1.0).abs() < 1e-5, "{index} {theta}: {total} {passed}");
        }
    }
}

#[test]
fn the_brdf_is_reciprocal_and_dark_below_the_horizon() {
    let model = FastModel::new(&paint(8.0, 1.0, 0.5, 0.3, 1.5, 0.4, 6.5)).unwrap();
    for (a, b, azimuth) in [(0.1, 1.2, 2.0), (0.8, 0.6, 3.1), (1.5, 0.0, 0.0)] {
        let (wi, wo) = (spherical(a, 0.3), spherical(b, 0.3 + azimuth));
        let (there, back) = (model.brdf(wi, wo).0[20], model.brdf(wo, wi).0[20]);
        // Rounding, through a density whose logarithm is up to 30.
        assert!((there / back - 1.0).abs() < 1e-12, "{there} {back}");
        assert_eq!(model.brdf(wi, -wo).0[20], 0.0);
    }
}

#[test]
fn a_flake_lives_as_long_outside_as_its_composition_says() {
    for index in [1.0, 1.5, 2.0] {
        let model = FastModel::new(&paint(8.0, 1.0, 0.5, 0.3, index, 0.4, 6.5)).unwrap();
        let lobe = model.kinds()[0].lobe.unwrap();
        // A flake along the normal, light and eye together (theta_i = 0) at an outer angle.
        let response = |theta_h: f64| {
            let w = spherical(theta_h, 0.0);
            let g = Geometry::new(w, w, index).unwrap();
            model.surface_factor(&g) * lobe.density(DVec3::Z, g.half)
        };
        let (mut low, mut high) = (0.0, 0.2);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if response(middle) > 0.5 * response(0.0) { low = middle } else { high = middle }
        }
        let width = (2.0 * low).to_degrees();
        // Refraction is linear to 1e-3 this close to the normal; 3 % is what the file format promises.
        assert!((width / 6.5 - 1.0).abs() < 0.03, "{index}: {width}");
    }
}

#[test]
fn the_widest_parameters_are_tabulated_to_their_tolerance() {
    let kind = |sigma: f64, lobe: f64, stack: &str| {
        format!(
            "[[film.flakes]]\narea_density = 0.3\ndiameter_um = 20\nsigma_deg = {sigma}\nflake_lifetime_deg = {lobe}\n\
             stack = [{stack}]\n"
        )
    };
    let paint = |index: f64, kind: &str| {
        format!("substrate = {{ albedo = 0.5 }}\n[[film]]\nthickness_um = 15\nindex = {index}\n{kind}")
    };
    let layer = |what: &str, nm: f64| format!("{{ {what}, thickness_nm = {nm} }}");
    let slab = [5000.0; 4].map(|nm| layer("material = \"mica\"", nm)).join(", ");
    let strong = [5000.0; 4].map(|nm| layer("index = 5", nm)).join(", ");
    let pairs = (0..16)
        .map(|_| layer("material = \"TiO2\"", 60.0) + ", " + &layer("material = \"SiO2\"", 95.0))
        .collect::<Vec<_>>()
        .join(", ");
    let mut failed = Vec::new();
    for (index, sigma, lobe, stack) in
        [(1.5, 0.1, 0.1, &slab), (1.0, 89.9, 90.0, &slab), (1.5, 8.0, 0.0, &pairs), (1.0, 8.0, 6.5, &strong)]
    {
        let model = FastModel::new(&Composition::parse(&paint(index, &kind(sigma, lobe, stack))).unwrap());
        failed.extend(model.err().map(|e| format!("{index} {sigma} {lobe} {stack}: {e}")));
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
    // 20 um of mica in a binder of index 4, beyond total reflection almost everywhere: resonances finer than any panel.
    let resonator = Composition::parse(&paint(4.0, &kind(5.0, 6.5, &slab))).unwrap();
    let message = FastModel::new(&resonator).unwrap_err().to_string();
    assert!(message.contains("reflectance of a stack"), "{message}");
    let thick = [5000.0; 5].map(|nm| layer("index = 1.6", nm)).join(", ");
    let message = Composition::parse(&paint(1.5, &kind(5.0, 6.5, &thick))).unwrap_err().to_string();
    for word in ["film[0]: flakes[0]", "all layers", "25000", "0 to 20000"] {
        assert!(message.contains(word), "{message}");
    }
}

#[test]
fn without_a_boundary_grazing_light_stays_finite() {
    let model = FastModel::new(&paint(5.0, 1.0, 0.5, 0.3, 1.0, 0.4, 6.5)).unwrap();
    let grazing = DVec3::new((1.0f64 - 1e-18).sqrt(), 0.0, 1e-9);
    for wo in [DVec3::Z, spherical(1.5, 3.0), DVec3::new(-grazing.x, 0.0, 1e-9)] {
        let g = Geometry::new(grazing, wo, 1.0).unwrap();
        assert_eq!((g.transmission, g.cos_inside[0]), (1.0, 1e-9));
        let f = model.brdf(grazing, wo).0[0];
        assert!(f.is_finite() && f > 0.0, "{wo}: {f}");
    }
}

#[test]
fn extreme_paints_stay_finite_and_lose_energy_only() {
    let cases = [
        (0.1, 1.0, 1.0, 0.0, 1.5, 1.0, 6.5),
        (89.9, 10.0, 1.0, 0.0, 1.5, 1.0, 6.5),
        (5.0, 10.0, 0.5, 0.5, 1.0, 1.0, 0.0),
        (60.0, 1e-8, 1.0, 0.0, 4.0, 0.0, 90.0),
        (5.0, 1.0, 0.0, 1.0, 1.5, 0.5, 0.1),
    ];
    for (sigma, density, r, t, index, albedo, lobe) in cases {
        let model = FastModel::new(&paint(sigma, density, r, t, index, albedo, lobe)).unwrap();
        let two_q = model.two_q().0[0];
        assert!((0.0..1.0 + 1e-12).contains(&two_q), "{sigma} {density}: 2Q {two_q}");
        for theta_i in [0.0, 0.8, 1.57] {
            for theta_o in [0.0, 0.8, 1.57] {
                let f = model.brdf(spherical(theta_i, 0.0), spherical(theta_o, 3.1)).0[0];
                assert!(f.is_finite() && f >= 0.0, "{sigma} {density} {theta_i} {theta_o}: {f}");
            }
        }
    }
}

//! Random legal recipes: every number from its whole legal range, the ends of the range more often than chance would have them.

use carpaint::color::Spectrum;
use carpaint::simulate::Composition;
use carpaint::simulate::composition::{
    Film, FlakeKind, HenyeyGreenstein, MieSpheres, Mirror, Pigment, Rayleigh, StackLayer, Substrate, Surface,
};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

/// From the whole range, its ends, or where real paints lie.
fn number(low: f64, high: f64, usual: [f64; 2]) -> impl Strategy<Value = f64> + Clone {
    prop_oneof![4 => usual[0]..=usual[1], 3 => low..=high, 1 => Just(low), 1 => Just(high)]
}

/// The same, of a range of several decades, `low` above 0.
fn decades(low: f64, high: f64, usual: [f64; 2]) -> impl Strategy<Value = f64> + Clone {
    number(low.ln(), high.ln(), usual.map(f64::ln)).prop_map(move |v| v.exp().clamp(low, high))
}

/// 0, or some decades.
fn none_or_decades(low: f64, high: f64, usual: [f64; 2]) -> impl Strategy<Value = f64> + Clone {
    prop_oneof![1 => Just(0.0), 3 => decades(low, high, usual)]
}

/// A straight line over wavelength, every second one flat.
fn spectrum(ends: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = Spectrum> + Clone {
    (ends.clone(), option::of(ends)).prop_map(|(a, b)| line(a, b.unwrap_or(a)))
}

fn line(a: f64, b: f64) -> Spectrum {
    if a == b {
        return Spectrum::constant(a);
    }
    Spectrum::from_knots(&[(380.0, a), (780.0, b)]).expect("two knots")
}

/// Of two spectra the share that is left of 1 by the first.
fn left(of: &Spectrum, share: f64) -> Spectrum {
    Spectrum(of.0.map(|v| share * (1.0 - v)))
}

fn share() -> impl Strategy<Value = f64> + Clone {
    number(0.0, 1.0, [0.05, 0.9])
}

fn mirror() -> impl Strategy<Value = Mirror> {
    (spectrum(share()), prop_oneof![2 => Just(0.0), 1 => share()])
        .prop_map(|(reflectance, passed)| Mirror { transmittance: left(&reflectance, passed), reflectance })
}

/// Refraction and absorption of a layer or a sphere: of a built-in material, or by numbers, metals (below 1) among them.
type Constants = (Option<String>, Option<Spectrum>, Option<Spectrum>);

fn constants() -> impl Strategy<Value = Constants> + Clone {
    let named = prop::sample::select(vec!["TiO2", "mica", "SiO2", "Fe2O3", "Al"]);
    let clear = spectrum(number(1.0, 10.0, [1.3, 2.7]));
    let metal = (spectrum(number(0.011, 10.0, [0.1, 3.0])), spectrum(decades(1e-3, 20.0, [0.01, 8.0])));
    prop_oneof![
        3 => named.prop_map(|name| (Some(name.to_owned()), None, None)),
        2 => clear.prop_map(|n| (None, Some(n), None)),
        1 => metal.prop_map(|(n, k)| (None, Some(n), Some(k))),
    ]
}

/// Layers of up to a micrometer, which vary by up to a fifth: fringes of thicker ones take a minute a recipe, and most are refused.
fn stack() -> impl Strategy<Value = Vec<StackLayer>> {
    let layer = (constants(), number(0.0, 1000.0, [20.0, 500.0]), number(0.0, 0.2, [0.0, 0.1]));
    let number = prop_oneof![6 => 1..=5usize, 1 => Just(Composition::MAX_LAYERS)];
    number.prop_flat_map(move |n| vec(layer.clone(), n)).prop_map(|layers| {
        // Brought into the limits on all layers together, which no range of one of them says.
        let total: f64 = layers.iter().map(|layer| layer.1).sum();
        let scale = (Composition::MAX_STACK_NM * (1.0 - 1e-12) / total.max(1.0)).min(1.0);
        let one =
            |(k, ((material, index, extinction), thickness, spread)): (usize, (Constants, f64, f64))| {
                // Classes of flakes multiply with each layer that varies, and too many are refused: one varies freely.
                let thickness_spread = match k {
                    0 => spread,
                    _ if k < Composition::MAX_SPREAD_LAYERS => 0.05 * spread,
                    _ => 0.0,
                };
                StackLayer { material, index, extinction, thickness_nm: scale * thickness, thickness_spread }
            };
        layers.into_iter().enumerate().map(one).collect()
    })
}

/// Knots of measured tilts: a table of up to six, at least 0.01 degrees apart.
fn tilts() -> impl Strategy<Value = Vec<[f64; 2]>> {
    vec((0.01..40.0f64, none_or_decades(1e-6, 1e6, [0.1, 10.0])), 2..=6).prop_map(|knots| {
        let span = knots.iter().map(|knot| knot.0).sum::<f64>();
        let (mut tilt, scale) = (0.0, (89.9 / span).min(1.0));
        let mut placed: Vec<[f64; 2]> = Vec::with_capacity(knots.len());
        for (step, density) in knots {
            placed.push([tilt, density]);
            tilt += (scale * step).max(0.011);
        }
        // Somewhere there are flakes.
        placed[0][1] = placed[0][1].max(1e-6);
        placed
    })
}

/// A kind of flakes; `diameters` in micrometres, `lobes` of a flake in degrees.
fn flakes(
    diameters: impl Strategy<Value = f64>,
    lobes: impl Strategy<Value = f64>,
) -> impl Strategy<Value = FlakeKind> {
    let orientation = prop_oneof![
        3 => decades(0.1, 89.9, [4.0, 15.0]).prop_map(|sigma| (Some(sigma), None)),
        1 => tilts().prop_map(|knots| (None, Some(knots))),
    ];
    let optics = prop_oneof![
        mirror().prop_map(|mirror| (Some(mirror), None)),
        stack().prop_map(|layers| (None, Some(layers))),
    ];
    let area = none_or_decades(1e-6, Composition::MAX_AREA_DENSITY, [0.05, 2.0]);
    (area, diameters, number(0.0, 1.0, [0.1, 0.5]), orientation, lobes, optics).prop_map(
        |(area_density, diameter_um, diameter_spread, (sigma_deg, tilts), flake_lifetime_deg, optics)| {
            FlakeKind {
                area_density,
                diameter_um,
                diameter_spread,
                sigma_deg,
                tilts,
                flake_lifetime_deg,
                mirror: optics.0,
                stack: optics.1,
            }
        },
    )
}

/// Scattering, and extinction that is as much or more.
fn coefficients() -> impl Strategy<Value = (Spectrum, Spectrum)> {
    let scattering = spectrum(none_or_decades(1e-3, 1e6, [1.0, 300.0]));
    (scattering, none_or_decades(1e-3, 1e6, [1.0, 100.0])).prop_map(|(scattering, absorption)| {
        let extinction = Spectrum(scattering.0.map(|s| (s + absorption).min(1e6).max(s)));
        (scattering, extinction)
    })
}

fn pigment() -> impl Strategy<Value = Pigment> {
    let none = Pigment { mie: None, rayleigh: None, henyey_greenstein: None };
    let [mie, rayleigh, henyey_greenstein] = [none.clone(), none.clone(), none];
    let spheres = (constants(), decades(0.001, 10.0, [0.05, 0.5]), number(0.0, 0.15, [0.001, 0.05]))
        .prop_map(|((material, index, extinction), radius_um, volume_fraction)| MieSpheres {
            volume_fraction,
            radius_um,
            material,
            index,
            extinction,
        });
    prop_oneof![
        spheres.prop_map(move |law| Pigment { mie: Some(law), ..mie.clone() }),
        coefficients().prop_map(move |(scattering_per_mm, extinction_per_mm)| Pigment {
            rayleigh: Some(Rayleigh { scattering_per_mm, extinction_per_mm }),
            ..rayleigh.clone()
        }),
        (coefficients(), spectrum(number(-0.8, 0.99, [0.0, 0.8]))).prop_map(
            move |((scattering_per_mm, extinction_per_mm), asymmetry)| Pigment {
                henyey_greenstein: Some(HenyeyGreenstein { scattering_per_mm, extinction_per_mm, asymmetry }),
                ..henyey_greenstein.clone()
            }
        ),
    ]
}

fn film(kinds: impl Strategy<Value = FlakeKind>) -> impl Strategy<Value = Film> {
    let absorption = spectrum(none_or_decades(1e-3, 1e6, [1.0, 100.0]));
    let thickness = prop_oneof![1 => Just(0.0), 9 => decades(1e-3, 1000.0, [10.0, 30.0])];
    let pigments =
        prop_oneof![2 => Just(0usize..=0), 1 => Just(1usize..=2)].prop_flat_map(|n| vec(pigment(), n));
    (thickness, number(1.0, 4.0, [1.3, 1.7]), absorption, vec(kinds, 0..=2), pigments).prop_map(
        |(thickness_um, index, absorption_per_mm, mut flakes, pigments)| {
            let area: f64 = flakes.iter().map(|kind| kind.area_density).sum();
            let scale = (Composition::MAX_AREA_DENSITY * (1.0 - 1e-12) / area.max(1.0)).min(1.0);
            flakes.iter_mut().for_each(|kind| kind.area_density *= scale);
            Film { thickness_um, index, absorption_per_mm, flakes, pigments }
        },
    )
}

/// A recipe that a failure prints as JSON.
#[derive(Clone)]
pub struct Shown(pub Composition);

impl std::fmt::Debug for Shown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut recipe = serde_json::to_value(&self.0).map_err(|_| std::fmt::Error)?;
        shorten(&mut recipe);
        write!(f, "{recipe}")
    }
}

/// Straight lines over wavelength, as a file may have them: by their ends.
fn shorten(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::Array(knots) if knots.len() == carpaint::color::BANDS => {
            _ = knots.drain(1..knots.len() - 1)
        }
        serde_json::Value::Array(values) => values.iter_mut().for_each(shorten),
        serde_json::Value::Object(entries) => entries.values_mut().for_each(shorten),
        _ => (),
    }
}

fn paint(kinds: impl Strategy<Value = FlakeKind>) -> impl Strategy<Value = Shown> {
    let roughness = prop_oneof![2 => Just(0.0), 1 => decades(1e-4, 45.0, [0.2, 5.0])];
    (spectrum(share()), vec(film(kinds), 1..=3), roughness).prop_map(|(albedo, films, roughness_deg)| {
        let composition = Composition {
            title: "random".to_owned(),
            substrate: Substrate { albedo },
            films,
            surface: Surface { roughness_deg },
        };
        composition.validate().expect("legal");
        Shown(composition)
    })
}

/// Anything that a recipe may say.
pub fn any_paint() -> impl Strategy<Value = Shown> {
    let lobes = prop_oneof![1 => Just(0.0), 4 => decades(0.1, 90.0, [3.0, 10.0])];
    paint(flakes(decades(0.01, 1000.0, [10.0, 30.0]), lobes))
}

/// One whose flakes can be drawn on a texture of 16 x 16 texels of 20 micrometres: no perfect mirrors, none wider than a quarter of
/// it, none so small that there are millions.
pub fn drawn_paint() -> impl Strategy<Value = Shown> {
    paint(flakes(decades(2.0, 80.0, [10.0, 30.0]), decades(0.1, 90.0, [3.0, 10.0])))
}

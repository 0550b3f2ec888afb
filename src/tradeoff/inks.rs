//! Goniochromatic inks: wavelengths.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve};
use crate::color::{BANDS, Illuminant, delta_e_2000, lab_from_rgb, luminance};
use crate::error::Result;
use crate::render::{Bands, InkModel, Look, PrintInks, own_inks};
use glam::{DVec3, Vec3};

const WAVELENGTHS: [usize; 8] = [5, 8, 11, 16, 21, 26, 31, BANDS];
/// Every so many degrees of incidence, seen so far off the mirror direction.
const INCIDENCE_STEP: f32 = 5.0;
const OFFSETS: [f32; 3] = [-10.0, 0.0, 10.0];

pub(super) fn curves(_: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let inks = own_inks()?;
    let ready = |bands: Bands| {
        let light = Illuminant::D65.spectrum();
        Look { light, adapted: false, model: InkModel::default(), bands }.inks(&inks)
    };
    let truth = colors(&ready(Bands::Wavelengths(BANDS))?);
    let settings = WAVELENGTHS.map(|count| (count.to_string(), Bands::Wavelengths(count)));
    let settings: Vec<(String, PrintInks)> = [("xyz".to_owned(), Bands::Xyz)]
        .into_iter()
        .chain(settings)
        .map(|(name, bands)| Ok((name, ready(bands)?)))
        .collect::<Result<_>>()?;
    let trials: Vec<Trial<Vec<DVec3>>> = (settings.iter())
        .map(|(name, inks)| Trial::new(name, inks.bands.len() == BANDS, move || Ok(colors(inks))))
        .collect();
    let head = Head {
        stage: "Inks",
        knob: "wavelengths (proof --wavelengths)",
        error: "largest Delta-E 2000 about the mirror direction up to 70 degrees, as bright as a light gray, against 41 wavelengths",
        why: "A proof is looked at, not played: all that is known of the inks is used. In the window 21 are half the price and below \
              what an eye tells apart in all but the most grazing light.",
    };
    let judge = |found: &Vec<DVec3>| {
        let error = |(a, b): (&DVec3, &DVec3)| {
            let white = 2.0 * luminance(*a);
            delta_e_2000(lab_from_rgb(*a / white), lab_from_rgb(*b / white))
        };
        Ok((truth.iter().zip(found).map(error).fold(0.0, f64::max), None))
    };
    Ok(vec![curve(head, &trials, *effort, judge)?])
}

/// Colors of each ink, light and eye in one plane.
fn colors(inks: &PrintInks) -> Vec<DVec3> {
    let direction = |degrees: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vec3::new(sin, 0.0, cos)
    };
    let at = (0u8..15).flat_map(|k| OFFSETS.map(|off| (f32::from(k) * INCIDENCE_STEP, off)));
    let at = at.filter(|(incidence, off)| (incidence + off).abs() < 85.0);
    at.flat_map(|(incidence, off)| {
        let (wi, wo) = (direction(incidence), direction(-incidence - off));
        Vec3::AXES.map(|ink| inks.reflectance(ink, wi, wo).as_dvec3())
    })
    .collect()
}

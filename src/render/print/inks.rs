//! Inks under a light, ready for rays: spectra in f32, and what each wavelength adds to linear Rec.709.

use crate::brdf::Ink;
use crate::brdf::cook_torrance::LobeGeometry;
use crate::brdf::fresnel::{conductor, schlick};
use crate::brdf::goniochromatic::{Goniochromatic, cos_mean_angle};
use crate::color::{Illuminant, Spectrum, WHITE_XYZ, Wavelengths, bradford, rgb_from_xyz};
use crate::error::{Error, Result};
use crate::fit::ink_of_observer;
use crate::simulate::optics::materials::optical_constants;
use glam::{DMat3, DVec3, Vec2, Vec3};

/// How inks reflect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InkModel {
    /// The goniochromatic model (Pranovich et al. 2024, eq. 5).
    #[default]
    Goniochromatic,
    /// Torrance and Sparrow's, rho in place of the reflectance at normal incidence in Schlick's formula.
    Schlick,
    /// Torrance and Sparrow's, rho times the exact Fresnel reflectance of titanium dioxide, the coating of the
    /// paper's flakes.
    Exact,
}

impl InkModel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Goniochromatic, Self::Schlick, Self::Exact];
}

/// Up to three inks at some wavelengths; those that are not there reflect nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct PrintInks {
    /// How they reflect.
    pub model: InkModel,
    /// Roughness of each ink.
    pub roughness: Vec3,
    /// The wavelengths.
    pub bands: Vec<InkBand>,
    /// Linear Rec.709 of the perfect diffuser: (1, 1, 1) under D65, or where the eye is adapted to the light.
    pub white: Vec3,
}

/// Inks at a wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InkBand {
    /// Reflectance rho of each ink.
    pub reflectance: Vec3,
    /// Coefficient c of each ink.
    pub growth: Vec3,
    /// Complex index of the coating, titanium dioxide.
    pub index: Vec2,
    /// Linear Rec.709 of a reflectance of 1.
    pub color: Vec3,
}

impl PrintInks {
    /// Most inks.
    pub const MAX: usize = 3;

    /// Inks under a light, at 41 wavelengths, 380 to 780 nm. `adapted`: seen by an eye that takes the light's white for white
    /// (Bradford), as a camera balanced for it; else by one adapted to D65.
    ///
    /// # Errors
    /// No ink or more than three; a light that the eye does not see, or below 0 somewhere.
    pub fn new(inks: &[Ink], model: InkModel, light: &Spectrum, adapted: bool) -> Result<Self> {
        Self::at(&Wavelengths::even(crate::color::BANDS)?, inks, model, light, adapted)
    }

    /// The same at wavelengths of one's choice: fewer cost less, and know less.
    ///
    /// # Errors
    /// As [`PrintInks::new`].
    pub fn at(
        wavelengths: &Wavelengths,
        inks: &[Ink],
        model: InkModel,
        light: &Spectrum,
        adapted: bool,
    ) -> Result<Self> {
        check(inks, light)?;
        let to_rgb = Observer::new(light, adapted);
        let inks = inks.iter().map(|ink| ink.resampled(wavelengths)).collect::<Result<Vec<_>>>()?;
        let of_inks = |f: &dyn Fn(&Ink) -> f64| of_inks(&inks, f);
        let colors = wavelengths.xyz_weights(light);
        let (n, k) = optical_constants(Some("TiO2"), None, None)?;
        let bands = colors.iter().enumerate().map(|(band, xyz)| InkBand {
            reflectance: of_inks(&|ink| ink.reflectance()[band]),
            growth: of_inks(&|ink| ink.growth()[band]),
            index: [&n, &k].map(|part| part.at(wavelengths.nm()[band]) as f32).into(),
            color: to_rgb.rgb(*xyz),
        });
        let white = to_rgb.rgb(colors.iter().sum());
        Ok(Self { model, roughness: roughness(&inks), bands: bands.collect(), white })
    }

    /// The same as three numbers: X, Y and Z of each ink follow the goniochromatic model, too, about ([`ink_of_observer`]).
    ///
    /// # Errors
    /// As [`PrintInks::new`].
    pub fn tristimulus(inks: &[Ink], light: &Spectrum, adapted: bool) -> Result<Self> {
        check(inks, light)?;
        let to_rgb = Observer::new(light, adapted);
        let fitted: Vec<[Goniochromatic; 3]> = inks.iter().map(|ink| ink_of_observer(ink, light)).collect();
        let of_inks = |f: &dyn Fn(&[Goniochromatic; 3]) -> f64| of_inks(&fitted, f);
        let bands = DVec3::AXES.iter().enumerate().map(|(k, axis)| InkBand {
            reflectance: of_inks(&|ink| ink[k].reflectance),
            growth: of_inks(&|ink| ink[k].growth),
            index: Vec2::X,
            color: to_rgb.rgb(*axis),
        });
        let bands = bands.collect();
        let white = to_rgb.rgb(Spectrum::constant(1.0).xyz(light));
        Ok(Self { model: InkModel::Goniochromatic, roughness: roughness(inks), bands, white })
    }

    pub(super) fn goniochromatic(&self, amplitude: Vec3, g: &LobeGeometry<f32>) -> Vec3 {
        let versine = 1.0 - cos_mean_angle(g.cos_i, g.cos_o);
        let term = |band: &InkBand| band.color * amplitude.dot(band.reflectance * exp(band.growth * versine));
        self.bands.iter().map(term).sum()
    }

    pub(super) fn schlick(&self, amplitude: Vec3, g: &LobeGeometry<f32>) -> Vec3 {
        let fresnel = |f0: Vec3| Vec3::from(f0.to_array().map(|f0| schlick(f0, g.cos_d)));
        let term = |band: &InkBand| band.color * amplitude.dot(fresnel(band.reflectance));
        self.bands.iter().map(term).sum()
    }

    pub(super) fn exact(&self, amplitude: Vec3, g: &LobeGeometry<f32>) -> Vec3 {
        let term = |band: &InkBand| {
            band.color * (conductor(g.cos_d, band.index.x, band.index.y) * amplitude.dot(band.reflectance))
        };
        self.bands.iter().map(term).sum()
    }
}

fn exp(v: Vec3) -> Vec3 {
    Vec3::new(v.x.exp(), v.y.exp(), v.z.exp())
}

fn check(inks: &[Ink], light: &Spectrum) -> Result<()> {
    if !(1..=PrintInks::MAX).contains(&inks.len()) {
        return Err(Error::invalid("print", "number of inks", inks.len(), "1 to 3"));
    }
    if let Some(band) = light.0.iter().position(|power| !(*power >= 0.0 && power.is_finite())) {
        let place = format!("light: {} nm", crate::color::wavelength_nm(band));
        return Err(Error::invalid(place, "power", light.0[band], "0 or more"));
    }
    if !Spectrum::constant(1.0).xyz(light).is_finite() {
        return Err(Error::invalid(
            "light",
            "power",
            "none that the eye sees",
            "some between 380 and 780 nm",
        ));
    }
    Ok(())
}

/// One value an ink, 0 for those that are not there.
fn of_inks<T>(inks: &[T], value: &dyn Fn(&T) -> f64) -> Vec3 {
    Vec3::from(std::array::from_fn(|k| inks.get(k).map_or(0.0, |ink| value(ink) as f32)))
}

/// Those that are not there have any roughness but none.
fn roughness(inks: &[Ink]) -> Vec3 {
    Vec3::from(std::array::from_fn(|k| inks.get(k).map_or(1.0, |ink| ink.roughness() as f32)))
}

/// From XYZ under a light to linear Rec.709.
struct Observer(DMat3);

impl Observer {
    fn new(light: &Spectrum, adapted: bool) -> Self {
        // Under D65 the straight sums' white is brought to that of Rec.709 in any case: a thousandth.
        let white = if adapted { light } else { &Illuminant::D65.spectrum() };
        Self(bradford(Spectrum::constant(1.0).xyz(white), WHITE_XYZ))
    }

    fn rgb(&self, xyz: DVec3) -> Vec3 {
        rgb_from_xyz(self.0 * xyz).as_vec3()
    }
}

//! The JSON of a folder: the properties of an AxF car paint, under their names in its SDK, and what its textures leave unsaid.

use crate::btf::{AngleGrid, FlakeBtf};
use crate::error::{Error, Result};
use crate::file::read_text;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Name of the JSON in its folder.
pub(super) const NAME: &str = "axf.json";
/// Largest JSON, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// What `axf.json` holds. The first ten keys are AxF's own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case, reason = "the names of AxF")]
pub struct AxfProperties {
    /// Bins a quarter turn of the half-vector angle, and of the difference angle too.
    pub num_thetaF: usize,
    /// Bins of the difference angle that have slices of their own; fewer than `num_thetaF` is not supported.
    pub num_thetaI: usize,
    /// Rows (difference angles) of slices.
    pub max_thetaI: usize,
    /// First slice of each row, then their number (or 0, as some files have it), zeros after that.
    pub thetaFI_sliceLUT: Vec<usize>,
    /// Specular coefficients of the lobes, up to 4.
    pub CT_coeffs: Vec<f64>,
    /// Reflectances at normal incidence.
    pub CT_F0s: Vec<f64>,
    /// Roughnesses (Beckmann's m).
    pub CT_spreads: Vec<f64>,
    /// Diffuse albedo.
    pub CT_diffuse: f64,
    /// Index of refraction of the coat; 1: none.
    pub IOR: f64,
    /// 1: light is not refracted on its way to the base. 0: it is.
    pub cc_no_refraction: u8,
    /// EXR of the color table: columns theta_F of 0 to 90 degrees, rows theta_I from the top, outermost texels on the ends.
    pub BRDFcolors: String,
    /// EXRs of the slices, in the order of the LUT.
    pub BTFflakes: Vec<String>,
    /// Width and height of a slice, millimetres.
    pub size_mm: [f64; 2],
    /// Whether slices hold the reflectance times the cosine of the light (under the coat).
    pub cosine_included: bool,
    /// What is added to the position in bins before slices are looked up: 0, or 0.5 as some renderers do.
    #[serde(default)]
    pub bin_offset: f64,
    /// Color space of all textures: see [`super::ColorSpace`].
    #[serde(default)]
    pub color_space: super::ColorSpace,
}

impl AxfProperties {
    pub(super) fn read(path: &Path) -> Result<Self> {
        let text = read_text(path, MAX_BYTES)?;
        let mut json = serde_json::Deserializer::from_str(&text);
        let fault = |at: String, e: &serde_json::Error| {
            let place = format!("{}: {at}", path.display());
            Error::invalid(place, "property", e, "the properties of an AxF-like paint")
        };
        let properties: Self = serde_path_to_error::deserialize(&mut json)
            .map_err(|e| fault(e.path().to_string(), e.inner()))?;
        json.end().map_err(|e| fault("end".to_owned(), &e))?;
        properties.check().map_err(|e| e.in_file(path))?;
        Ok(properties)
    }

    fn check(&self) -> Result<()> {
        if self.num_thetaI != self.num_thetaF {
            let legal = format!("{} (num_thetaF)", self.num_thetaF);
            return Err(Error::unsupported("", "num_thetaI", self.num_thetaI, legal));
        }
        if self.cc_no_refraction > 1 {
            return Err(Error::invalid("", "cc_no_refraction", self.cc_no_refraction, "0 or 1"));
        }
        if !(0.0..=1.0).contains(&self.bin_offset) {
            return Err(Error::invalid("", "bin_offset", self.bin_offset, "0 to 1"));
        }
        let counts = [self.CT_coeffs.len(), self.CT_F0s.len(), self.CT_spreads.len()];
        if counts[0] > 4 || counts != [counts[0]; 3] {
            return Err(Error::invalid(
                "",
                "CT_coeffs, CT_F0s, CT_spreads",
                format!("{counts:?}"),
                "up to 4, as many of each",
            ));
        }
        let mut names = self.BTFflakes.iter().chain([&self.BRDFcolors]);
        if let Some(name) = names.find(|name| Path::new(name).file_name() != Some(name.as_ref())) {
            return Err(Error::invalid("", "file name", format!("{name:?}"), "a file in the same folder"));
        }
        Ok(())
    }

    /// The slices that there are: row by row.
    pub(super) fn grid(&self) -> Result<AngleGrid> {
        let (rows, count) = (self.max_thetaI, self.BTFflakes.len());
        let lut = &self.thetaFI_sliceLUT;
        if rows == 0 || rows > lut.len() {
            return Err(Error::invalid(
                "",
                "max_thetaI",
                rows,
                format!("1 to {} (thetaFI_sliceLUT)", lut.len()),
            ));
        }
        let end = lut.get(rows).copied().filter(|end| *end > 0).unwrap_or(count);
        let starts = lut[..rows].iter().copied().chain([end]).collect::<Vec<_>>();
        if starts[0] != 0 || starts.windows(2).any(|pair| pair[0] > pair[1]) || end != count {
            let legal = format!("0, then ascending, up to {count} (BTFflakes)");
            return Err(Error::invalid("", "thetaFI_sliceLUT", format!("{starts:?}"), legal));
        }
        let mut lengths: Vec<usize> = starts.windows(2).map(|pair| pair[1] - pair[0]).collect();
        while lengths.last() == Some(&0) {
            lengths.pop();
        }
        AngleGrid::new(self.num_thetaF, lengths).map_err(|e| e.within("thetaFI_sliceLUT"))
    }

    /// Side of a texel of slices of this size, millimetres.
    pub(super) fn texel_mm(&self, size: [usize; 2]) -> Result<f64> {
        let [width, height] = [0, 1].map(|k| self.size_mm[k] / size[k] as f64);
        FlakeBtf::check_texels(size, width)?;
        if !(0.99..1.01).contains(&(width / height)) {
            let found = format!("{width} x {height} mm");
            return Err(Error::unsupported("", "texel", found, "square ones, to 1 %"));
        }
        Ok(width)
    }
}

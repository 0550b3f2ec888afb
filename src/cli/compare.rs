//! `carpaint compare`.

use super::output;
use crate::error::{Error, Result};
use crate::file::{self, Container};
use crate::mix::{self, Mix};
use crate::paint::{self, Paint};
use crate::render::{Picture, PictureDifference};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Compare two pictures, paints or mixes; exit code 1 if they differ.
///
/// Paints are equal when they render alike: clusters with equal boxes count as one, provenance does not count.
#[derive(clap::Args)]
pub struct Arguments {
    /// First file.
    a: PathBuf,
    /// Second file, of the same kind.
    b: PathBuf,
    /// Largest difference that still counts as equal. Pictures: of sRGB-encoded values, 1/255 = 0.0039 is one step of 8 bits.
    /// Paints and mixes: of any number listed.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    tolerance: f64,
    /// Print the differences as JSON.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        if self.tolerance.is_nan() || self.tolerance < 0.0 {
            return Err(Error::invalid("--tolerance", "tolerance", self.tolerance, "0 or more"));
        }
        let equal = match (kind_of(&self.a)?, kind_of(&self.b)?) {
            (None, None) => self.pictures(&self.a, &self.b)?,
            (Some(a), Some(b)) if a.kind() == b.kind() => self.files(a, b)?,
            (a, b) => {
                let name = |c: Option<Container>| c.map_or("picture".to_owned(), |c| c.kind().to_owned());
                let (a, b) = (name(a), name(b));
                return Err(Error::invalid(
                    self.b.display().to_string(),
                    "kind of file",
                    b,
                    format!("{a}, as the first"),
                ));
            }
        };
        Ok(if equal { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    /// Prints how far two pictures are apart; whether that is within the tolerance.
    fn pictures(&self, a: &Path, b: &Path) -> Result<bool> {
        let difference = PictureDifference::of(&Picture::read(a)?, &Picture::read(b)?)?;
        if self.json {
            output::json(&difference)?;
        } else {
            output::say!(
                "largest difference   {:.6} (sRGB-encoded, tolerance {})",
                difference.largest,
                self.tolerance
            );
            output::say!("mean difference      {:.6}", difference.mean);
            output::say!("PSNR                 {:.2} dB", difference.psnr);
            output::say!("mean Delta-E 2000    {:.4}", difference.delta_e_2000);
            output::say!("mean FLIP            {:.4}", difference.flip);
        }
        Ok(difference.largest <= self.tolerance)
    }

    /// Prints how far two paints or mixes are apart; whether that is within the tolerance.
    fn files(&self, a: Container, b: Container) -> Result<bool> {
        let differences = match a.kind() {
            paint::KIND => {
                let a = Paint::from_container(a).map_err(|e| e.in_file(&self.a))?;
                a.differences(&Paint::from_container(b).map_err(|e| e.in_file(&self.b))?)
            }
            mix::KIND => {
                let a = Mix::from_container(a).map_err(|e| e.in_file(&self.a))?;
                a.differences(&Mix::from_container(b).map_err(|e| e.in_file(&self.b))?)
            }
            other => {
                let legal = format!("{} or {}", paint::KIND, mix::KIND);
                return Err(Error::unsupported(self.a.display().to_string(), "kind of file", other, legal));
            }
        };
        if self.json {
            output::json(&differences)?;
        } else if differences.is_empty() {
            output::say!("equal");
        } else {
            for (what, value) in &differences {
                output::say!("{what:<44} {value:.6e}");
            }
        }
        Ok(differences.iter().all(|d| d.1 <= self.tolerance))
    }
}

/// The container of a paint, mix or flake BTF; none for a picture.
fn kind_of(path: &Path) -> Result<Option<Container>> {
    file::open(path)?;
    let is_exr = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
    if !is_exr || !Container::is_container(path)? {
        return Ok(None);
    }
    Container::read(path).map(Some)
}

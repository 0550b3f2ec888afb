//! Writer of in-plane spectra as a table that [`super::multi_angle`] reads: `theta_i, theta_o`, wavelengths in nm.

use super::instrument::Reading;
use super::multi_angle::MAX_ROWS;
use super::sample_set::{Bands, SampleSet};
use crate::error::{Error, Result};
use std::f64::consts::PI;
use std::fmt::Write;

/// The text of a table: reflectance factors pi f, a row a sample in the set's order, every digit that tells numbers apart;
/// `comments` are the first lines, each behind a `#`. Read again, values and directions are the same to 1e-12.
///
/// # Errors
/// Bands that are no wavelengths, a sample out of the plane of incidence or under an extended light, more rows than are read.
pub fn multi_angle_text(samples: &SampleSet, comments: &str) -> Result<String> {
    let Bands::Wavelengths(nm) = samples.bands() else {
        return Err(Error::invalid("", "bands of a table of spectra", "Rec.709", "wavelengths"));
    };
    if samples.len() > MAX_ROWS {
        return Err(Error::invalid("", "rows", samples.len(), format!("up to {MAX_ROWS}")));
    }
    let mut text = String::new();
    comments.lines().for_each(|line| text.extend(["# ", line, "\n"]));
    let is_weighed = samples.samples().iter().any(|sample| sample.weight != 1.0);
    text += if is_weighed { "theta_i,theta_o,weight" } else { "theta_i,theta_o" };
    write_all(&mut text, nm.iter().copied());
    for (k, sample) in samples.samples().iter().enumerate() {
        let reading = Reading::of(sample.wi, sample.wo).filter(|_| sample.lights.is_empty());
        let reading = reading.ok_or_else(|| {
            let found = format!("wi {}, wo {}", sample.wi, sample.wo);
            let legal = "light from one direction, the eye in its plane of incidence";
            Error::invalid(format!("sample {k}"), "directions", found, legal)
        })?;
        // Differences of round angles may have lost their roundness.
        let exit = (reading.theta_o_deg() * 1e12).round() / 1e12;
        text += &format!("{},{exit}", reading.incidence_deg);
        if is_weighed {
            text += &format!(",{}", sample.weight);
        }
        write_all(&mut text, samples.values(k).iter().map(|f| PI * f));
    }
    Ok(text)
}

/// Numbers behind commas, and the end of the line.
fn write_all(text: &mut String, numbers: impl Iterator<Item = f64>) {
    for number in numbers {
        // A string takes all that is written.
        let _ = write!(text, ",{number}");
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::BrdfSample;
    use crate::brdf::multi_angle::parse;
    use crate::math::half_difference::spherical;

    fn set() -> SampleSet {
        let mut set = SampleSet::new(Bands::Wavelengths(vec![380.0, 387.5, 780.0])).unwrap();
        for (k, (incidence, exit)) in
            [(20.0, 20.0), (20.0, 20.0), (65.0, -80.0), (0.1, 33.3)].into_iter().enumerate()
        {
            let (wi, wo) = Reading::between(incidence, exit).unwrap().directions();
            let values = [0.1, 1e-9, 7.3].map(|v| v * (1.0 + 0.37 * k as f64));
            set.push(BrdfSample::new(wi, wo, 1.0), &values).unwrap();
        }
        set
    }

    #[test]
    fn tables_come_back() {
        let set = set();
        let text = multi_angle_text(&set, "made\nfor a test").unwrap();
        let head = "# made\n# for a test\ntheta_i,theta_o,380,387.5,780\n20,20,0.3";
        assert!(text.starts_with(head), "{text}");
        assert!(text.contains("\n65,-80,") && text.contains("\n0.1,33.3,"), "{text}");
        let back = parse(&text).unwrap().samples;
        assert_eq!((back.bands(), back.len()), (set.bands(), set.len()));
        for k in 0..set.len() {
            for (a, b) in set.values(k).iter().zip(back.values(k)) {
                // A multiplication by pi and a division: two roundings.
                assert!((a / b - 1.0).abs() < 1e-15, "{a} {b}");
            }
            let (a, b) = (&set.samples()[k], &back.samples()[k]);
            assert!((a.wi - b.wi).length() < 1e-13 && (a.wo - b.wo).length() < 1e-13);
        }
    }

    #[test]
    fn what_the_table_cannot_say_is_refused() {
        let rgb = SampleSet::new(Bands::Rgb).unwrap();
        assert!(multi_angle_text(&rgb, "").unwrap_err().to_string().contains("Rec.709"));
        let mut set = set();
        set.push(BrdfSample::new(spherical(0.5, 0.0), spherical(0.5, 1.0), 1.0), &[1.0; 3]).unwrap();
        assert!(multi_angle_text(&set, "").unwrap_err().to_string().starts_with("sample 4: directions"));
    }
}

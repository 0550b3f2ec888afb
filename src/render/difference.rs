//! How far two pictures are apart.

use super::flip::flip;
use super::picture::Picture;
use crate::color::{delta_e_2000, lab_from_rgb, srgb_encode};
use crate::error::{Error, Result};
use glam::DVec3;
use serde::Serialize;

/// Differences of two pictures of equal size. The first three are of sRGB-encoded values, on which 1/255 is one step of an
/// eight-bit picture; light above 1 is encoded on, not clipped.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PictureDifference {
    /// Largest absolute difference of a component.
    pub largest: f64,
    /// Mean absolute difference of the components.
    pub mean: f64,
    /// Peak signal to noise ratio, dB, of a peak of 1; infinite for equal pictures.
    pub psnr: f64,
    /// Mean CIEDE2000 difference of the pixels.
    pub delta_e_2000: f64,
    /// Mean FLIP error, 0 to 1, of light clipped to [0, 1], at 67 pixels a degree of the visual field (Andersson et al. 2020).
    pub flip: f64,
}

impl PictureDifference {
    /// Compares two pictures.
    ///
    /// # Errors
    /// Different sizes.
    pub fn of(a: &Picture, b: &Picture) -> Result<Self> {
        if a.size != b.size {
            let [found, legal] = [b, a].map(|p| format!("{} x {}", p.size[0], p.size[1]));
            return Err(Error::invalid(
                "pictures",
                "size of the second",
                found,
                format!("{legal}, as the first"),
            ));
        }
        let (mut largest, mut sum, mut squares, mut delta_e) = (0.0f64, 0.0, 0.0, 0.0);
        for (p, q) in a.pixels.iter().zip(&b.pixels) {
            let [p, q] = [p, q].map(|c| DVec3::from(c.map(f64::from)));
            let difference = (encoded(p) - encoded(q)).abs();
            largest = largest.max(difference.max_element());
            sum += difference.element_sum();
            squares += difference.length_squared();
            delta_e += delta_e_2000(lab_from_rgb(p), lab_from_rgb(q));
        }
        let n = a.pixels.len().max(1) as f64;
        Ok(Self {
            largest,
            mean: sum / (3.0 * n),
            psnr: -10.0 * (squares / (3.0 * n)).log10(),
            delta_e_2000: delta_e / n,
            flip: flip(a, b),
        })
    }
}

fn encoded(rgb: DVec3) -> DVec3 {
    DVec3::from(rgb.to_array().map(srgb_encode))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_of_pictures() {
        let gray = |v: f32| Picture { size: [2, 1], pixels: vec![[v; 3], [0.5; 3]] };
        let same = PictureDifference::of(&gray(0.3), &gray(0.3)).unwrap();
        assert_eq!((same.largest, same.mean, same.delta_e_2000), (0.0, 0.0, 0.0));
        assert_eq!(same.psnr, f64::INFINITY);
        // 0 and 1 in one of two pixels: every measure is known; black to white is 100 in CIEDE2000.
        let far = PictureDifference::of(&gray(0.0), &gray(1.0)).unwrap();
        assert!((far.largest - 1.0).abs() < 1e-12 && (far.mean - 0.5).abs() < 1e-12);
        assert!((far.psnr - 10.0 * 2f64.log10()).abs() < 1e-9);
        assert!((far.delta_e_2000 - 50.0).abs() < 1e-3, "{far:?}");
        assert!(PictureDifference::of(&gray(0.0), &Picture { size: [1, 2], ..gray(0.0) }).is_err());
    }
}

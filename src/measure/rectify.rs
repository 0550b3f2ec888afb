//! From a picture in perspective to the sample's own texels.

use super::PairGeometry;
use glam::DVec2;

/// Most places along the side of a texel at which the picture is looked up.
const MOST_PLACES: usize = 64;

/// Square texels that cover the sample, about the origin; row 0 at the lowest y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sheet {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Side of a texel, millimetres.
    pub texel_mm: f64,
}

impl Sheet {
    /// The texels of this side that lie on a sample whole, at least one.
    pub fn new(sample_mm: [f64; 2], texel_mm: f64) -> Self {
        Self { size: sample_mm.map(|side| ((side / texel_mm) as usize).max(1)), texel_mm }
    }

    /// A place of the sample, millimetres, from columns and rows.
    pub fn place_mm(&self, column: f64, row: f64) -> DVec2 {
        let middle = DVec2::new(self.size[0] as f64, self.size[1] as f64) * 0.5;
        (DVec2::new(column, row) - middle) * self.texel_mm
    }

    /// What the sample shows in every texel: the BRDF, 1/sr, row-major, from the radiance of pixels per unit intensity of the
    /// flash; what [`Sheet::texel`] does not know is no number.
    pub fn rectify(&self, pixels: &[[f32; 3]], size: [usize; 2], pair: &PairGeometry) -> Vec<[f32; 3]> {
        let texel =
            |k: usize| self.texel(pixels, size, pair, k).map_or([f32::NAN; 3], |rgb| rgb.map(|c| c as f32));
        (0..self.size[0] * self.size[1]).map(texel).collect()
    }

    /// What the sample shows in texel `k`: the BRDF, 1/sr. A pixel is even light over its square, so that no light is won or lost.
    /// `None` if half of the texel or more is seen by no pixel, or by pixels that are no numbers.
    pub fn texel(
        &self,
        pixels: &[[f32; 3]],
        size: [usize; 2],
        pair: &PairGeometry,
        k: usize,
    ) -> Option<[f64; 3]> {
        let corner = [(k % self.size[0]) as f64, (k / self.size[0]) as f64];
        let middle = self.place_mm(corner[0] + 0.5, corner[1] + 0.5);
        let places = self.places(pair, middle);
        let mut sum = [0.0; 3];
        let mut seen = 0usize;
        for part in 0..places * places {
            let step = |k: usize| (k as f64 + 0.5) / places as f64;
            let place = self.place_mm(corner[0] + step(part % places), corner[1] + step(part / places));
            if let Some(rgb) = look_up(pixels, size, pair, place) {
                sum.iter_mut().zip(rgb).for_each(|(sum, c)| *sum += f64::from(c));
                seen += 1;
            }
        }
        let irradiance = pair.irradiance(middle, |_| 1.0);
        (2 * seen > places * places).then(|| sum.map(|c| c / (seen as f64 * irradiance)))
    }

    /// Places along the side of a texel at which the picture is looked up: about one a pixel. A mean of parts of pixels would wash
    /// out flakes that are smaller than both: to two thirds of their contrast where texels are as wide as pixels.
    fn places(&self, pair: &PairGeometry, middle: DVec2) -> usize {
        let at = |offset: DVec2| pair.camera.pixel((middle + 0.5 * self.texel_mm * offset).extend(0.0));
        let across = |axis: DVec2| Some(at(axis)?.distance(at(-axis)?));
        let pixels = across(DVec2::X).zip(across(DVec2::Y)).map_or(0.0, |(x, y)| (x * y).sqrt());
        (pixels.round() as usize).clamp(1, MOST_PLACES)
    }
}

/// The pixel that sees a place, if it says a number.
fn look_up(pixels: &[[f32; 3]], size: [usize; 2], pair: &PairGeometry, place: DVec2) -> Option<[f32; 3]> {
    let at = pair.camera.pixel(place.extend(0.0))?;
    if at.cmplt(DVec2::ZERO).any() || at.x >= size[0] as f64 || at.y >= size[1] as f64 {
        return None;
    }
    let pixel = *pixels.get(at.y as usize * size[0] + at.x as usize)?;
    pixel.iter().all(|c| c.is_finite()).then_some(pixel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::projection::{Intrinsics, Pose, Projection};
    use crate::measure::Flash;
    use glam::DVec3;

    fn pair() -> PairGeometry {
        let flash = Flash { offset_mm: [9.0, 0.0], size_mm: [10.0, 7.0], points: [3, 3] };
        let at = |x: f64| Pose::looking_at(DVec3::new(x, -100.0, 600.0), DVec3::ZERO, DVec3::Y);
        let lens = Intrinsics { distortion: [-0.15, 0.0], ..Intrinsics::pinhole(6000.0, [256, 200]) };
        PairGeometry::new(Projection { intrinsics: lens, pose: at(-350.0) }, &flash, &at(200.0))
    }

    /// A picture of a sample with this BRDF, 16 places a pixel.
    fn picture(pair: &PairGeometry, f: impl Fn(DVec2) -> f64) -> Vec<[f32; 3]> {
        let pixel = |k: usize| {
            let mut sum = 0.0;
            for part in 0..16 {
                let offset = DVec2::new(f64::from(part % 4) + 0.5, f64::from(part / 4) + 0.5) / 4.0;
                let at = DVec2::new((k % 256) as f64, (k / 256) as f64) + offset;
                let place = pair.camera.on_plane(at, 0.0).unwrap().truncate();
                sum += f(place) * pair.irradiance(place, |_| 1.0) / 16.0;
            }
            [sum as f32, 2.0 * sum as f32, 0.0]
        };
        (0..256 * 200).map(pixel).collect()
    }

    #[test]
    fn texels_are_where_they_belong_and_keep_their_light() {
        let pair = pair();
        let f = |p: DVec2| 0.3 + 0.02 * p.x - 0.01 * p.y;
        let pixels = picture(&pair, f);
        let sheet = Sheet::new([12.0, 10.0], 0.25);
        assert_eq!(sheet.size, [48, 40]);
        let texels = sheet.rectify(&pixels, [256, 200], &pair);
        for (k, texel) in texels.iter().enumerate() {
            let place = sheet.place_mm((k % 48) as f64 + 0.5, (k / 48) as f64 + 0.5);
            // A pixel is even light: slopes of 0.02 and 0.01 /mm over half a pixel of 0.13 mm at most.
            assert!((f64::from(texel[0]) - f(place)).abs() < 2e-3, "{place} {texel:?}");
            assert!((texel[1] - 2.0 * texel[0]).abs() < 1e-6 && texel[2] == 0.0);
        }
        let mean = texels.iter().map(|t| f64::from(t[0])).sum::<f64>() / texels.len() as f64;
        assert!((mean - 0.3).abs() < 1e-4, "{mean}");
    }

    #[test]
    fn what_is_not_seen_is_not_known() {
        let pair = pair();
        let mut pixels = picture(&pair, |_| 0.3);
        let at = pair.camera.pixel(DVec3::ZERO).unwrap();
        let (x, y) = (at.x as usize, at.y as usize);
        (y - 6..y + 6).for_each(|row| (x - 6..x + 6).for_each(|k| pixels[row * 256 + k][1] = f32::NAN));
        let sheet = Sheet::new([40.0, 10.0], 0.25);
        let texels = sheet.rectify(&pixels, [256, 200], &pair);
        assert!(texels[20 * 160 + 80][0].is_nan(), "hidden");
        assert!(texels[20 * 160][0].is_nan(), "outside the picture");
        assert!((texels[20 * 160 + 90][0] - 0.3).abs() < 1e-4);
    }
}

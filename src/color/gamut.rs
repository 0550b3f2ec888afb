//! Colors that a screen cannot show.

use super::rgb::luminance;
use glam::DVec3;

/// The nearest color of the same hue and luminance that linear Rec.709 within [0, 1] can show: a mixture with the gray of its
/// luminance. What is as bright as white or brighter is white, what is no brighter than black is black.
pub fn into_gamut(rgb: DVec3) -> DVec3 {
    let gray = luminance(rgb);
    if gray.is_nan() || gray <= 0.0 {
        return DVec3::ZERO;
    }
    if gray >= 1.0 {
        return DVec3::ONE;
    }
    let room = |c: f64| match c - gray {
        d if d < 0.0 => gray / -d,
        d if d > 0.0 => (1.0 - gray) / d,
        _ => 1.0,
    };
    let share = rgb.to_array().into_iter().map(room).fold(1.0, f64::min);
    // Rounding leaves nothing outside.
    (gray + share * (rgb - gray)).clamp(DVec3::ZERO, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_can_be_shown_stays_and_the_rest_keeps_its_luminance() {
        let inside = DVec3::new(0.2, 0.0, 1.0);
        assert_eq!(into_gamut(inside), inside);
        for outside in [DVec3::new(-0.2, 0.6, 0.1), DVec3::new(1.7, 0.2, 0.1), DVec3::new(-0.1, 0.3, 1.9)] {
            let shown = into_gamut(outside);
            assert!(shown.min_element() >= 0.0 && shown.max_element() <= 1.0);
            assert!((luminance(shown) - luminance(outside)).abs() < 1e-15);
            // One of them is on the edge: nothing is given away.
            assert!(shown.min_element() < 1e-15 || shown.max_element() > 1.0 - 1e-15);
        }
        assert_eq!(into_gamut(DVec3::splat(3.0)), DVec3::ONE);
        assert_eq!(into_gamut(DVec3::new(0.1, -1.0, 0.1)), DVec3::ZERO);
        assert_eq!(into_gamut(DVec3::NAN), DVec3::ZERO);
    }
}

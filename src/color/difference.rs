//! Color differences between two Lab colors.

use glam::DVec3;

/// CIE 1976: Euclidean distance in Lab.
pub fn delta_e_76(a: DVec3, b: DVec3) -> f64 {
    a.distance(b)
}

/// CIE 1994 with the weights of the graphic arts, `a` the reference.
pub fn delta_e_94(a: DVec3, b: DVec3) -> f64 {
    let chroma_a = a.y.hypot(a.z);
    let chroma = chroma_a - b.y.hypot(b.z);
    let lightness = a.x - b.x;
    let hue_squared = ((a.y - b.y).powi(2) + (a.z - b.z).powi(2) - chroma * chroma).max(0.0);
    let (s_c, s_h) = (1.0 + 0.045 * chroma_a, 1.0 + 0.015 * chroma_a);
    (lightness * lightness + (chroma / s_c).powi(2) + hue_squared / (s_h * s_h)).sqrt()
}

/// CIEDE2000 (CIE 142; Sharma, Wu & Dalal 2005, all weights 1).
///
/// Written out because palette 0.7 takes the mean of two hues that differ by more than 180 degrees and sum to more than 360 a
/// whole turn too high, which the rotation term sees (up to some 1e-5 of the difference).
pub fn delta_e_2000(a: DVec3, b: DVec3) -> f64 {
    let chroma_weight = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let g = 0.5 * (1.0 - chroma_weight(0.5 * (a.y.hypot(a.z) + b.y.hypot(b.z))));
    let polar = |c: DVec3| {
        let a_prime = (1.0 + g) * c.y;
        (a_prime.hypot(c.z), c.z.atan2(a_prime).to_degrees().rem_euclid(360.0))
    };
    let ((c1, h1), (c2, h2)) = (polar(a), polar(b));
    let gray = c1 * c2 == 0.0;
    let turn = match h2 - h1 {
        _ if gray => 0.0,
        d if d > 180.0 => d - 360.0,
        d if d < -180.0 => d + 360.0,
        d => d,
    };
    let hue = match h1 + h2 {
        sum if gray => sum,
        sum if (h1 - h2).abs() <= 180.0 => 0.5 * sum,
        sum if sum < 360.0 => 0.5 * (sum + 360.0),
        sum => 0.5 * (sum - 360.0),
    };
    let (lightness, chroma) = (0.5 * (a.x + b.x), 0.5 * (c1 + c2));
    let cos = |degrees: f64| degrees.to_radians().cos();
    let t = 1.0 - 0.17 * cos(hue - 30.0) + 0.24 * cos(2.0 * hue) + 0.32 * cos(3.0 * hue + 6.0)
        - 0.20 * cos(4.0 * hue - 63.0);
    let fifty = (lightness - 50.0).powi(2);
    let d_l = (b.x - a.x) / (1.0 + 0.015 * fifty / (20.0 + fifty).sqrt());
    let d_c = (c2 - c1) / (1.0 + 0.045 * chroma);
    let d_h = 2.0 * (c1 * c2).sqrt() * (0.5 * turn).to_radians().sin() / (1.0 + 0.015 * chroma * t);
    let rotation = 30.0 * (-((hue - 275.0) / 25.0).powi(2)).exp();
    let r_t = -2.0 * chroma_weight(chroma) * (2.0 * rotation).to_radians().sin();
    (d_l * d_l + d_c * d_c + d_h * d_h + r_t * d_c * d_h).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use palette::color_difference::Ciede2000;
    use palette::{Lab, white_point::D65};

    #[test]
    fn published_pairs() {
        // Sharma, Wu & Dalal 2005, Table 1, pairs 1, 4, 7, 13, 17, 23, 34: four decimals.
        for (a, b, published) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0000),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, -0.001, 2.49], [50.0, 0.0009, -2.49], 4.8045),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([50.0, 2.5, 0.0], [50.0, 1.8634, 0.5757], 1.0000),
            ([2.0776, 0.0795, -1.135], [0.9033, -0.0636, -0.5514], 0.9082),
        ] {
            let ours = delta_e_2000(DVec3::from(a), DVec3::from(b));
            assert!((ours - published).abs() < 0.5e-4, "{a:?} {b:?}: {ours}");
        }
    }

    #[test]
    fn palette_agrees_where_hues_are_near() {
        for k in 0..200 {
            let at = |s: f64| DVec3::new(50.0 + 40.0 * (s * 1.7).sin(), 60.0 * s.sin(), 60.0 * s.cos());
            let (a, b) = (at(f64::from(k)), at(f64::from(k) + 1.5));
            let lab = |c: DVec3| Lab::<D65, f64>::new(c.x, c.y, c.z);
            let theirs = lab(a).difference(lab(b));
            // Where hues straddle 0 palette's mean is off as told above.
            assert!((delta_e_2000(a, b) - theirs).abs() < 1e-4 * theirs, "{k}");
        }
    }
}

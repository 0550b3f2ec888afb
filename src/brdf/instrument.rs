//! Where multi-angle instruments look, and what the trade makes of it.
//!
//! ASTM E2194 and E2539 give directions as angle of incidence and aspecular angle: from the mirror direction, in the plane
//! of incidence, positive towards the light. Light at 45 degrees is then seen at 15 (30 degrees on the mirror side), 45 (along
//! the normal), 110 (65 degrees on the light's side), -15 (60 degrees, beyond the mirror direction).

use crate::error::{Error, Result};
use crate::math::half_difference::spherical;
use glam::DVec3;
use std::f64::consts::PI;

/// One reading of an instrument. Angles in degrees, as the trade writes them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Angle of incidence, 0 to below 90.
    pub incidence_deg: f64,
    /// Aspecular angle; the eye must stay above the horizon.
    pub aspecular_deg: f64,
}

/// What the instruments of ASTM E2194 and E2539 take, incidence and aspecular angle in degrees.
pub const MULTI_ANGLE: [Reading; 8] = {
    const fn at(incidence_deg: f64, aspecular_deg: f64) -> Reading {
        Reading { incidence_deg, aspecular_deg }
    }
    [
        at(45.0, -15.0),
        at(45.0, 15.0),
        at(45.0, 25.0),
        at(45.0, 45.0),
        at(45.0, 75.0),
        at(45.0, 110.0),
        at(15.0, -15.0),
        at(15.0, 15.0),
    ]
};

impl Reading {
    /// Most readings of one list.
    const MAX: usize = 1000;

    /// A reading.
    ///
    /// # Errors
    /// Light or eye not above the horizon.
    pub fn new(incidence_deg: f64, aspecular_deg: f64) -> Result<Self> {
        if !(0.0..90.0).contains(&incidence_deg) {
            return Err(Error::invalid("", "incidence, degrees", incidence_deg, "0 to below 90"));
        }
        let (low, high) = (incidence_deg - 90.0, incidence_deg + 90.0);
        if !(low < aspecular_deg && aspecular_deg < high) {
            let legal = format!("above {low} and below {high} at incidence {incidence_deg}");
            return Err(Error::invalid("", "aspecular angle, degrees", aspecular_deg, legal));
        }
        Ok(Self { incidence_deg, aspecular_deg })
    }

    /// Reads `INCIDENCE:ASPECULAR,ASPECULAR,...` in degrees, groups of other incidences separated by `;`, as in
    /// `45:15,25,45,75,110;15:15`.
    ///
    /// # Errors
    /// A group without incidence or angles, what is no number, a direction not above the horizon, over 1000 readings.
    pub fn parse_list(text: &str) -> Result<Vec<Self>> {
        let number = |text: &str| -> Result<f64> {
            let legal = "INCIDENCE:ASPECULAR,... in degrees, groups separated by ;";
            text.trim().parse().map_err(|_| Error::invalid("", "angle", format!("{text:?}"), legal))
        };
        let mut all = Vec::new();
        for group in text.split(';') {
            let Some((incidence, angles)) = group.split_once(':') else {
                let legal = "an incidence and a colon before its angles, as in 45:15,25,45,75,110";
                return Err(Error::invalid("", "group", format!("{group:?}"), legal));
            };
            let incidence = number(incidence)?;
            for angle in angles.split(',') {
                all.push(Self::new(incidence, number(angle)?)?);
            }
        }
        if all.len() > Self::MAX {
            return Err(Error::invalid("", "readings", all.len(), format!("up to {}", Self::MAX)));
        }
        Ok(all)
    }

    /// The reading of light at `theta_i` seen at `theta_o`, degrees from the normal, theta_o positive on the mirror side.
    ///
    /// # Errors
    /// Light or eye not above the horizon.
    pub fn between(theta_i_deg: f64, theta_o_deg: f64) -> Result<Self> {
        if !(-90.0 < theta_o_deg && theta_o_deg < 90.0) {
            return Err(Error::invalid("", "theta_o, degrees", theta_o_deg, "above -90 and below 90"));
        }
        Self::new(theta_i_deg, theta_i_deg - theta_o_deg)
    }

    /// The reading that two unit directions above the horizon belong to, angles to 1e-12 degrees; None where the eye is out of
    /// the plane of incidence.
    pub fn of(wi: DVec3, wo: DVec3) -> Option<Self> {
        let (across, along) = (wi.truncate().perp_dot(wo.truncate()), wi.truncate().dot(wo.truncate()));
        // A product of sines; a microradian is no instrument's error.
        if across.abs() > 1e-6 {
            return None;
        }
        let degrees = |w: DVec3| (w.truncate().length().atan2(w.z).to_degrees() * 1e12).round() / 1e12;
        let exit = if along > 0.0 { -degrees(wo) } else { degrees(wo) };
        Self::between(degrees(wi), exit).ok()
    }

    /// Polar angle of the eye, degrees, positive on the mirror side.
    pub fn theta_o_deg(&self) -> f64 {
        self.incidence_deg - self.aspecular_deg
    }

    /// Unit directions to the light and to the eye.
    pub fn directions(&self) -> (DVec3, DVec3) {
        let eye = (self.incidence_deg - self.aspecular_deg).to_radians();
        let azimuth = if eye > 0.0 { PI } else { 0.0 };
        (spherical(self.incidence_deg.to_radians(), 0.0), spherical(eye.abs(), azimuth))
    }
}

/// Flop index `2.69 (L*15 - L*110)^1.11 / (L*45)^0.86` of Alman (1987) for light at 45 degrees, from lightnesses at the
/// aspecular angles 15, 45 and 110; 0 for a surface that looks alike from everywhere. None where it is not defined: darker near
/// the mirror direction than far from it, or black in the face.
pub fn flop_index(lightness: [f64; 3]) -> Option<f64> {
    let [near, face, far] = lightness;
    (near >= far && face > 0.0).then(|| 2.69 * (near - far).powf(1.11) / face.powf(0.86))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_counted_from_the_mirror_direction_towards_the_light() {
        let eye = |incidence, aspecular| Reading::new(incidence, aspecular).unwrap().directions().1;
        let mirror = spherical(45f64.to_radians(), PI);
        for aspecular in [-15f64, 0.0, 15.0, 45.0, 75.0, 110.0] {
            // acos near 1 keeps half the digits.
            let angle = mirror.dot(eye(45.0, aspecular)).min(1.0).acos().to_degrees();
            assert!((angle - aspecular.abs()).abs() < 1e-6, "{aspecular}: {angle}");
        }
        // Light comes from +x: at 45 the eye is on the normal, beyond it on the light's side.
        assert!(eye(45.0, 15.0).x < 0.0 && eye(45.0, 110.0).x > 0.0 && eye(45.0, 45.0).x.abs() < 1e-15);
    }

    #[test]
    fn angles_of_directions_are_those_they_were_made_of() {
        for incidence in [0.0, 20.0, 45.5, 89.0] {
            for exit in [-80.0, -20.0, -0.125, 0.0, 33.3, 89.0] {
                let reading = Reading::between(incidence, exit).unwrap();
                let (wi, wo) = reading.directions();
                let back = Reading::of(wi, wo).unwrap();
                // Straight down there is no mirror side.
                let same = if incidence == 0.0 { exit.abs() } else { exit };
                assert!((back.incidence_deg - incidence).abs() < 2e-12, "{reading:?} {back:?}");
                assert!((back.theta_o_deg() - same).abs() < 2e-12, "{reading:?} {back:?}");
            }
        }
        assert_eq!(Reading::of(spherical(0.5, 0.0), spherical(0.5, 3.0)), None);
        assert!(Reading::between(20.0, -90.0).unwrap_err().to_string().contains("theta_o"));
        assert!(Reading::between(f64::NAN, 0.0).is_err() && Reading::between(0.0, f64::NAN).is_err());
    }

    #[test]
    fn lists_are_read_and_bad_ones_named() {
        let list = Reading::parse_list("45:-15, 15,110;15:15").unwrap();
        let expected = [(45.0, -15.0), (45.0, 15.0), (45.0, 110.0), (15.0, 15.0)];
        assert_eq!(list, expected.map(|(i, a)| Reading::new(i, a).unwrap()));
        for (text, word) in [
            ("", "colon"),
            ("45", "colon"),
            ("45:", "angle"),
            ("45:15,,25", "angle"),
            ("45:x", "\"x\""),
            ("45:15;", "colon"),
            ("90:15", "below 90"),
            ("-1:15", "incidence"),
            ("45:-45", "aspecular"),
            ("45:135", "below 135"),
            ("45:nan", "aspecular"),
            ("nan:15", "incidence"),
            ("inf:15", "incidence"),
        ] {
            let message = Reading::parse_list(text).unwrap_err().to_string();
            assert!(message.contains(word), "{text:?}: {message}");
        }
        let long = format!("45:{}", ["15"; 1001].join(","));
        assert!(Reading::parse_list(&long).unwrap_err().to_string().contains("1001"));
    }

    #[test]
    fn the_flop_index_is_the_published_formula() {
        // By logarithms of five digits: ln 2.69 + 1.11 ln 80 - 0.86 ln 50 = 0.98954 + 4.86405 - 3.36434.
        assert!((flop_index([100.0, 50.0, 20.0]).unwrap().ln() - 2.48925).abs() < 2e-5);
        assert_eq!(flop_index([40.0, 40.0, 40.0]), Some(0.0));
        assert_eq!(flop_index([20.0, 50.0, 100.0]), None);
        assert_eq!(flop_index([20.0, 0.0, 1.0]), None);
        assert_eq!(flop_index([f64::NAN, 1.0, 1.0]), None);
    }
}

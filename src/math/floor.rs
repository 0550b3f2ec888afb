//! The largest whole number that is not above a number.

/// As [`f32::floor`], which is a call of a library where the processor's common ground has no instruction for it.
#[inline]
pub fn floor(x: f32) -> f32 {
    // From 2^23 on all are whole; neither they nor what is no number fit an integer.
    if x.abs() < 8_388_608.0 {
        let cut = x as i32 as f32;
        if cut > x { cut - 1.0 } else { cut }
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_floor() {
        let near =
            [0.0f32, 0.5, 1.0, 1.5, 7.0, 8_388_607.5, 8_388_608.0, 1e20, f32::MAX, f32::INFINITY, 1e-40];
        for x in near.into_iter().flat_map(|x| [x, x.next_up(), x.next_down()]).flat_map(|x| [x, -x]) {
            assert_eq!(floor(x), x.floor(), "{x}");
        }
        assert!(floor(f32::NAN).is_nan());
    }
}

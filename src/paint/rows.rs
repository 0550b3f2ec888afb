//! Clusters as rows of an EXR part: one row a slice and level, one pixel a cluster.
//!
//! A probability travels as all 64 bits of its f64, in two integer channels: blends must give back a paint's own
//! probabilities. Channel `p` shows the same number as f32 to any EXR viewer, and is checked against it.

use crate::cluster::Cluster;
use crate::error::{Error, Result};
use crate::file::{Channel, Part};

const CORNERS: [&str; 6] = ["min.L", "min.a", "min.b", "max.L", "max.a", "max.b"];

/// Rows of unequal length in one rectangle: `rows[r][k]` at pixel (k, r), the rest empty.
pub(crate) fn rectangle<T: Copy, V: Copy + Default>(rows: &[&[T]], value: impl Fn(&T) -> V) -> Vec<V> {
    let width = width(rows);
    rows.iter()
        .flat_map(|row| (0..width).map(|k| row.get(k).map_or(V::default(), &value)).collect::<Vec<_>>())
        .collect()
}

fn width<T>(rows: &[&[T]]) -> usize {
    rows.iter().map(|r| r.len()).max().unwrap_or(0).max(1)
}

/// Channels of the probabilities of all rows.
pub(crate) fn probability_channels(rows: &[&[f64]]) -> Vec<Channel> {
    vec![
        Channel::f32("p", rectangle(rows, |p| *p as f32)),
        Channel::u32("p_high", rectangle(rows, |p| (p.to_bits() >> 32) as u32)),
        Channel::u32("p_low", rectangle(rows, |p| p.to_bits() as u32)),
    ]
}

/// Channels of the boxes of all rows: smallest and largest L, a, b.
pub(crate) fn corner_channels(rows: &[&[[[f32; 3]; 2]]]) -> Vec<Channel> {
    CORNERS
        .iter()
        .enumerate()
        .map(|(k, name)| Channel::f32(*name, rectangle(rows, |corners| corners[k / 3][k % 3])))
        .collect()
}

/// A part from channels made of rows like `rows`.
pub(crate) fn part<T>(rows: &[&[T]], channels: Vec<Channel>) -> Part {
    Part { size: [width(rows), rows.len()], channels }
}

/// Probabilities of every row; a row ends at its first zero, and nothing may follow.
///
/// # Errors
/// Missing channels, `p` that contradicts the bits, a number that is not a probability, one behind the end of its row.
pub(crate) fn read_probabilities(part: &Part) -> Result<Vec<Vec<f64>>> {
    let (shown, high, low) = (part.f32("p")?, part.u32("p_high")?, part.u32("p_low")?);
    let [columns, rows] = part.size;
    (0..rows)
        .map(|r| {
            let mut row = Vec::new();
            for k in r * columns..(r + 1) * columns {
                let p = f64::from_bits(u64::from(high[k]) << 32 | u64::from(low[k]));
                let place = || format!("pixel ({}, {r})", k - r * columns);
                if !(0.0..=1.0 + 1e-9).contains(&p) {
                    return Err(Error::invalid(place(), "probability", p, "0 to 1"));
                }
                if p as f32 != shown[k] {
                    let legal = format!("{} (channels p_high, p_low)", p as f32);
                    return Err(Error::invalid(place(), "channel p", shown[k], legal));
                }
                if p > 0.0 && row.len() < k - r * columns {
                    return Err(Error::invalid(place(), "probability behind a zero", p, "0"));
                }
                if p > 0.0 {
                    row.push(p);
                }
            }
            Ok(row)
        })
        .collect()
}

/// Boxes of every row, as many as `lengths` says.
///
/// # Errors
/// Missing channels, or a part smaller than the lengths.
pub(crate) fn read_corners(part: &Part, lengths: &[usize]) -> Result<Vec<Vec<[[f32; 3]; 2]>>> {
    let [columns, rows] = part.size;
    let longest = lengths.iter().copied().max().unwrap_or(0);
    if rows != lengths.len() || columns < longest {
        let legal = format!("{longest} x {} or wider", lengths.len());
        return Err(Error::invalid("", "size", format!("{columns} x {rows}"), legal));
    }
    let channels = CORNERS.iter().map(|name| part.f32(name)).collect::<Result<Vec<_>>>()?;
    let corners = |k: usize| {
        let at = |c: usize| channels[c][k];
        [[at(0), at(1), at(2)], [at(3), at(4), at(5)]]
    };
    Ok(lengths.iter().enumerate().map(|(r, n)| (0..*n).map(|k| corners(r * columns + k)).collect()).collect())
}

/// Channel of the bands between clusters: a row without any is 0.
pub(crate) fn fade_channel(rows: &[&[f32]], like: &[&[f64]]) -> Channel {
    let width = width(like);
    let row = |r: &&[f32]| (0..width).map(|k| r.get(k).copied().unwrap_or(0.0)).collect::<Vec<_>>();
    Channel::f32("fade", rows.iter().flat_map(row).collect())
}

/// Bands of every row, as many as `lengths` says; none where a row has only zeros, or the part no such channel.
///
/// # Errors
/// A channel that does not fill the part.
pub(crate) fn read_fades(part: &Part, lengths: &[usize]) -> Result<Vec<Vec<f32>>> {
    if part.channels.iter().all(|c| c.name != "fade") {
        return Ok(vec![Vec::new(); lengths.len()]);
    }
    let (fades, columns) = (part.f32("fade")?, part.size[0]);
    let row = |(r, n): (usize, &usize)| {
        let row = fades[r * columns..][..*n].to_vec();
        if row.iter().all(|f| *f == 0.0) { Vec::new() } else { row }
    };
    Ok(lengths.iter().enumerate().map(row).collect())
}

/// Clusters from probabilities and boxes.
pub(crate) fn zip(probabilities: Vec<f64>, corners: Vec<[[f32; 3]; 2]>) -> Vec<Cluster> {
    probabilities
        .into_iter()
        .zip(corners)
        .map(|(probability, [min, max])| Cluster { probability, min, max })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::Samples;

    fn sample() -> Part {
        let rows: [&[f64]; 2] = [&[0.25, 1e-300, 0.75], &[1.0]];
        part(&rows, probability_channels(&rows))
    }

    #[test]
    fn probabilities_travel_to_the_bit() {
        assert_eq!(read_probabilities(&sample()).unwrap(), [vec![0.25, 1e-300, 0.75], vec![1.0]]);
    }

    #[test]
    fn a_probability_behind_the_end_of_a_row_is_named() {
        let rows: [&[f64]; 2] = [&[0.25, 0.75, 0.0], &[0.5, 0.0, 0.5]];
        let message = read_probabilities(&part(&rows, probability_channels(&rows))).unwrap_err().to_string();
        assert_eq!(message, "pixel (2, 1): probability behind a zero: found 0.5, expected 0");
    }

    #[test]
    fn bits_that_are_no_probability_or_contradict_p_are_named() {
        for (bits, word) in [(0xbff0_0000u32, "found -1"), (0x7ff8_0000, "NaN"), (0x3fe0_0000, "channel p")] {
            let mut bad = sample();
            let Samples::U32(high) = &mut bad.channels[1].samples else { panic!("integers") };
            high[4] = bits;
            let message = read_probabilities(&bad).unwrap_err().to_string();
            assert!(message.starts_with("pixel (1, 1): ") && message.contains(word), "{message}");
        }
    }

    #[test]
    fn channels_shorter_than_their_part_are_refused() {
        for channel in 0..3 {
            let mut bad = sample();
            match &mut bad.channels[channel].samples {
                Samples::F32(v) => v.truncate(5),
                Samples::U32(v) => v.truncate(5),
                Samples::F16(_) => panic!("no half floats here"),
            }
            let message = read_probabilities(&bad).unwrap_err().to_string();
            assert!(message.contains("samples: found 5, expected 6"), "{message}");
        }
        let mut bad = part(&[&[[[0.0f32; 3]; 2]; 2][..]], corner_channels(&[&[[[0.0; 3]; 2]; 2]]));
        bad.channels[3].samples = Samples::F32(vec![0.0]);
        assert!(read_corners(&bad, &[2]).is_err());
    }
}

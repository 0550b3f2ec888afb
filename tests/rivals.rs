//! Rivals of the statistics: what they promise.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use carpaint::brdf::{ClearCoat, TabulatedBrdf};
use carpaint::btf::{AngleGrid, FlakeBtf, FlakeSlice};
use carpaint::math::hash::{pcg4d, unit};
use carpaint::rivals::{Grouping, Images, Patches, Pca};

const SIZE: [usize; 2] = [6, 5];

fn btf(texel: impl Fn(usize, usize) -> [f32; 3]) -> FlakeBtf {
    let grid = AngleGrid::new(4, vec![4, 3, 1]).unwrap();
    let slice =
        |k| FlakeSlice { fluctuation: (0..30).map(|at| texel(k, at)).collect(), expectation: [0.0; 3] };
    FlakeBtf {
        slices: (0..grid.len()).map(slice).collect(),
        grid,
        size: SIZE,
        texel_mm: 0.05,
        smooth: TabulatedBrdf::new(2, 2, vec![[0.1; 3]; 8]).unwrap(),
        coat: ClearCoat::NONE,
        provenance: serde_json::Value::Null,
    }
}

fn noise(k: usize, at: usize) -> [f32; 3] {
    let [r, g, b, _] = pcg4d([k as u32, at as u32, 3, 4]).map(unit);
    [r - 0.5, 2.0 * g - 1.0, b - 0.5]
}

fn energy(btf: &FlakeBtf) -> f64 {
    btf.slices.iter().flat_map(|s| s.fluctuation.as_flattened()).map(|v| f64::from(*v).powi(2)).sum()
}

fn error(btf: &FlakeBtf, pca: &Pca, components: usize) -> f64 {
    let of = |k: usize| {
        let rebuilt = pca.slice(k, components).unwrap();
        let pairs = rebuilt.as_flattened().iter().zip(btf.slices[k].fluctuation.as_flattened());
        pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>()
    };
    (0..btf.slices.len()).map(of).sum()
}

#[test]
fn all_components_give_the_slices_back_and_fewer_the_best_of_their_rank() {
    let btf = btf(noise);
    let total = energy(&btf);
    for images in [Images::Color, Images::Gray] {
        for grouping in [Grouping::Row, Grouping::All] {
            let pca = Pca::new(&btf, grouping, images, 100).unwrap();
            // Half floats: 2^-11 of images and of coefficients.
            assert!(error(&btf, &pca, 100) < 1e-6 * total);
            let errors: Vec<f64> = (0..25).map(|n| error(&btf, &pca, n)).collect();
            assert!((errors[0] / total - 1.0).abs() < 1e-12);
            assert!(errors.windows(2).all(|pair| pair[1] < pair[0] + 1e-6 * total), "{errors:?}");
        }
    }
    // Eckart-Young: what rank 3 leaves is the sum of the other squared singular values.
    let rows: Vec<f64> =
        btf.slices.iter().flat_map(|s| s.fluctuation.as_flattened()).map(|v| f64::from(*v)).collect();
    let singular = nalgebra::DMatrix::from_row_slice(8, 90, &rows).singular_values();
    let left: f64 = singular.iter().skip(3).map(|s| s * s).sum();
    let pca = Pca::new(&btf, Grouping::All, Images::Color, 8).unwrap();
    assert!((error(&btf, &pca, 3) / left - 1.0).abs() < 1e-5);
    assert!(pca.slice(8, 1).is_none() && Pca::new(&btf, Grouping::All, Images::Color, 0).is_err());
}

#[test]
fn slices_that_are_one_image_take_one_component_and_its_bytes() {
    let btf = btf(|k, at| noise(0, at).map(|v| v * (k + 1) as f32));
    let total = energy(&btf);
    let pca = Pca::new(&btf, Grouping::All, Images::Color, 8).unwrap();
    // Half floats, as above.
    assert!(error(&btf, &pca, 1) < 1e-6 * total);
    // Two bytes for each of 90 numbers of the image and of 8 coefficients.
    assert_eq!(pca.bytes(1), 2 * (90 + 8));
    let gray = Pca::new(&btf, Grouping::All, Images::Gray, 24).unwrap();
    assert_eq!(gray.bytes(3), 2 * 3 * (30 + 24));
    assert!(error(&btf, &gray, 3) < 1e-6 * total, "three channels, three images");
    // Rows of 4, 3 and 1 slices have no more components than slices.
    let rows = Pca::new(&btf, Grouping::Row, Images::Color, 3).unwrap();
    assert_eq!(rows.bytes(25), 2 * (3 * 94 + 3 * 93 + 91));
}

#[test]
fn patches_are_copies_from_the_same_places_in_every_slice() {
    let size = [37, 20];
    let patches = Patches::new([12, 9], size, 4, 7).unwrap();
    let piece: Vec<[f32; 3]> = (0..108).map(|k| [k as f32, 0.0, 0.0]).collect();
    let surface = patches.surface(&piece).unwrap();
    for y in 0..size[1] {
        for x in 0..size[0] {
            let (here, corner) = (surface[y * size[0] + x][0], surface[(y & !3) * size[0] + (x & !3)][0]);
            // The piece's own neighbors within a patch.
            assert_eq!(here - corner, ((y & 3) * 12 + (x & 3)) as f32);
            assert!(corner as usize % 12 <= 8 && corner as usize / 12 <= 5, "patches lie inside the piece");
        }
    }
    let negative: Vec<[f32; 3]> = piece.iter().map(|t| t.map(|v| -v)).collect();
    let other = patches.surface(&negative).unwrap();
    assert!(other.iter().zip(&surface).all(|(a, b)| a[0] == -b[0]));
    let corners: std::collections::BTreeSet<u32> = surface.iter().map(|t| t[0] as u32).collect();
    assert!(corners.len() > 60, "many places are used");
    assert_eq!(patches.bytes(), 4 * 10 * 5);
    assert_eq!(patches, Patches::new([12, 9], size, 4, 7).unwrap());
    assert_ne!(patches, Patches::new([12, 9], size, 4, 8).unwrap());
    assert!(Patches::new([3, 9], size, 4, 7).is_err() && Patches::new([12, 9], [0, 1], 4, 7).is_err());
    assert!(patches.surface(&piece[1..]).is_none());
}

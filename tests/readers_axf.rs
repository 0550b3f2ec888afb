//! AxF-like folders: round trips, quirks of the format, hostile folders.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use carpaint::brdf::cook_torrance::brightness;
use carpaint::brdf::{ClearCoat, ColorTable, Lobe, LobeGeometry, TabulatedBrdf};
use carpaint::btf::axf::{AxfFolder, AxfSmooth, write_axf_folder};
use carpaint::btf::{AngleGrid, FlakeBtf, FlakeSlice, FlakeSource};
use carpaint::file::write_picture_exr;
use carpaint::math::half_difference::{HalfDifference, directions};
use glam::DVec3;
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;
use std::path::Path;
use tempfile::TempDir;

const SIZE: [usize; 2] = [4, 3];

fn lobe(coefficient: f64, roughness: f64, f0: f64) -> Lobe {
    Lobe { coefficient, roughness, f0 }
}

/// A smooth part whose colors differ from texel to texel.
fn smooth(coat: ClearCoat) -> AxfSmooth {
    let texels = (0..64).map(|k| [0.5 + 0.01 * k as f32, 1.0, 2.5 - 0.02 * k as f32]).collect();
    AxfSmooth {
        coat,
        diffuse: 0.08,
        lobes: vec![lobe(0.2, 0.4, 0.1), lobe(0.1, 0.15, 0.5), lobe(0.05, 0.05, 0.9)],
        colors: ColorTable::new([8, 8], texels, vec![true; 64]).unwrap(),
    }
}

/// What the model says from outside, written out.
fn outside(smooth: &AxfSmooth, wi: DVec3, wo: DVec3, flakes: DVec3) -> DVec3 {
    let (inner_i, inner_o) = (smooth.coat.inner(wi), smooth.coat.inner(wo));
    let angles = HalfDifference::of(inner_i, inner_o);
    let chi = smooth.colors.sample(angles.theta_h as f32, angles.theta_i as f32).map(f64::from);
    let ct = brightness(smooth.diffuse, &smooth.lobes, &LobeGeometry::of(inner_i, inner_o));
    (DVec3::from(chi) * ct + flakes) * smooth.coat.transmittance(wi.z, wo.z)
}

/// A texel of stored slice `k`: signed, and different everywhere.
fn flake(k: usize, texel: usize) -> [f32; 3] {
    let x = (k * 37 + texel * 11) % 29;
    [x as f32 * 0.125 - 1.0, x as f32 * 0.0625, 0.25 - x as f32 * 0.03125]
}

/// A folder of slices as told by `rows`, with the JSON as `change` leaves it.
fn folder(rows: &[usize], change: impl Fn(&mut Value)) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let count: usize = rows.iter().sum();
    let texels = SIZE[0] * SIZE[1];
    for k in 0..count {
        let slice: Vec<_> = (0..texels).map(|texel| flake(k, texel)).collect();
        write_picture_exr(&folder.path().join(format!("{k}.exr")), SIZE, &slice).unwrap();
    }
    let part = smooth(ClearCoat::NONE);
    write_picture_exr(&folder.path().join("colors.exr"), [8, 8], part.colors.texels()).unwrap();
    let mut lut: Vec<usize> = (0..rows.len()).map(|j| rows[..j].iter().sum()).collect();
    lut.resize(64, 0);
    let lobes = |value: fn(&Lobe) -> f64| part.lobes.iter().map(value).collect::<Vec<_>>();
    let mut json = json!({
        "num_thetaF": 4, "num_thetaI": 4, "max_thetaI": rows.len(), "thetaFI_sliceLUT": lut,
        "CT_coeffs": lobes(|l| l.coefficient), "CT_F0s": lobes(|l| l.f0), "CT_spreads": lobes(|l| l.roughness),
        "CT_diffuse": part.diffuse, "IOR": 1.5, "cc_no_refraction": 1,
        "BRDFcolors": "colors.exr", "BTFflakes": (0..count).map(|k| format!("{k}.exr")).collect::<Vec<_>>(),
        "size_mm": [0.4, 0.3], "cosine_included": false,
    });
    change(&mut json);
    std::fs::write(folder.path().join("axf.json"), json.to_string()).unwrap();
    folder
}

const ROWS: [usize; 4] = [4, 3, 2, 1];

/// Sum of fluctuation and expectation of a texel.
fn texel(source: &dyn FlakeSource, k: usize, texel: usize) -> DVec3 {
    let slice = source.slice(k).unwrap();
    DVec3::from(slice.fluctuation[texel].map(f64::from)) + DVec3::from(slice.expectation)
}

fn wide(rgb: [f32; 3]) -> DVec3 {
    DVec3::from(rgb.map(f64::from))
}

#[test]
fn slices_are_what_the_model_says_from_outside() {
    let part = smooth(ClearCoat::ideal(1.5, false));
    for cosine in [false, true] {
        // The end of the table left at 0, as in files seen: the number of slices is meant.
        let folder = folder(&ROWS, |json| json["cosine_included"] = cosine.into());
        let read = AxfFolder::open(folder.path()).unwrap();
        assert_eq!(read.smooth_part(), &part);
        assert_eq!((read.grid(), read.size()), (&AngleGrid::triangle(4).unwrap(), SIZE));
        assert!((read.texel_mm() - 0.1).abs() < 1e-15);
        for k in 0..10 {
            let (theta_h, theta_i) = read.grid().angles(k);
            let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
            for at in 0..12 {
                let flakes = wide(flake(k, at)) / if cosine { wi.z } else { 1.0 };
                let expected = outside(&part, wi, wo, flakes);
                // f32 storage.
                assert!(
                    (texel(&read, k, at) - expected).abs().max_element() < 2e-6 * (1.0 + expected.length())
                );
            }
            // Zero mean, and the smooth part carries that of the slices.
            let slice = read.slice(k).unwrap();
            let sum: DVec3 = slice.fluctuation.iter().map(|t| wide(*t)).sum();
            assert!(sum.abs().max_element() < 1e-5, "{sum}");
            let mean = (0..12).map(|at| wide(flake(k, at))).sum::<DVec3>() / 12.0;
            let mean = outside(&part, wi, wo, mean / if cosine { wi.z } else { 1.0 });
            assert!((DVec3::from(slice.expectation) - mean).length() < 1e-12 * (1.0 + mean.length()));
        }
    }
}

#[test]
fn under_refraction_slices_are_mixed_at_inner_angles() {
    let folder = folder(&ROWS, |json| json["cc_no_refraction"] = 0.into());
    let read = AxfFolder::open(folder.path()).unwrap();
    let part = smooth(ClearCoat::ideal(1.5, true));
    assert_eq!(read.smooth_part(), &part);
    assert!(!read.coat().refracts, "angles are outer ones");
    let stored = AngleGrid::triangle(4).unwrap();
    for k in 0..read.grid().len() {
        let (theta_h, theta_i) = read.grid().angles(k);
        let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
        let inner = HalfDifference::of(part.coat.inner(wi), part.coat.inner(wo));
        let taps = stored.taps(inner.theta_h as f32, inner.theta_i as f32);
        let flakes =
            taps.iter().filter_map(|(slice, weight)| Some(wide(flake((*slice)?, 5)) * f64::from(*weight)));
        let expected = outside(&part, wi, wo, flakes.sum());
        // The grid's own taps are f32: some 1e-6 of a bin.
        assert!((texel(&read, k, 5) - expected).length() < 2e-5 * (1.0 + expected.length()), "slice {k}");
    }
}

#[test]
fn an_offset_of_half_a_bin_mixes_neighbors() {
    let folder = folder(&ROWS, |json| json["bin_offset"] = 0.5.into());
    let read = AxfFolder::open(folder.path()).unwrap();
    let part = smooth(ClearCoat::ideal(1.5, false));
    // Theta_F = theta_I = 0: slices (0, 0), (1, 0), (0, 1), (1, 1), numbers 0, 1, 4 and 5, a quarter each.
    let quarter = [0, 1, 4, 5].iter().map(|k| wide(flake(*k, 7))).sum::<DVec3>() / 4.0;
    let expected = outside(&part, DVec3::Z, DVec3::Z, quarter);
    assert!((texel(&read, 0, 7) - expected).length() < 1e-5);
}

#[test]
fn a_btf_survives_the_round_trip() {
    let grid = AngleGrid::new(6, vec![4, 4, 3, 2]).unwrap();
    let coat = ClearCoat::ideal(1.45, false);
    let slice = |k: usize| {
        let texels: Vec<DVec3> = (0..12).map(|at| wide(flake(k + 3, at))).collect();
        let mean = texels.iter().sum::<DVec3>() / 12.0;
        let fluctuation = texels.iter().map(|t| (t - mean).as_vec3().to_array()).collect();
        FlakeSlice { fluctuation, expectation: [0.3, 0.1 * k as f64, 1.0] }
    };
    let btf = FlakeBtf {
        slices: (0..grid.len()).map(slice).collect(),
        grid,
        size: SIZE,
        texel_mm: 0.05,
        smooth: TabulatedBrdf::new(2, 2, vec![[0.1; 3]; 8]).unwrap(),
        coat,
        provenance: Value::Null,
    };
    let folder = tempfile::tempdir().unwrap();
    let part = smooth(coat);
    write_axf_folder(&btf, &part, folder.path()).unwrap();
    let read = AxfFolder::open(folder.path()).unwrap();
    assert_eq!((read.smooth_part(), read.grid(), read.size()), (&part, &btf.grid, btf.size));
    assert!((read.texel_mm() - 0.05).abs() < 1e-12);
    for k in 0..btf.grid.len() {
        for at in 0..12 {
            let (one, two) = (texel(&btf, k, at), texel(&read, k, at));
            // A gloss-like lobe of some 100 passes through f32.
            assert!((one - two).length() < 1e-4, "slice {k}: {one} {two}");
        }
    }
    let refracting = AxfSmooth { coat: ClearCoat::ideal(1.5, true), ..part };
    assert!(write_axf_folder(&btf, &refracting, folder.path()).is_err());
}

#[test]
fn hostile_folders_are_refused() {
    let message = |change: &dyn Fn(&mut Value)| {
        let folder = folder(&ROWS, change);
        AxfFolder::open(folder.path()).err().expect("refused").to_string()
    };
    let set = |key: &'static str, value: Value| message(&move |json: &mut Value| json[key] = value.clone());
    assert!(
        set("num_thetaI", 2.into()).contains("num_thetaI: found 2, expected 4 (num_thetaF) (not supported)")
    );
    assert!(set("max_thetaI", 0.into()).contains("max_thetaI"));
    assert!(set("max_thetaI", 65.into()).contains("max_thetaI"));
    assert!(set("thetaFI_sliceLUT", json!([0, 4, 3, 9, 10])).contains("thetaFI_sliceLUT"));
    assert!(set("thetaFI_sliceLUT", json!([0, 4, 7, 9, 11])).contains("thetaFI_sliceLUT"));
    assert!(set("thetaFI_sliceLUT", json!([0, 0, 7, 9, 10])).contains("row 0"));
    assert!(set("thetaFI_sliceLUT", json!([0, 5, 7, 9, 10])).contains("row 0: slices: found 5"));
    assert!(set("num_thetaF", json!(1e9)).contains("num_thetaF"));
    assert!(set("CT_coeffs", json!([0.1])).contains("[1, 3, 3]"));
    assert!(set("CT_spreads", json!([0.1, 0.0, 0.1])).contains("lobe 1: lobe: roughness"));
    assert!(set("CT_diffuse", json!(1e300)).contains("CT_diffuse"));
    assert!(set("IOR", json!(0.5)).contains("ior"));
    assert!(set("cc_no_refraction", json!(2)).contains("cc_no_refraction"));
    assert!(set("bin_offset", json!(-1)).contains("bin_offset"));
    assert!(set("size_mm", json!([0.4, 0.4])).contains("texel"));
    assert!(set("size_mm", json!([0.0, 0.0])).contains("texel_mm"));
    assert!(set("color_space", json!("CMYK")).contains("color_space"));
    assert!(set("BTFflakes", json!([])).contains("thetaFI_sliceLUT"));
    assert!(set("BRDFcolors", json!("../colors.exr")).contains("a file in the same folder"));
    assert!(set("BRDFcolors", json!("none.exr")).contains("none.exr"));
    assert!(set("unknown", json!(1)).contains("unknown"));
    let folder = folder(&ROWS, |_| ());
    write_picture_exr(&folder.path().join("3.exr"), [2, 2], &[[0.0; 3]; 4]).unwrap();
    let message = |path: &Path| AxfFolder::open(path).err().expect("refused").to_string();
    assert!(message(folder.path()).contains("3.exr: size: found [2, 2]"));
    let json = folder.path().join("axf.json");
    let text = std::fs::read_to_string(&json).unwrap();
    for length in 0..text.len() {
        std::fs::write(&json, &text[..length]).unwrap();
        assert!(AxfFolder::open(folder.path()).is_err(), "{length} bytes of JSON were accepted");
    }
    assert!(message(&folder.path().join("nowhere")).contains("axf.json"));
}

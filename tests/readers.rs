//! Readers of measured BRDFs: files written from known functions, other programs' numbers, hostile files.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

mod common;
#[path = "common/tensor.rs"]
mod tensor;

use carpaint::brdf::rgl::RglBrdf;
use carpaint::brdf::{Bands, Measurement, SampleSet, merl, read_samples};
use carpaint::math::half_difference::spherical;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use tensor::{Field, floats, spectral_fields, tensor_bytes};

const THETA: usize = 90;
const PHI: usize = 180;
const CELLS: usize = THETA * THETA * PHI;

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// A MERL file of what a function gives for the index of a cell.
fn merl_file(folder: &TempDir, value: impl Fn(usize) -> [f64; 3]) -> PathBuf {
    let path = folder.path().join("a.binary");
    let mut bytes: Vec<u8> = [90i32, 90, 180].iter().flat_map(|n| n.to_le_bytes()).collect();
    for channel in 0..3 {
        bytes.extend((0..CELLS).flat_map(|cell| value(cell)[channel].to_le_bytes()));
    }
    std::fs::write(&path, bytes).unwrap();
    path
}

/// Half and difference angles by the steps in which the database's own look-up is described: turn the light by -phi_h about the
/// normal, then by -theta_h about y.
fn half_difference(wi: DVec3, wo: DVec3) -> [f64; 3] {
    let h = (wi + wo).normalize();
    let (theta_h, phi_h) = (h.z.min(1.0).acos(), h.y.atan2(h.x));
    let turned = glam::DMat3::from_rotation_y(-theta_h) * (glam::DMat3::from_rotation_z(-phi_h) * wi);
    let phi_d = turned.y.atan2(turned.x);
    [theta_h, turned.z.min(1.0).acos(), if phi_d < 0.0 { phi_d + PI } else { phi_d }]
}

#[test]
fn a_merl_cell_is_where_the_database_looks_it_up() {
    let folder = folder();
    // 1500, 1500/1.15, 1500/1.66: the number of the cell itself.
    let path = merl_file(&folder, |cell| [1500.0, 1500.0 / 1.15, 1500.0 / 1.66].map(|s| s * cell as f64));
    let read = read_samples(&path).unwrap();
    let samples = &read.samples;
    assert!(samples.len() <= 1 << 18 && samples.len() > 100_000, "{}", samples.len());
    for (k, sample) in samples.samples().iter().enumerate() {
        let [h, d, p] = half_difference(sample.wi, sample.wo);
        let floor = |position: f64, n: usize| (position as usize).min(n - 1);
        let (h, d) = (floor(90.0 * (h / FRAC_PI_2).sqrt(), 90), floor(90.0 * d / FRAC_PI_2, 90));
        let cell = floor(180.0 * p / PI, 180) + PHI * (d + THETA * h);
        for value in samples.values(k) {
            assert!((value - cell as f64).abs() < 1e-9 * cell as f64 + 1e-9, "{value} is not {cell}");
        }
    }
    let counts = read.counts;
    assert_eq!(counts.found, counts.below_horizon + counts.thinned + counts.invalid + samples.len());
    // The solid angles: 2 pi x 2 pi for light and eye above the horizon, of which a cell has 8 pi^2/180 of its weight, six
    // times with five of six left out. Cells that the horizon cuts are in or out as a whole: 1 %.
    let sum: f64 = samples.samples().iter().map(|s| s.weight).sum();
    assert!((sum * 8.0 * PI * PI / 180.0 * 6.0 / (4.0 * PI * PI) - 1.0).abs() < 0.01, "{sum}");
}

#[test]
fn merl_values_are_scaled_and_bad_ones_left_out() {
    let folder = folder();
    let path = merl_file(&folder, |cell| match cell % 180 {
        3 => [-1.0; 3],
        9 => [f64::NAN, 0.0, 0.0],
        _ => [3.0; 3],
    });
    let read = read_samples(&path).unwrap();
    // 3/1500, 3 x 1.15/1500, 3 x 1.66/1500.
    let expected = [0.002, 0.0023, 0.00332];
    for k in 0..read.samples.len() {
        let values = read.samples.values(k);
        assert!(values.iter().zip(expected).all(|(v, e)| (v - e).abs() < 1e-15), "{values:?}");
    }
    assert!(read.counts.invalid > 8100 && read.counts.zero == 0);
    assert!(read.warnings().iter().any(|w| w.contains("invalid")), "{:?}", read.warnings());
    // All zero is read, and said; all invalid is nothing to fit.
    let zero = read_samples(&merl_file(&folder, |_| [0.0; 3])).unwrap();
    assert_eq!(zero.counts.zero, zero.samples.len());
    let message = read_samples(&merl_file(&folder, |_| [-1.0; 3])).unwrap_err().to_string();
    assert!(message.contains("usable samples"), "{message}");
}

#[test]
fn merl_files_are_told_by_size_dimensions_and_hash() {
    let folder = folder();
    let path = merl_file(&folder, |_| [1.0; 3]);
    let list = folder.path().join("list.txt");
    // sha256sum of this file.
    let hash = HASH_OF_ONES;
    std::fs::write(&list, format!("{} 34992012 other\n{hash} 34992012 ones\n", "0".repeat(64))).unwrap();
    assert_eq!(merl::known_merl(&path, &list).unwrap(), "ones");
    let mut bytes = std::fs::read(&path).unwrap();
    let refused = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read_samples(&path).unwrap_err().to_string()
    };
    assert!(refused(&bytes[..34_992_011]).contains("length: found 34992011 bytes"));
    bytes[0] = 89;
    assert!(refused(&bytes).contains("[89, 90, 180]"));
    let message = merl::known_merl(&path, &list).unwrap_err().to_string();
    assert!(message.contains("SHA-256") && message.contains("list.txt"), "{message}");
    std::fs::write(&list, "what\n").unwrap();
    assert!(merl::known_merl(&path, &list).unwrap_err().to_string().contains("line 1"));
    if let Some(list) = common::reference("data/tables/merl100_sha256.txt") {
        assert!(
            merl::known_merl(&path, &list).unwrap_err().to_string().contains("one of"),
            "read to its end"
        );
    }
}

/// Of a MERL file whose every number is 1.0.
const HASH_OF_ONES: &str = "7bd451553f90d5b306c2be9206f8962b8195b932dc292670d2911b6e88ff156f";

#[test]
fn half_angle_tables_are_in_the_order_of_their_description() {
    let folder = folder();
    let path = folder.path().join("paint.bin");
    let mut bytes = vec![7; 84];
    for p in 0..PHI {
        for h in 0..THETA {
            for d in 0..THETA {
                let rgb = if p == 9 { [-1.0; 3] } else { [p as f32, h as f32, d as f32] };
                bytes.extend(rgb.iter().flat_map(|c| c.to_le_bytes()));
            }
        }
    }
    std::fs::write(&path, &bytes).unwrap();
    let read = read_samples(&path).unwrap();
    for (k, sample) in read.samples.samples().iter().enumerate() {
        let [h, d, p] = half_difference(sample.wi, sample.wo).map(|angle| angle.to_degrees());
        // Middles of bins of one degree; acos near 1 keeps half the digits.
        for (angle, bin) in [p, h, d].iter().zip(read.samples.values(k)) {
            assert!((angle - bin - 0.5).abs() < 1e-5, "{angle} {bin}");
        }
    }
    assert!(read.counts.invalid > 1000);
    std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    assert!(carpaint::brdf::half_angle::read_half_angle(&path).is_err());
}

fn write(folder: &TempDir, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join("a.bsdf");
    std::fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn an_rgl_file_means_what_mitsuba_makes_of_it() {
    let folder = folder();
    let brdf = RglBrdf::read(&write(&folder, &tensor_bytes(&spectral_fields()))).unwrap();
    // Mitsuba 3's `measured` on this very file (with a description added), `eval` over the cosine of the eye; light and eye as
    // polar angle and azimuth.
    let theirs = [
        ([0.5, 0.0, 0.3, 1.0], [1.321421, 1.958215, 0.8090284, 1.587865]),
        ([0.2, 0.7, 0.9, 2.9], [1.36707, 0.9461841, 1.411024, 1.520598]),
        ([1.2, -2.0, 1.1, 1.3], [3.068547, 2.367566, 2.926016, 2.585046]),
        ([0.75, 0.0, 0.75, PI], [2.52173, 2.114447, 1.707165, 1.749768]),
        ([1.0, 1.0, 0.05, -2.5], [1.253736, 1.14019, 1.861357, 1.602429]),
        ([1.45, 0.3, 1.3, 3.0], [5.08943, 8.910017, 3.066521, 6.396999]),
    ];
    for ([theta_i, phi_i, theta_o, phi_o], expected) in theirs {
        let ours = brdf.eval(spherical(theta_i, phi_i), spherical(theta_o, phi_o));
        for (a, b) in ours.iter().zip(expected) {
            // They work in f32: some 1e-7 in the angles, times slopes of the warp and of the pattern.
            assert!((a / b - 1.0).abs() < 2e-5, "{theta_i} {theta_o}: {ours:?} {expected:?}");
        }
    }
}

/// A lobe about the mirror direction upon a diffuse ground.
fn lobe(wi: DVec3, wo: DVec3) -> f64 {
    let h = (wi + wo).normalize();
    0.1 + 0.5 * (-(1.0 - h.z * h.z) / (h.z * h.z * 0.16)).exp() / (wi.z + wo.z)
}

/// The fields of a material of 33 x 33 nodes; the warp follows a lobe.
fn smooth_fields(values: &[f32]) -> Vec<Field> {
    let angles: Vec<f32> = (0..9).map(|k| 0.15 * k as f32).collect();
    let vndf = (0..9 * 16 * 24).map(|k| 0.5 + (-8.0 * (f64::from(k % 24) / 23.0).powi(4)).exp() as f32);
    vec![
        floats("phi_i", &[1], [0.0]),
        floats("theta_i", &[9], angles),
        floats("ndf", &[2, 64], (0..128).map(|k| 1.5 - 0.01 * (k % 64) as f32)),
        floats("sigma", &[2, 2], [0.8, 0.4, 0.8, 0.4]),
        floats("vndf", &[1, 9, 16, 24], vndf),
        floats("rgb", &[1, 9, 3, 33, 33], values.iter().copied()),
        Field("jacobian", 1, vec![1], vec![1]),
    ]
}

#[test]
fn a_known_brdf_comes_back_from_its_nodes_and_between_them() {
    let folder = folder();
    const NODES: usize = 33 * 33;
    // With S = 1 + node, of which only the factor of the first is looked at, samples say where nodes are.
    let ones = read_samples(&write(&folder, &tensor_bytes(&smooth_fields(&vec![1.0; 27 * NODES])))).unwrap();
    let mut values = vec![f32::NAN; 27 * NODES];
    // Samples come in the order of the nodes, those below the horizon left out: numbered by a file that is S = number.
    let numbers: Vec<f32> = (0..27 * NODES).map(|k| (k / (3 * NODES) * NODES + k % NODES) as f32).collect();
    let numbered = read_samples(&write(&folder, &tensor_bytes(&smooth_fields(&numbers)))).unwrap();
    for (k, sample) in ones.samples.samples().iter().enumerate() {
        let factor = ones.samples.values(k)[0];
        let number = (numbered.samples.values(k)[0] / factor).round() as usize;
        for c in 0..3 {
            let at = (number / NODES * 3 + c) * NODES + number % NODES;
            values[at] = ((c + 1) as f64 * lobe(sample.wi, sample.wo) / factor) as f32;
        }
    }
    // Where nodes lie below the horizon nothing is known: the nearest known serves interpolation.
    for k in 1..values.len() {
        if values[k].is_nan() {
            values[k] = values[k - 1];
        }
    }
    values.iter_mut().filter(|v| v.is_nan()).for_each(|v| *v = 0.0);
    let path = write(&folder, &tensor_bytes(&smooth_fields(&values)));
    let read = read_samples(&path).unwrap();
    assert_eq!(read.samples.bands(), &Bands::Rgb);
    for (k, sample) in read.samples.samples().iter().enumerate() {
        let green = read.samples.values(k)[1];
        // f32 storage.
        assert!((green / (2.0 * lobe(sample.wi, sample.wo)) - 1.0).abs() < 1e-6, "{k}");
    }
    let brdf = RglBrdf::read(&path).unwrap();
    for k in 0..200 {
        let at = |n: usize, range: f64| (k * n % 101) as f64 / 101.0 * range;
        let (wi, wo) = (spherical(at(37, 1.1), at(11, 6.0)), spherical(at(53, 1.1), at(71, 6.0)));
        let ratio = brdf.eval(wi, wo)[2] / (3.0 * lobe(wi, wo));
        // Bilinear between nodes of some 3 degrees and angles of incidence of 9 of a lobe 20 degrees wide.
        assert!((ratio - 1.0).abs() < 0.08, "{wi} {wo}: {ratio}");
    }
    // The lobe is reciprocal; what interpolation leaves of that.
    assert!(read.reciprocity.unwrap() < 0.02, "{:?}", read.reciprocity);
    assert!(!read.warnings().iter().any(|w| w.contains("reciprocal")), "{:?}", read.warnings());
}

#[test]
fn nodes_of_an_even_warp_share_the_hemispheres() {
    let folder = folder();
    let mut fields = smooth_fields(&vec![1.0; 27 * 33 * 33]);
    fields[4] = floats("vndf", &[1, 9, 2, 2], [1.0; 36]);
    let read = read_samples(&write(&folder, &tensor_bytes(&fields))).unwrap();
    // All solid angles together: the hemisphere of the light, a share of 1, times that of the eye over 2 pi. Nodes whose cells the
    // horizon cuts, up to 5.6 degrees of the normal wide, are in or out as a whole.
    let sum: f64 = read.samples.samples().iter().map(|s| s.weight).sum();
    assert!((sum - 1.0).abs() < 0.03, "{sum}");
}

#[test]
fn hostile_rgl_files_are_refused() {
    let folder = folder();
    let good = tensor_bytes(&spectral_fields());
    assert_eq!(read_samples(&write(&folder, &good)).unwrap().samples.bands().len(), 4);
    // The header ends where the data of the first field begin.
    let header = 18 + spectral_fields().iter().map(|f| 13 + f.0.len() + 8 * f.2.len()).sum::<usize>();
    for length in (0..header).chain((header..good.len()).step_by(97)).chain([good.len() - 1]) {
        assert!(read_samples(&write(&folder, &good[..length])).is_err(), "{length} bytes were accepted");
    }
    for at in 0..header {
        for byte in [0, 0x7f, 0xff] {
            let mut bytes = good.clone();
            bytes[at] = byte;
            // Any answer but a panic or an allocation beyond the caps: some bytes (a wavelength's place) do no harm.
            let _ = read_samples(&write(&folder, &bytes));
        }
    }
    let refused = |change: &dyn Fn(&mut Vec<Field>)| {
        let mut fields = spectral_fields();
        change(&mut fields);
        read_samples(&write(&folder, &tensor_bytes(&fields))).unwrap_err().to_string()
    };
    let nan = f32::NAN.to_le_bytes();
    assert!(
        refused(&|f| f[3].3[..4].copy_from_slice(&nan)).contains("field ndf: number 0: value: found NaN")
    );
    assert!(refused(&|f| f[5].3[4..8].copy_from_slice(&nan)).contains("field vndf: number 1"));
    assert!(refused(&|f| f[1].3[..4].copy_from_slice(&nan)).contains("theta_i"));
    assert!(refused(&|f| f[2].3[..4].copy_from_slice(&nan)).contains("wavelengths"));
    assert!(refused(&|f| f[7].3.iter_mut().for_each(|b| *b = 0xff)).contains("usable samples"));
    assert!(
        refused(&|f| f[0] = floats("phi_i", &[8], [0.0; 8])).contains("isotropic material) (not supported)")
    );
    // Nothing at all, everywhere alike.
    let nothing = |f: &mut Vec<Field>| {
        f[0] = floats("phi_i", &[0], []);
        [5, 7].into_iter().for_each(|k| f[k].2[0] = 0);
    };
    assert!(refused(&nothing).contains("incident azimuths: found 0"));
    assert!(refused(&|f| f[7].2 = vec![1 << 32, 1 << 31, 1, 1, 1]).contains("field spectra: side"));
    assert!(refused(&|f| f[7].2 = vec![1, 4, 4, 64, 1]).contains("field spectra: shape"));
    assert!(refused(&|f| f[8].1 = 5).contains("jacobian: type"));
    assert!(refused(&|f| f[4].0 = "sigmas").contains("field sigma: found only"));
    // A single node that is no number is left out.
    let mut fields = spectral_fields();
    fields[7].3[..4].copy_from_slice(&nan);
    let read = read_samples(&write(&folder, &tensor_bytes(&fields))).unwrap();
    assert_eq!(read.counts.invalid, 1);
}

fn of_reference(name: &str) -> Option<Measurement> {
    common::reference(name).map(|path: PathBuf| read_samples(Path::new(&path)).unwrap())
}

#[test]
fn tables_are_read_as_samples_with_a_word_on_reciprocity() {
    for name in ["blue", "green"] {
        let Some(read) = of_reference(&format!("data/mbsdf/carpaint_{name}.mbsdf")) else { return };
        assert_eq!(read.counts.found, 45 * 45 * 90);
        assert!(read.counts.negative > 1000, "negative values of the measurement are kept");
        // Found by whoever looked at these bytes before: a median of 7 to 21 %.
        let median = read.reciprocity.unwrap();
        assert!((0.05..0.25).contains(&median), "{name}: {median}");
    }
    let Some(read) = of_reference("data/nbrdf/blue-metallic-paint.f32") else { return };
    // phi_d of its input tells light from eye: reciprocal only as far as it was trained to.
    assert!(read.reciprocity.unwrap() < 0.5);
}

#[test]
fn what_is_no_measurement_is_refused_with_the_list_of_formats() {
    let folder = folder();
    let path = folder.path().join("a.doc");
    std::fs::write(&path, "what").unwrap();
    let message = read_samples(&path).unwrap_err().to_string();
    for format in ["mbsdf", "neural", ".bsdf", "MERL", "Guenther", ".csv"] {
        assert!(message.contains(format), "{message}");
    }
    let csv = folder.path().join("a.CSV");
    std::fs::write(&csv, "geometry,R,G,B\n45as15,1,x,0\n").unwrap();
    let message = read_samples(&csv).unwrap_err().to_string();
    assert!(message.contains("a.CSV: line 2: column 3"), "{message}");
    let set: SampleSet = {
        std::fs::write(&csv, "geometry,R,G,B\n45as15,1,1,0\n").unwrap();
        read_samples(&csv).unwrap().samples
    };
    assert_eq!(set.len(), 1);
}

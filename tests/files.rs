//! Files of paints, mixes and flake BTFs: they come back as they were, and damaged ones are errors, never a panic.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

/// What a test does to an object before it is checked.
type Change<'a, T> = &'a dyn Fn(&mut T);

#[path = "common/small.rs"]
mod small;

use carpaint::brdf::ColorTable;
use carpaint::btf::FlakeBtf;
use carpaint::file::{Channel, Container, Part, Samples};
use carpaint::math::hash::pcg4d;
use carpaint::mix::Mix;
use carpaint::paint::{Knots, MissingSlice};
use carpaint::{Paint, Result};
use serde_json::json;
use small::{KNOTS, SIZE, btf, mix, paint};
use std::path::Path;

/// The three kinds of files, behind one face.
trait Artefact: Sized + PartialEq + std::fmt::Debug {
    fn put(&self, path: &Path) -> Result<()>;
    fn get(path: &Path) -> Result<Self>;
    fn check(&self) -> Result<()>;
}

macro_rules! artefact {
    ($($kind:ty),*) => { $(
        impl Artefact for $kind {
            fn put(&self, path: &Path) -> Result<()> {
                self.write(path)
            }
            fn get(path: &Path) -> Result<Self> {
                Self::read(path)
            }
            fn check(&self) -> Result<()> {
                self.validate()
            }
        }
    )* };
}
artefact!(Paint, Mix, FlakeBtf);

fn round_trip<A: Artefact>(artefact: &A) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    artefact.put(&path).unwrap();
    assert_eq!(A::get(&path).unwrap(), *artefact);
    // The same bytes every time.
    let first = std::fs::read(&path).unwrap();
    A::get(&path).unwrap().put(&path).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), first);
}

#[test]
fn everything_comes_back_as_it_was() {
    round_trip(&paint(1));
    round_trip(&Paint { flakes: None, ..paint(1) });
    round_trip(&mix());
    round_trip(&Mix { flakes: None, ..mix() });
    round_trip(&btf());
}

#[test]
fn a_file_of_before_paints_had_their_own_compression_has_the_usual() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    paint(1).put(&path).unwrap();
    let mut container = Container::read(&path).unwrap();
    assert_eq!(
        container.meta["flakes"].as_object_mut().unwrap().remove("knot_compression"),
        Some(json!(7.0))
    );
    let old = Paint::from_container(container).unwrap();
    assert_eq!(old.flakes.unwrap().knots, Some(Knots::usual(KNOTS.spacing)));
}

/// Cuts a file at 60 places and flips bits of one byte 200 times: an error, or something that is legal.
fn survives_damage<A: Artefact>(artefact: &A) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    artefact.put(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    for k in 0..60 {
        let length = k * bytes.len() / 60;
        std::fs::write(&path, &bytes[..length]).unwrap();
        let message = A::get(&path).expect_err("a file cut short").to_string();
        assert!(message.contains("a.exr"), "{length} of {} bytes: {message}", bytes.len());
    }
    let mut refused = 0;
    for k in 0..200 {
        let [place, bits, ..] = pcg4d([k, 1, 2, 3]);
        let mut damaged = bytes.clone();
        // Half of the flips hit the headers, which are a small part of the file.
        let reach = if k % 2 == 0 { bytes.len() } else { bytes.len().min(2000) };
        damaged[place as usize % reach] ^= (1 + bits % 255) as u8;
        std::fs::write(&path, &damaged).unwrap();
        match A::get(&path) {
            Ok(read) => read.check().unwrap(),
            Err(error) => {
                refused += 1;
                assert!(error.to_string().contains("a.exr"), "{error}");
            }
        }
    }
    // Names and provenance take any letter, and floats most bits; the rest is checked.
    assert!(refused > 50, "{refused} of 200");
}

#[test]
fn damaged_paints_are_errors() {
    survives_damage(&paint(1));
}

#[test]
fn damaged_mixes_are_errors() {
    survives_damage(&mix());
}

#[test]
fn damaged_flake_btfs_are_errors() {
    survives_damage(&btf());
}

/// What reading says of a container that was changed.
fn complaint<A: Artefact>(artefact: &A, change: impl FnOnce(&mut Container)) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    artefact.put(&path).unwrap();
    let mut container = Container::read(&path).unwrap();
    change(&mut container);
    container.write(&path).unwrap();
    A::get(&path).unwrap_err().to_string()
}

fn channel<'a>(container: &'a mut Container, part: &str, channel: &str) -> &'a mut Samples {
    let channels = &mut container.parts.get_mut(part).unwrap().channels;
    &mut channels.iter_mut().find(|c| c.name == channel).unwrap().samples
}

fn set_f32(container: &mut Container, part: &str, name: &str, at: usize, value: f32) {
    let Samples::F32(v) = channel(container, part, name) else { panic!("floats") };
    v[at] = value;
}

#[test]
fn hostile_paints_are_named() {
    let cases: [(&str, Change<'_, Container>); 13] = [
        ("knot_compression: found -1", &|c| c.meta["flakes"]["knot_compression"] = json!(-1.0)),
        ("lobe 0: lobe: coefficient: found 2000000", &|c| c.meta["lobes"][0]["coefficient"] = json!(2e6)),
        ("roughness: found 101", &|c| c.meta["lobes"][0]["roughness"] = json!(101)),
        ("diffuse: found -10000000", &|c| c.meta["diffuse"] = json!(-1e7)),
        ("texel_mm: found 0.0000001", &|c| c.meta["flakes"]["texel_mm"] = json!(1e-7)),
        ("level 1: pitch_mm: found 1000000000", &|c| c.meta["flakes"]["pitch_mm"][1] = json!(1e9)),
        ("slice size: found [4097, 4]", &|c| c.meta["flakes"]["size"] = json!([4097, 4])),
        ("levels: found 3, expected 4", &|c| c.meta["flakes"]["size"] = json!([8, 4])),
        ("part inverse_cdf: size", &|c| c.meta["flakes"]["inverse_cdf_steps"] = json!(0)),
        ("level 0: slice 0: cluster 1: corners", &|c| set_f32(c, "clusters", "max.a", 1, 1e30)),
        ("level 0: slice 2: offset", &|c| set_f32(c, "offset", "G", 2, 3e38)),
        ("color table: texel (1, 2): value", &|c| set_f32(c, "color_table", "B", 5, -1e20)),
        ("part inverse_cdf: pixel (3, 1): cluster: found 4, expected", &|c| {
            let Samples::U32(v) = channel(c, "inverse_cdf", "index") else { panic!("integers") };
            v[20 + 3] = 4;
        }),
    ];
    for (expected, change) in cases {
        let message = complaint(&paint(1), change);
        assert!(message.contains("a.exr: ") && message.contains(expected), "{message} lacks {expected}");
    }
}

#[test]
fn hostile_mixes_are_named() {
    let cases: [(&str, Change<'_, Container>); 11] = [
        ("version of a mix: found 1, expected 2: couple", &|c| c.meta["version"] = json!(1)),
        ("threshold: found 0", &|c| c.meta["threshold"] = json!(0.0)),
        ("cost: name: found manhattan", &|c| c.meta["cost"] = json!("manhattan")),
        ("level 0: slice 0: gain", &|c| c.meta["rows"][0]["gains"][1][2] = json!(-1.0)),
        ("b: refracting clear coat: found true", &|c| {
            c.meta["constituents"][1]["coat"]["refracts"] = json!(true)
        }),
        ("a: paint: lobes: found 5", &|c| {
            let lobe = c.meta["constituents"][0]["lobes"][0].clone();
            c.meta["constituents"][0]["lobes"] = json!(vec![lobe; 5]);
        }),
        ("texel_mm: found -1", &|c| c.meta["flakes"]["texel_mm"] = json!(-1.0)),
        ("inverse_cdf_steps: found 65536", &|c| c.meta["flakes"]["inverse_cdf_steps"] = json!(65536)),
        ("level 0: slice 0: mean", &|c| c.meta["rows"][0]["means"][0][0] = json!(1e300)),
        ("level 0: slice 0: arc 0: corners", &|c| set_f32(c, "clusters_1", "min.L", 0, -1e10)),
        ("part arcs: pixel (0, 0): channel p", &|c| set_f32(c, "arcs", "p", 0, 0.9)),
    ];
    for (expected, change) in cases {
        let message = complaint(&mix(), change);
        assert!(message.contains("a.exr: ") && message.contains(expected), "{message} lacks {expected}");
    }
}

#[test]
fn hostile_flake_btfs_are_named() {
    let cases: [(&str, Change<'_, Container>); 4] = [
        ("texels in all slices: found", &|c| {
            c.meta["size"] = json!([4096, 4096]);
            c.meta["grid"] = json!({ "bins": 30, "rows": [30] });
            c.meta["expectation"] = json!(vec![[0.0; 3]; 30]);
        }),
        ("part slice_0000: size: found [4, 4], expected [8, 2]", &|c| c.meta["size"] = json!([8, 2])),
        ("part smooth: size: found [3, 4], expected [12, 1]", &|c| {
            c.meta["smooth_resolution"] = json!([1, 12])
        }),
        ("texel_mm: found 100000", &|c| c.meta["texel_mm"] = json!(1e5)),
    ];
    for (expected, change) in cases {
        let message = complaint(&btf(), change);
        assert!(message.contains("a.exr: ") && message.contains(expected), "{message} lacks {expected}");
    }
}

#[test]
fn what_would_not_be_read_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("named.exr");
    let mut bad = paint(1);
    bad.flakes.as_mut().unwrap().levels[0].slices[0].offset[1] = f32::NAN;
    let mut bad_mix = mix();
    bad_mix.flakes.as_mut().unwrap().levels[1].slices[0].gap = f64::NAN;
    let mut bad_btf = btf();
    bad_btf.slices[1].fluctuation[3][0] = f32::INFINITY;
    for error in [bad.write(&path), bad_mix.write(&path), bad_btf.write(&path)] {
        let message = error.unwrap_err().to_string();
        assert!(message.contains("named.exr: ") && message.contains("slice"), "{message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn channels_that_do_not_fill_their_part_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    paint(1).write(&path).unwrap();
    let container = Container::read(&path).unwrap();
    for (name, part) in &container.parts {
        for k in 0..part.channels.len() {
            let mut short = container.clone();
            match &mut short.parts.get_mut(name).unwrap().channels[k].samples {
                Samples::F16(v) => v.truncate(1),
                Samples::F32(v) => v.truncate(1),
                Samples::U32(v) => v.truncate(1),
            }
            let message = Paint::from_container(short.clone()).unwrap_err().to_string();
            assert!(message.contains("samples: found 1, expected"), "{name} {k}: {message}");
            assert!(short.write(&path).is_err());
        }
    }
}

#[test]
fn subsampled_channels_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let channels = vec![Channel::f32("subsampled", vec![1.0; 16])];
    let part = Part { size: SIZE, channels };
    Container { meta: json!({}), parts: [("a".to_owned(), part)].into() }.write(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    // Behind a channel's name: type, linearity and padding (4 bytes each), then the two sampling factors.
    let name = b"subsampled\0";
    let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 8;
    assert_eq!(bytes[at..at + 8], [1, 0, 0, 0, 1, 0, 0, 0]);
    assert!(Container::read(&path).is_ok());
    for (x, y) in [(2, 2), (1, 2), (4, 1), (3, 1), (0, 1), (1, 0), (255, 1)] {
        let mut changed = bytes.clone();
        (changed[at], changed[at + 4]) = (x, y);
        std::fs::write(&path, changed).unwrap();
        let message = Container::read(&path).unwrap_err().to_string();
        assert!(message.contains("a.exr"), "{x} {y}: {message}");
    }
}

#[test]
fn differences_see_every_field() {
    let a = paint(1);
    assert!(a.differences(&a).is_empty());
    let cases: [(&str, Change<'_, Paint>); 19] = [
        ("coat: index", &|p| p.coat.ior = 1.6),
        ("coat: refraction in one only", &|p| p.coat.refracts = true),
        ("gloss", &|p| p.coat.gloss = None),
        ("lobes", &|p| p.lobes[1].f0 = 0.6),
        ("lobes", &|p| p.lobes.truncate(1)),
        ("color table: size", &|p| p.colors = ColorTable::white()),
        ("color table: measured texels", &|p| {
            p.colors = ColorTable::new([2, 3], p.colors.texels().to_vec(), vec![true; 6]).unwrap();
        }),
        ("flakes in one only", &|p| p.flakes = None),
        ("flakes: missing slices", &|p| p.flakes.as_mut().unwrap().missing = MissingSlice::Zero),
        ("flakes: slice size", &|p| p.flakes.as_mut().unwrap().size = [4, 3]),
        ("flakes: texel size, mm", &|p| p.flakes.as_mut().unwrap().texel_mm = 0.03),
        ("flakes: steps of the inverse CDF", &|p| p.flakes.as_mut().unwrap().inverse_cdf_steps = 21),
        ("flakes: lattice pitch, mm", &|p| p.flakes.as_mut().unwrap().levels[1].pitch_mm = 1.0),
        ("flakes: offsets, 1/sr", &|p| p.flakes.as_mut().unwrap().levels[1].slices[0].offset[0] += 1.0),
        ("flakes: gains", &|p| p.flakes.as_mut().unwrap().levels[1].slices[0].gain[0] = 2.0),
        ("flakes: bands between clusters", &|p| {
            p.flakes.as_mut().unwrap().levels[0].slices[0].fades = vec![0.1]
        }),
        ("flakes: knot spacing", &|p| {
            p.flakes.as_mut().unwrap().knots = Some(Knots { spacing: 0.2, ..KNOTS })
        }),
        ("flakes: knot compression", &|p| {
            p.flakes.as_mut().unwrap().knots = Some(Knots { compression: 5.0, ..KNOTS })
        }),
        ("flakes: lifetime in one only", &|p| p.flakes.as_mut().unwrap().knots = None),
    ];
    for (expected, change) in cases {
        let mut b = a.clone();
        change(&mut b);
        let list = a.differences(&b);
        assert!(list.iter().any(|d| d.0 == expected && d.1 > 0.0), "{list:?} lacks {expected}");
        // A structure is apart by more than any tolerance.
        let measured = [", mm", "1/sr", "index", "lobes", "gains", "clusters", "spacing", "compression"]
            .iter()
            .any(|end| expected.ends_with(end));
        assert!(measured || list[0].1 == f64::INFINITY, "{list:?}");
    }
}

#[test]
fn differences_of_mixes_see_every_field() {
    let a = mix();
    assert!(a.differences(&a).is_empty());
    let cases: [(&str, bool, Change<'_, Mix>); 7] = [
        ("a: name", true, &|m| m.constituents[0].name = "c".into()),
        ("number of paints", true, &|m| m.constituents.truncate(1)),
        ("flakes in one only", true, &|m| m.flakes = None),
        ("flakes: steps of the inverse CDF", true, &|m| m.flakes.as_mut().unwrap().inverse_cdf_steps = 9),
        ("flakes: lattice pitch, mm", false, &|m| m.flakes.as_mut().unwrap().levels[2].pitch_mm = 1.0),
        ("flakes: means, 1/sr", false, &|m| m.flakes.as_mut().unwrap().levels[0].slices[3].means[1].y += 1.0),
        ("flakes: arcs or groups", true, &|m| {
            m.flakes.as_mut().unwrap().levels[0].slices[3].groups.truncate(1)
        }),
    ];
    for (expected, structure, change) in cases {
        let mut b = a.clone();
        change(&mut b);
        let list = a.differences(&b);
        assert_eq!(list.len(), 1, "{list:?}");
        assert_eq!(list[0].0, expected);
        assert_eq!(list[0].1 == f64::INFINITY, structure, "{list:?}");
    }
}

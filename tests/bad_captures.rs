//! Captures spoiled one way at a time: each is refused with a reason, or survived with a warning and about the same paint.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use carpaint::Paint;
use carpaint::color::{delta_e_2000, lab_from_rgb};
use carpaint::dome::MadeOf;
use carpaint::file::{read_picture, write_picture_exr};
use carpaint::fit::SmoothFit;
use carpaint::math::half_difference::spherical;
use carpaint::measure::{Shot, picture_path};
use carpaint::simulate::{Composition, Model, ModelOptions};
use glam::{DVec2, DVec3};
use serde_json::Value;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::OnceLock;

const SILVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions/silver_metallic.toml");

/// Nine cameras, those of a ring a quarter of it apart; pictures of 96 x 96.
const DOME: &str = "image_px = [96, 96]\nsample_mm = [10, 10]\nscatter_deg = 0.3\nleds = [9, 9]\nled_pitch_mm = 6.5\n\
    rings = [{ cameras = 1, polar_deg = 0 }, { cameras = 4, polar_deg = 25, first_azimuth_deg = 40 }, \
    { cameras = 4, polar_deg = 48, first_azimuth_deg = 10 }]\n\
    flash = { offset_mm = [4, 0], size_mm = [8, 6], points = [10, 9] }\n";
const CAMERAS: usize = 9;
const EXPOSURES: usize = 4;
/// What a saturated pixel says.
const FULL: f32 = 4095.0;

/// How far the color of the smooth part may move, Delta-E 2000 in the mean over directions, for a pair less: some four pairs decide
/// what is seen of a direction, and flakes scatter them by 5 %, so that one of them less moves a twentieth of the directions by up to
/// 2. Three times that. With a camera less, a fifth of the pairs, or a fifth of the samples behind a scratch, it may move by as much
/// as the whole capture is off the truth; with two less it is held against a capture that never had them.
const PAIR_LESS: f64 = 0.3;
/// The same against a capture that never had them: what is named as another camera's still had a part in the lens that all share,
/// hundredths of a pixel.
const NEVER_HAD: f64 = 0.1;

fn run(arguments: &[&str]) -> Output {
    common::carpaint().args(arguments).output().unwrap()
}

/// A capture, and what it gives unspoiled.
struct Whole {
    folder: tempfile::TempDir,
    paint: SmoothFit,
    /// How far it is from the paint that was photographed.
    error: f64,
}

fn whole() -> &'static Whole {
    static WHOLE: OnceLock<Whole> = OnceLock::new();
    WHOLE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let shots = folder.path().join("shots");
        let dome = folder.path().join("dome.toml");
        std::fs::write(&dome, DOME).unwrap();
        let out = run(&["measure", SILVER, "--dome", text(&dome), "-o", text(&shots)]);
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let tried = Tried::of("unspoiled", &shots);
        assert_eq!(tried.codes, [0, 0], "{}", tried.said);
        assert!(!tried.said.contains(" is left out"), "{}", tried.said);
        std::fs::remove_file(shots.join("calibration.json")).unwrap();
        let model = Composition::read(SILVER.as_ref()).unwrap();
        let model = Model::new(&model, ModelOptions::default()).unwrap();
        let paint = tried.paint.unwrap();
        let error = distance(|wi, wo| seen(&paint, wi, wo), |wi, wo| model.brdf_rgb(wi, wo));
        println!("unspoiled: {error:.2} Delta-E from the truth");
        Whole { folder, paint, error }
    })
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// What calibrating and fitting a capture came to.
struct Tried {
    /// Exit codes of the two.
    codes: [i32; 2],
    /// Their standard error.
    said: String,
    paint: Option<SmoothFit>,
}

impl Tried {
    fn of(name: &str, shots: &Path) -> Self {
        let paint = shots.with_extension("paint.exr");
        let btf = shots.with_extension("btf.exr");
        let calibrated = run(&["calibrate", text(shots)]);
        let few =
            ["--clusters", "4", "--samples", "2000", "--starts", "2", "--lobes", "2", "--btf", text(&btf)];
        let fitted = run(&[&["fit", text(shots), "-o", text(&paint)][..], &few].concat());
        let said =
            [&calibrated, &fitted].map(|out| String::from_utf8_lossy(&out.stderr).into_owned()).concat();
        let codes = [&calibrated, &fitted].map(|out| out.status.code().unwrap());
        assert!(
            !said.contains("panicked") && codes.iter().all(|c| [0, 2].contains(c)),
            "{name}: {codes:?} {said}"
        );
        // What is refused leaves nothing, and nothing leaves half of itself.
        assert_eq!(shots.join("calibration.json").exists(), codes[0] == 0 || codes[1] == 0, "{name}: {said}");
        assert_eq!([paint.exists(), btf.exists()], [codes[1] == 0; 2], "{name}: {said}");
        let beside: Vec<PathBuf> = [shots, shots.parent().unwrap()]
            .iter()
            .flat_map(|folder| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()))
            .filter(|path| path.file_name().unwrap().to_str().unwrap().starts_with('.'))
            .collect();
        assert!(beside.is_empty(), "{name}: {beside:?}");
        let paint = paint.exists().then(|| SmoothFit::from(&Paint::read(&paint).unwrap()));
        Self { codes, said, paint }
    }

    fn says(&self, name: &str, words: &[&str]) {
        for word in words {
            assert!(self.said.contains(word), "{name}: no {word:?} in: {}", self.said);
        }
    }
}

/// A spoiled copy of the capture, calibrated and fitted.
fn tried(name: &str, spoil: impl FnOnce(&Path)) -> Tried {
    let folder = &whole().folder;
    let copy = tempfile::tempdir().unwrap();
    let shots = copy.path().join("shots");
    copy_folder(&folder.path().join("shots"), &shots);
    spoil(&shots);
    Tried::of(name, &shots)
}

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// The spoiled capture gives about the same paint as the unspoiled one, and these words.
fn survived(name: &str, limit: f64, words: &[&str], spoil: impl FnOnce(&Path)) {
    let paint = survivor(name, words, spoil);
    let error = change_of(&paint, &whole().paint);
    println!("{name}: {error:.2} Delta-E from the unspoiled paint");
    assert!(error < limit, "{name}: {error}, {limit}");
}

/// The spoiled capture names two cameras, and gives about the same paint as one that never had them.
fn survived_without(name: &str, lost: [usize; 2], words: [&str; 2], spoil: impl FnOnce(&Path)) {
    let words = [0, 1].map(|k| format!("camera {} is left out: {}", lost[k], words[k]));
    let paint = survivor(name, &words.each_ref().map(String::as_str), spoil);
    let without = survivor("without them", &[], |shots| {
        lost.iter().for_each(|camera| remove(&[pairs(shots, Some(*camera)), own(shots, *camera)].concat()));
    });
    let (error, whole) = (change_of(&paint, &without), change_of(&paint, &whole().paint));
    println!("{name}: {error:.2} Delta-E from the paint without them, {whole:.2} from the unspoiled one");
    assert!(error < NEVER_HAD, "{name}: {error}");
}

fn survivor(name: &str, words: &[&str], spoil: impl FnOnce(&Path)) -> SmoothFit {
    let tried = tried(name, spoil);
    assert_eq!(tried.codes, [0, 0], "{name}: {}", tried.said);
    tried.says(name, &[&["warning: "], words].concat());
    tried.paint.unwrap()
}

fn change_of(paint: &SmoothFit, other: &SmoothFit) -> f64 {
    distance(|wi, wo| seen(paint, wi, wo), |wi, wo| seen(other, wi, wo))
}

/// The spoiled capture is refused with these words.
fn refused(name: &str, words: &[&str], spoil: impl FnOnce(&Path)) {
    let tried = tried(name, spoil);
    assert_eq!(tried.codes[1], 2, "{name}: {}", tried.said);
    tried.says(name, &[&["error: ", "found ", "expected "], words].concat());
}

/// BRDF without gloss.
fn seen(fit: &SmoothFit, wi: DVec3, wo: DVec3) -> DVec3 {
    fit.base(wi, wo) * fit.coat.transmittance(wi.z, wo.z)
}

/// Mean CIEDE2000 of two BRDFs over directions that the dome measures.
fn distance(a: impl Fn(DVec3, DVec3) -> DVec3, b: impl Fn(DVec3, DVec3) -> DVec3) -> f64 {
    let polar = [10.0, 20.0, 30.0, 40.0].map(f64::to_radians);
    let turns = [0.0, 45.0, 90.0, 135.0, 160.0].map(f64::to_radians);
    let error = |k: usize| {
        let (wi, wo) = (spherical(polar[k % 4], 0.0), spherical(polar[k / 4 % 4], turns[k / 16]));
        delta_e_2000(lab_from_rgb(a(wi, wo) * PI), lab_from_rgb(b(wi, wo) * PI))
    };
    (0..80).map(error).sum::<f64>() / 80.0
}

/// The files of a pair.
fn pair(shots: &Path, camera: usize, light: usize) -> Vec<PathBuf> {
    (0..EXPOSURES).map(|exposure| picture_path(shots, Shot::Pair { camera, light, exposure })).collect()
}

/// The files of all pairs of a camera, or of all.
fn pairs(shots: &Path, camera: Option<usize>) -> Vec<PathBuf> {
    let cameras = camera.map_or(0..CAMERAS, |c| c..c + 1);
    cameras.flat_map(|c| (0..CAMERAS).flat_map(move |l| pair(shots, c, l))).collect()
}

/// The diodes and gray fields of a camera.
fn own(shots: &Path, camera: usize) -> Vec<PathBuf> {
    let fields =
        (0..).map(|step| picture_path(shots, Shot::Response { camera, step })).take_while(|p| p.exists());
    let diodes = [Shot::LedsWide { camera }, Shot::LedsZoom { camera }].map(|shot| picture_path(shots, shot));
    diodes.into_iter().chain(fields).collect()
}

fn change(paths: &[PathBuf], change: impl Fn(&mut [usize; 2], &mut Vec<[f32; 3]>)) {
    for path in paths {
        let (mut size, mut pixels) = read_picture(path).unwrap();
        change(&mut size, &mut pixels);
        write_picture_exr(path, size, &pixels).unwrap();
    }
}

fn fill(paths: &[PathBuf], value: f32) {
    change(paths, |_, pixels| pixels.fill([value; 3]));
}

fn remove(paths: &[PathBuf]) {
    paths.iter().for_each(|path| std::fs::remove_file(path).unwrap());
}

fn exchange(a: &Path, b: &Path) {
    let aside = a.with_extension("aside");
    for (from, to) in [(a, aside.as_path()), (b, a), (&aside, b)] {
        std::fs::rename(from, to).unwrap();
    }
}

/// All pictures of two cameras exchanged.
fn swap(shots: &Path, a: usize, b: usize) {
    let of = |camera| [pairs(shots, Some(camera)), own(shots, camera)].concat();
    of(a).iter().zip(of(b)).for_each(|(a, b)| exchange(a, &b));
}

/// All pictures under two flashes exchanged.
fn swap_flashes(shots: &Path, a: usize, b: usize) {
    for camera in 0..CAMERAS {
        pair(shots, camera, a).iter().zip(pair(shots, camera, b)).for_each(|(a, b)| exchange(a, &b));
    }
}

/// Changes what `capture.json` says of the dome.
fn describe(shots: &Path, change: impl Fn(&mut Value)) {
    let path = shots.join("capture.json");
    let mut capture: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    change(&mut capture["rig"]);
    std::fs::write(&path, capture.to_string()).unwrap();
}

#[test]
fn a_pair_without_light_or_with_too_much_is_left_out() {
    survived(
        "saturated pair",
        PAIR_LESS,
        &["left out: camera 3, light 4: white balance", "saturated"],
        |shots| {
            fill(&pair(shots, 3, 4), FULL);
        },
    );
    survived("black pair", PAIR_LESS, &["left out: camera 3, light 4: white balance", "black"], |shots| {
        fill(&pair(shots, 3, 4), 0.0);
    });
    refused("nothing but black", &["usable pictures", "none of 81 pairs", "black"], |shots| {
        fill(&pairs(shots, None), 0.0);
    });
    refused("nothing but white", &["usable pictures", "saturated"], |shots| fill(&pairs(shots, None), FULL));
}

#[test]
fn a_dead_camera_is_left_out() {
    survived("black camera", whole().error, &["camera 3 is left out: sees 0 of 81 diodes"], |shots| {
        fill(&[pairs(shots, Some(3)), own(shots, 3)].concat(), 0.0);
    });
    survived("missing camera", whole().error, &["camera 3 is left out", "c003_wide.exr"], |shots| {
        remove(&[pairs(shots, Some(3)), own(shots, 3)].concat());
    });
    survived(
        "blind camera",
        whole().error,
        &["left out: camera 3, light 0: white balance", "camera 3, light 8"],
        |shots| {
            fill(&pairs(shots, Some(3)), 0.0);
        },
    );
    refused("no diodes", &["cameras: found camera 0: sees 0 of 81", "and 6 more"], |shots| {
        (0..CAMERAS).for_each(|camera| fill(&own(shots, camera)[..2], 0.0));
    });
}

#[test]
fn numbers_that_are_none_and_damaged_files_are_named() {
    for (value, word) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (-5.0, "-5")] {
        survived(
            word,
            PAIR_LESS,
            &["left out: camera 3, light 4: exposures", "pixel (5, 3)", word],
            |shots| {
                change(&pair(shots, 3, 4), |size, pixels| pixels[3 * size[0] + 5][1] = value);
            },
        );
    }
    // One exposure of four is no loss, but it is said.
    survived(
        "one exposure",
        PAIR_LESS,
        &["left out: camera 3, light 4: ", "l004_e1.exr: pixel (5, 3)"],
        |shots| {
            change(&pair(shots, 3, 4)[1..2], |size, pixels| pixels[3 * size[0] + 5][1] = f32::NAN);
        },
    );
    survived("gray field", PAIR_LESS, &["camera 3: gray fields left out: 1, as", "c003_s05.exr"], |shots| {
        change(&own(shots, 3)[7..8], |_, pixels| pixels[0][0] = f32::NAN);
    });
    survived(
        "truncated",
        PAIR_LESS,
        &["left out: camera 3, light 4: exposures", "a complete EXR file"],
        |shots| {
            for path in pair(shots, 3, 4) {
                let bytes = std::fs::read(&path).unwrap();
                std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
            }
        },
    );
    survived(
        "another size",
        PAIR_LESS,
        &["camera 3, light 4", "found [96, 90], expected [96, 96]"],
        |shots| {
            change(&pair(shots, 3, 4), |size, pixels| {
                *size = [96, 90];
                pixels.truncate(96 * 90);
            });
        },
    );
    survived(
        "diodes cut off",
        whole().error,
        &["camera 3 is left out: with zoom", "a complete EXR file"],
        |shots| {
            let path = picture_path(shots, Shot::LedsZoom { camera: 3 });
            let bytes = std::fs::read(&path).unwrap();
            std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        },
    );
}

#[test]
fn swapped_cameras_are_named() {
    // Rings apart: the diodes tell. A quarter and a half of a ring apart, where a square plate looks the same, white targets do.
    for (a, b, what) in [
        (2, 5, "its picture fits the nominal place of camera"),
        (5, 6, "its white targets fit the place of camera"),
        (5, 7, "its white targets fit the place of camera"),
        (1, 2, "its white targets fit the place of camera"),
    ] {
        let words = [format!("{what} {b}"), format!("{what} {a}")];
        let words = words.each_ref().map(String::as_str);
        survived_without(&format!("{a} and {b}"), [a, b], words, |shots| swap(shots, a, b));
    }
}

#[test]
fn swapped_flashes_and_flashes_elsewhere_are_not_believed() {
    survived_without("flashes 5 and 6", [5, 6], ["light takes the same way back"; 2], |shots| {
        swap_flashes(shots, 5, 6);
    });
    refused("the other side", &["mirrored flashes", "offset_mm"], |shots| {
        describe(shots, |rig| rig["flash"]["offset_mm"] = serde_json::json!([-4.0, 0.0]));
    });
}

#[test]
fn impossible_domes_are_refused() {
    refused("below the horizon", &["capture.json: rig: cameras[3]: pose", "above the sample"], |shots| {
        describe(shots, |rig| {
            let z = &mut rig["cameras"][3]["position_mm"][2];
            *z = serde_json::json!(-z.as_f64().unwrap());
        });
    });
    refused("flash behind the panel", &["capture.json: rig: cameras[", "flash", "offset_mm"], |shots| {
        describe(shots, |rig| rig["flash"]["offset_mm"] = serde_json::json!([0.0, 2000.0]));
    });
    refused("one camera", &["number of cameras: found 1"], |shots| {
        describe(shots, |rig| rig["cameras"].as_array_mut().unwrap().truncate(1));
    });
}

#[test]
fn a_calibration_of_another_dome_is_refused() {
    let folder = &whole().folder;
    let copy = tempfile::tempdir().unwrap();
    let shots = copy.path().join("shots");
    copy_folder(&folder.path().join("shots"), &shots);
    assert!(run(&["calibrate", text(&shots)]).status.success());
    let paint = copy.path().join("a.paint.exr");
    let refused = |words: &[&str]| {
        let out = run(&["fit", text(&shots), "-o", text(&paint)]);
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(2), "{said}");
        assert!(words.iter().all(|word| said.contains(word)) && !paint.exists(), "{said}");
    };
    describe(&shots, |rig| rig["cameras"].as_array_mut().unwrap().swap(5, 6));
    refused(&["calibration.json: calibration: cameras[5]: pose", "this capture's dome"]);
    describe(&shots, |rig| rig["cameras"].as_array_mut().unwrap().truncate(5));
    refused(&["calibration: cameras: found 9, expected 5"]);
}

#[test]
fn a_scratch_is_found_in_the_pictures() {
    survived("scratch", whole().error, &["the panel differs from itself", "samples left out"], |shots| {
        let truth = MadeOf::read(shots).unwrap().truth;
        for (camera, seen) in truth.cameras.iter().enumerate() {
            change(&pairs(shots, Some(camera)), |size, pixels| {
                for (k, pixel) in pixels.iter_mut().enumerate() {
                    let at = DVec2::new((k % size[0]) as f64 + 0.5, (k / size[0]) as f64 + 0.5);
                    let place = seen.on_plane(at, 0.0).unwrap();
                    if (place.x - 3.0).abs() < 0.5 && place.y.abs() < 5.0 {
                        // Through responses of about a square root: two fifths of the light.
                        *pixel = pixel.map(|c| (0.62 * c).round());
                    }
                }
            });
        }
    });
}

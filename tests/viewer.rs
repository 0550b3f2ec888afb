//! The window on a virtual screen, driven by a real mouse and keyboard.
#![cfg(feature = "viewer")]
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "gpu/adapter.rs"]
mod adapter;
#[path = "viewer/display.rs"]
mod display;
#[path = "viewer/program.rs"]
mod program;

use adapter::{gpu, say};
use carpaint::Paint;
use carpaint::mix::{CoupleOptions, couple};
use carpaint::render::Picture;
use carpaint::report::{ChainOptions, run_chain};
use carpaint::simulate::Composition;
use display::{Display, Screenshot};
use program::{ESCAPE, F1, HOME, Program, command};
use std::path::Path;
use std::sync::OnceLock;

/// Share of the picture's pixels that a change of the paint or the light moves by more than a code or two: the capsule alone
/// covers a quarter of it.
const MUCH: f64 = 0.05;

/// A screen with an adapter to draw on it. None, loudly, where one is missing; with `CARPAINT_REQUIRE_GPU` that is a failure.
fn screen() -> Option<Display> {
    let display = Display::start().filter(|_| gpu().is_some());
    if display.is_none() {
        assert!(
            std::env::var_os("CARPAINT_REQUIRE_GPU").is_none(),
            "CARPAINT_REQUIRE_GPU is set, but no Xvfb"
        );
        say("SKIPPED: no Xvfb or no GPU adapter, the window was not tried");
    }
    display
}

/// Three small paints.
fn paints() -> &'static [(String, Paint)] {
    static PAINTS: OnceLock<Vec<(String, Paint)>> = OnceLock::new();
    PAINTS.get_or_init(|| {
        let paint = |name: &str| {
            let file = format!("{}/fixtures/compositions/{name}_metallic.toml", env!("CARGO_MANIFEST_DIR"));
            let composition = Composition::read(file.as_ref()).unwrap();
            let options = ChainOptions { bins: 4, size: 32, texel_mm: Some(0.02), seed: 1 };
            (name.to_owned(), run_chain(name, &composition, &options, |_, _| || ()).unwrap().paint)
        };
        ["brown", "blue", "silver"].map(paint).to_vec()
    })
}

/// Their mix, and one of them, written to a folder.
fn write_mix(folder: &Path) {
    let named: Vec<_> = paints().iter().map(|(name, paint)| (name.clone(), paint)).collect();
    let (mix, _) = couple(&named, &CoupleOptions::default(), &|| ()).unwrap();
    mix.write(&folder.join("mix.paint.exr")).unwrap();
    named[0].1.write(&folder.join("a.paint.exr")).unwrap();
}

/// An image with all colors in it, written to a folder.
fn write_image(folder: &Path) {
    let pixel = |k: usize| [(k % 48 * 5) as u8, (k / 48 * 7) as u8, 255 - (k % 48 * 5) as u8];
    let pixels: Vec<[u8; 3]> = (0..48 * 36).map(pixel).collect();
    carpaint::file::write_png(&folder.join("image.png"), [48, 36], &pixels).unwrap();
}

/// How much of a region differs between two screenshots.
fn changed(region: [f64; 4], before: &Screenshot, after: &Screenshot) -> f64 {
    before.part(region).changed(&after.part(region), 2)
}

#[test]
fn a_hand_moves_weights_eye_and_lamp() {
    let Some(display) = screen() else { return };
    let folder = tempfile::tempdir().unwrap();
    write_mix(folder.path());
    let mut program = Program::start(&display, folder.path(), &["mix.paint.exr"]);
    program.narrow();
    let start = program.settled("1 a mix of three paints");
    let picture = program.place("picture");
    let [left, top, right, _] = picture;
    assert!(start.part(picture).mean() > 5.0, "there is a picture");
    // Controls that none of what follows changes: those of the lamp.
    let [lamp_left, lamp_top, ..] = program.place("azimuth");
    let lamp = [lamp_left, lamp_top, program.place("power")[2], program.place("power")[3]];

    // A weight: the slider's rail is the left part of its place.
    let y = program.middle("brown")[1];
    let [slider_left, .., slider_right, _] = program.place("brown");
    let rail = 0.6 * (slider_right - slider_left);
    program.drag(1, [slider_left + rail / 3.0, y], [slider_left + 0.95 * rail, y]);
    program.wait("weight above 0.8", |p| p.number("weights", 0) > 0.8);
    let weighed = program.settled("2 a weight moved");
    assert!(changed(picture, &start, &weighed) > MUCH);
    assert_eq!(changed(lamp, &start, &weighed), 0.0, "the lamp's controls stay");
    let weights: Vec<f64> = (0..3).map(|k| program.number("weights", k)).collect();
    assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{weights:?}");
    assert!((weights[1] - weights[2]).abs() < 1e-9, "the others keep their proportions: {weights:?}");

    // The pad, to its second corner.
    program.drag(1, program.middle("pad"), program.middle("pad corner 2"));
    program.wait("pad at a corner", |p| p.number("weights", 1) > 0.95);
    // Away from the pad, whose hint would lie over the picture.
    program.point([150.0, 650.0]);
    let cornered = program.settled("3 the pad at a corner");
    assert!(changed(picture, &weighed, &cornered) > MUCH);

    // The lamp, off and on again by the keyboard: the picture comes back to the bit.
    program.key(u32::from(b'l'), false);
    program.wait("lamp off", |p| p.all()["lamp is on"] == false);
    let dark = program.settled("4 the lamp off");
    assert!(dark.part(picture).mean() < cornered.part(picture).mean(), "less light");
    assert!(changed(picture, &cornered, &dark) > 0.01);
    program.key(u32::from(b'l'), false);
    program.wait("lamp on", |p| p.all()["lamp is on"] == true);
    let lit = program.settled("5 the lamp on again");
    assert_eq!(changed(picture, &cornered, &lit), 0.0);

    // The lamp, moved by a right drag; the eye, by a left one, and back by a key.
    let middle = program.middle("picture");
    let away = [middle[0] + 120.0, middle[1] + 10.0];
    program.drag(3, middle, away);
    let moved = program.settled("6 the lamp moved");
    assert!(changed(picture, &lit, &moved) > 0.01);
    assert!(changed(lamp, &lit, &moved) > 0.0, "its sliders follow");
    program.drag(1, middle, [middle[0] - 90.0, middle[1] + 160.0]);
    let turned = program.settled("7 turned");
    assert!(changed(picture, &moved, &turned) > MUCH);
    program.key(HOME, false);
    let home = program.settled("8 the eye back");
    // The pointer is elsewhere, the picture is not.
    assert_eq!(changed(picture, &moved, &home), 0.0);

    // The wheel, down to flakes.
    program.wheel(20, true);
    let near = program.settled("9 single flakes");
    assert!(changed(picture, &home, &near) > MUCH);

    // Help, and away with it: what it does not cover stays.
    program.key(F1, false);
    program.wait("help", |p| p.all()["help"].is_array());
    let help = program.settled("10 help");
    // Short of its shadow.
    let above = [left, top, right, program.place("help")[1] - 30.0];
    assert!(above[3] > top + 20.0, "help fits");
    assert_eq!(changed(above, &near, &help), 0.0);
    assert!(changed(program.place("help"), &near, &help) > 0.3);
    program.key(ESCAPE, false);
    program.wait("no help", |p| p.all()["help"].is_null());
    let closed = program.settled("11 help closed");
    assert_eq!(changed([left, top, right, 700.0], &near, &closed), 0.0);
    assert_eq!(program.quit().code(), Some(0));
}

#[test]
fn two_paints_share_the_picture_and_other_objects_wear_them() {
    let Some(display) = screen() else { return };
    let folder = tempfile::tempdir().unwrap();
    write_mix(folder.path());
    let mut program = Program::start(&display, folder.path(), &["mix.paint.exr"]);
    program.narrow();
    let single = program.settled("20 single");
    let picture @ [left, top, right, bottom] = program.place("picture");
    program.key(u32::from(b'v'), false);
    program.wait("divider", |p| p.all()["divider"].is_array());
    let split = program.settled("21 split");
    let middle = 0.5 * (left + right);
    let (west, east) =
        ([left + 40.0, top + 40.0, middle - 12.0, bottom - 60.0], [middle + 12.0, top + 40.0, right, bottom]);
    assert_eq!(changed(west, &single, &split), 0.0, "the first paint stays on the left");
    assert!(changed(east, &single, &split) > MUCH, "the second one stands on the right");
    let grip = program.middle("divider");
    program.drag(1, [grip[0], top + 200.0], [grip[0] + 70.0, top + 200.0]);
    let wider = program.settled("22 the divider moved");
    let between = [middle + 20.0, top + 100.0, middle + 50.0, bottom - 100.0];
    assert_eq!(changed(between, &single, &wider), 0.0, "the first paint reaches farther");
    program.key(u32::from(b'v'), false);
    let beside = program.settled("23 side by side");
    assert!(changed(picture, &wider, &beside) > MUCH);
    program.key(u32::from(b'v'), false);
    for (name, key) in [("24 the sphere", b'o'), ("25 under the sky", b'e')] {
        let before = program.settled("before");
        program.key(u32::from(key), false);
        let after = program.settled(name);
        assert!(changed(picture, &before, &after) > MUCH, "{name}");
    }
    assert_eq!(program.quit().code(), Some(0));
}

#[test]
fn an_image_is_shown_as_a_print_under_lamps() {
    let Some(display) = screen() else { return };
    let folder = tempfile::tempdir().unwrap();
    write_image(folder.path());
    // Red light alone.
    std::fs::write(folder.path().join("lamp.csv"), "nm,power\n380,0\n590,0\n600,1\n780,1\n").unwrap();
    let mut program = Program::start(&display, folder.path(), &["image.png"]);
    program.resize([640, 480]);
    program.wait("a small picture", |p| p.all()["picture"][2].as_f64() == Some(344.0));
    program.point([20.0, 20.0]);
    let start = program.settled("90 a print");
    let picture @ [left, top, right, bottom] = program.place("picture");
    assert!(start.part(picture).mean() > 5.0, "there is a picture");
    let middle = program.middle("picture");

    // A control: the exposure, whose rail is the left part of its place.
    let [slider_left, slider_top, slider_right, slider_bottom] = program.place("exposure");
    let (y, rail) = (0.5 * (slider_top + slider_bottom), 0.6 * (slider_right - slider_left));
    program.drag(1, [slider_left + 0.5 * rail, y], [slider_left + 0.65 * rail, y]);
    program.point([20.0, 20.0]);
    let bright = program.settled("91 a print exposed longer");
    assert!(bright.part(picture).mean() > 1.2 * start.part(picture).mean());
    program.drag(1, [slider_left + 0.65 * rail, y], [slider_left + 0.5 * rail, y]);

    // The hand: the lamp by a right drag, and off and on again; the print by a left one, and back.
    program.drag(3, middle, [middle[0] - 60.0, middle[1]]);
    let lit = program.settled("92 the lamp moved");
    assert!(changed(picture, &bright, &lit) > MUCH);
    program.key(u32::from(b'l'), false);
    program.wait("lamp off", |p| p.all()["lamp is on"] == false);
    let dark = program.settled("93 the lamp off");
    assert!(dark.part(picture).mean() < lit.part(picture).mean());
    program.key(u32::from(b'l'), false);
    program.wait("lamp on", |p| p.all()["lamp is on"] == true);
    assert_eq!(changed(picture, &lit, &program.settled("94 the lamp on again")), 0.0);
    program.drag(1, middle, [middle[0] + 70.0, middle[1] - 30.0]);
    assert!(changed(picture, &lit, &program.settled("95 the print turned")) > MUCH);
    program.key(HOME, false);
    let home = program.settled("96 the eye back");
    assert_eq!(changed(picture, &lit, &home), 0.0);

    // The standard model beside ours.
    program.key(u32::from(b'v'), false);
    program.wait("divider", |p| p.all()["divider"].is_array());
    let split = program.settled("97 two models");
    let half = 0.5 * (left + right);
    let (west, east) = ([left, top + 40.0, half - 12.0, bottom], [half + 12.0, top + 40.0, right, bottom]);
    assert_eq!(changed(west, &home, &split), 0.0, "ours stays on the left");
    assert!(changed(east, &home, &split) > MUCH, "the other one stands on the right");
    program.key(u32::from(b'v'), false);
    assert!(changed(picture, &split, &program.settled("98 side by side")) > MUCH);
    program.key(u32::from(b'v'), false);

    // Another shape; a lamp by its name, in the field: there is no other keyboard.
    program.key(u32::from(b'o'), false);
    program.wait("a panel", |p| p.all()["shape"] == "panel");
    let panel = program.settled("99 a panel");
    assert!(changed(picture, &home, &panel) > MUCH);
    program.key(u32::from(b'o'), true);
    for letter in "lamp.csv".bytes() {
        program.key(u32::from(letter), false);
    }
    program.key(0xff0d, false);
    let red = program.settled("100 in red light");
    let [r, g, b] = red.part(picture).color();
    assert!(r > 2.0 * g.max(b), "{r} {g} {b}");

    program.key(u32::from(b's'), true);
    program.wait("saved picture", |p| p.all()["is busy"] == false && p.all()["messages"] == 1);
    let saved = Picture::read(&folder.path().join("proof.png")).unwrap();
    assert_eq!(saved.size.map(|n| n as f64), [right - left, (bottom - top).round()]);
    program.key(ESCAPE, false);
    program.key(F1, false);
    program.wait("help", |p| p.all()["help"].is_array());
    program.settled("101 help of a print");
    assert_eq!(program.quit().code(), Some(0));
}

#[test]
fn a_capsule_moved_among_the_paints_takes_after_the_nearest() {
    let Some(display) = screen() else { return };
    let folder = tempfile::tempdir().unwrap();
    write_mix(folder.path());
    let mut program = Program::start(&display, folder.path(), &["mix.paint.exr"]);
    program.alone([360, 270]);
    program.shifted_key(u32::from(b'o'));
    program
        .wait("the demonstration", |p| p.all()["object"] == "demonstration" && p.all()["is busy"] == false);
    // What a key or the mouse asks for is on the screen when the window has taken note of it, be it coarse: nobody waits for more.
    let start = program.seen("51 the demonstration");
    let at = [program.number("movable", 0), program.number("movable", 1)];
    let before = program.number("weights", 1);
    // The second paint's capsule stands in front, to the right.
    let to = [at[0] + 40.0, at[1] + 12.0];
    program.drag(1, at, to);
    program.wait("a moved capsule", |p| p.number("movable", 0) > at[0] + 25.0);
    let moved = program.seen("52 the capsule moved");
    assert!(program.number("weights", 1) > before + 0.1, "{} from {before}", program.number("weights", 1));
    // Where it stood the surroundings are seen, and it is seen where it stands; means, since pictures differ in how fine they are.
    for place in [at, to] {
        let region = [place[0] - 4.0, place[1] - 6.0, place[0] + 4.0, place[1] + 6.0];
        let [was, is] = [&start, &moved].map(|shot| shot.part(region).mean());
        assert!((was - is).abs() > 8.0, "at {place:?} {was}, then {is}");
    }
    // The eye stays: beside the objects nothing changes.
    assert_eq!(changed([0.0, 0.0, 40.0, 60.0], &start, &moved), 0.0);
    // Beside the capsule a drag turns all of it.
    program.drag(1, [20.0, 30.0], [80.0, 30.0]);
    let turned = program.seen("53 the demonstration turned");
    assert!(changed(program.place("picture"), &moved, &turned) > 0.01);
    assert_eq!(program.quit().code(), Some(0));
}

#[test]
fn a_scene_is_shown_in_the_paints_that_are_open() {
    let Some(display) = screen() else { return };
    let folder = tempfile::tempdir().unwrap();
    write_mix(folder.path());
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/scenes/capsules.toml");
    let arguments = ["mix.paint.exr", "--scene", scene, "--weights=1.5,-0.5,0"];
    let mut program = Program::start(&display, folder.path(), &arguments);
    program.wait("the scene", |p| p.all()["object"] == "scene");
    assert_eq!(program.all()["weights"], serde_json::json!([1.5, -0.5, 0.0]));
    program.alone([360, 270]);
    let shown = program.seen("70 a scene of three capsules");
    // Brown, blue and silver, from left to right.
    let [red, green, blue] = [[110.0, 135.0], [180.0, 135.0], [250.0, 135.0]].map(|[x, y]: [f64; 2]| {
        let [r, _, b] = shown.part([x - 12.0, y - 30.0, x + 12.0, y + 30.0]).color();
        r - b
    });
    assert!(red > green.max(blue) && green < blue, "red over blue: {red} {green} {blue}");
    program.shifted_key(u32::from(b'o'));
    program
        .wait("the demonstration", |p| p.all()["object"] == "demonstration" && p.all()["is busy"] == false);
    assert!(changed(program.place("picture"), &shown, &program.seen("71 another object")) > MUCH);
    assert_eq!(program.quit().code(), Some(0));
}

#[test]
fn a_window_that_loses_its_device_opens_anew_and_says_so() {
    let Some(display) = screen() else { return };
    let folder = tempfile::tempdir().unwrap();
    write_mix(folder.path());
    let arguments = ["mix.paint.exr", "--lose-device-after", "2", "--weights=0.8,0.1,0.1"];
    let mut program = Program::start(&display, folder.path(), &arguments);
    program.wait("a third window", |p| p.all()["losses"] == 2);
    program.look_for_window();
    program.narrow();
    let shown = program.settled("80 after the device was lost");
    assert!(shown.part(program.place("message 1")).mean() > 10.0);
    assert!(shown.part(program.place("picture")).mean() > 5.0, "there is a picture");
    assert_eq!(program.all()["weights"], serde_json::json!([0.8, 0.1, 0.1]), "what was set stays");
    assert_eq!(program.quit().code(), Some(0));
}

#[test]
fn a_device_lost_on_the_way_to_the_screen_ends_with_a_message() {
    let Some(display) = screen() else { return };
    let folder = tempfile::tempdir().unwrap();
    write_mix(folder.path());
    let output = command(folder.path())
        .env("DISPLAY", &display.name)
        .args(["mix.paint.exr", "--lose-device-late-after", "1"])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("device: found lost while a frame was on its way to the screen"), "{text}");
    assert!(!text.contains("panicked") && !text.contains(".rs"), "{text}");
}

#[test]
fn bad_input_is_refused_before_a_window_opens() {
    let folder = tempfile::tempdir().unwrap();
    write_mix(folder.path());
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("bad.paint.exr", "no such thing");
    write("neither.toml", "key = 1");
    write("bad.jpg", "no such thing");
    write("ink.ink.json", r#"{"kind": "carpaint ink", "version": 1, "name": "none"}"#);
    write_image(folder.path());
    write(
        "composition.toml",
        "[substrate]\nalbedo = 2\n[[film]]\nthickness_um = 1\nindex = 1.5\nabsorption_per_mm = 0",
    );
    write("scene.toml", "[camera]\nzoom = 2");
    write("lost.toml", "[environment]\nkind = \"image\"\npath = \"none.hdr\"");
    let mix = "mix.paint.exr";
    for (arguments, words) in [
        (&["none.paint.exr"][..], ["none.paint.exr", "No such file"]),
        (&["bad.paint.exr"], ["bad.paint.exr", "EXR"]),
        (&["a.paint.exr", mix], [mix, "a mix by itself"]),
        (&["neither.toml"], ["neither.toml", "found keys key, expected a composition"]),
        (&["composition.toml"], ["albedo", "found 2, expected"]),
        (&[mix, "scene.toml"], ["zoom", "position_mm"]),
        (&[mix, "--scene", "scene.toml"], ["zoom", "position_mm"]),
        (&[mix, "--scene", "lost.toml"], ["none.hdr", "No such file"]),
        (&[mix, "none.glb"], ["none.glb", "No such file"]),
        (&[mix, "--weights=0.5,0.5"], ["--weights", "found 2, expected 3"]),
        (&[mix, "--weights=0.5,0.5,0.5"], ["--weights: sum", "found 1.5, expected 1"]),
        (&[mix, "--weights=3,-2,0"], ["--weights", "found 3, expected -1 to 2"]),
        (&["none.png"], ["none.png", "No such file"]),
        (&["bad.jpg"], ["bad.jpg", "JPEG"]),
        (&["image.png", mix], ["image.png", "an image by itself"]),
        (&["image.png", "--weights=1"], ["image.png", "an image by itself"]),
        (&["image.png", "--inks", "ink.ink.json", "b", "c"], ["ink.ink.json", "alpha"]),
        (&[mix, "--inks", "a", "b", "c"], ["--inks", "expected one that is printed"]),
    ] {
        let output = command(folder.path()).args(arguments).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        assert!(words.iter().all(|word| text.contains(word)), "{arguments:?}: {text}");
        assert!(!text.contains("display"), "{arguments:?}: {text}");
    }
}

#[test]
fn a_composition_is_shown_edited_and_refined() {
    let Some(display) = screen() else { return };
    let folder = tempfile::tempdir().unwrap();
    let recipe = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions/silver_metallic.toml");
    let mut program = Program::start(&display, folder.path(), &[recipe]);
    program.narrow();
    program.wait("the fast model", |p| p.all()["stage"] == "Fast" || p.all()["stage"] == "Full");
    let picture = program.place("picture");
    program.wait("the full model", |p| p.all()["stage"] == "Full");
    let full = program.settled("60 a composition in full");
    let [left, top, right, bottom] = program.place("film 1 flakes 1 tilt");
    let (y, rail) = (0.5 * (top + bottom), 0.6 * (right - left));
    program.drag(1, [left + 0.5 * rail, y], [left + 0.85 * rail, y]);
    program.wait("the fast model again", |p| p.all()["stage"] == "Fast" || p.all()["stage"] == "Full");
    program.wait("the full model again", |p| p.all()["stage"] == "Full");
    let wider = program.settled("61 flakes that lie wider");
    assert!(changed(picture, &full, &wider) > MUCH);
    assert_eq!(program.quit().code(), Some(0));
}

#[test]
fn bad_files_are_said_and_a_window_without_room_goes_on() {
    let Some(display) = screen() else { return };
    let folder = tempfile::tempdir().unwrap();
    write_mix(folder.path());
    // Cut off: that is found out when all of it is read.
    let whole = std::fs::read(folder.path().join("a.paint.exr")).unwrap();
    std::fs::write(folder.path().join("bad.paint.exr"), &whole[..whole.len() - 9]).unwrap();
    let mut program = Program::start(&display, folder.path(), &["bad.paint.exr"]);
    program.wait("message", |p| p.all()["message 1"].is_array());
    let said = program.settled("30 a bad file");
    assert!(said.part(program.place("message 1")).mean() > 10.0);
    program.key(ESCAPE, false);
    program.wait("no message", |p| p.all()["messages"] == 0);
    // By name, in the field: there is no other keyboard.
    program.key(u32::from(b'o'), true);
    program.wait("field", |p| p.all()["open field"].is_array());
    for letter in "a.paint.exr".bytes() {
        program.key(u32::from(letter), false);
    }
    program.key(0xff0d, false);
    program.wait("paint", |p| p.all()["is busy"] == false && p.all()["is settled"] == true);
    let open = program.settled("31 opened by its name");
    let picture = program.place("picture");
    assert!(changed(picture, &said, &open) > MUCH);
    for size in [[1, 1], [1280, 2], [3, 800], [640, 480]] {
        program.resize(size);
        program.wait("frame at another size", |p| p.is_alive());
    }
    // Small pictures are soon saved.
    program.wait("a small picture", |p| p.all()["picture"][2].as_f64() == Some(344.0));
    program.settled("32 small");
    program.key(u32::from(b's'), true);
    program.wait("saved picture", |p| p.all()["is busy"] == false && p.all()["messages"] == 1);
    let [width, height] = Picture::read(&folder.path().join("picture.png")).unwrap().size;
    let [left, top, right, bottom] = program.place("picture");
    assert_eq!([width as f64, height as f64], [right - left, (bottom - top).round()]);
    program.key(u32::from(b'b'), true);
    program.wait("saved paint", |p| p.all()["messages"] == 2);
    assert_eq!(Paint::read(&folder.path().join("blend.paint.exr")).unwrap(), paints()[0].1);
    program.key(ESCAPE, false);
    program.show(false);
    program.show(true);
    program.resize([1280, 800]);
    program.wait("room", |p| p.all()["picture"].is_array() && p.place("picture") == picture);
    let back = program.settled("33 room again");
    assert_eq!(changed(picture, &open, &back), 0.0);
    assert_eq!(program.quit().code(), Some(0));
}

#[test]
fn without_a_display_or_the_adapter_asked_for_it_says_so() {
    let folder = tempfile::tempdir().unwrap();
    // None at all, and one that nobody answers on.
    for (name, words) in [
        (
            "",
            ["display: found none (neither DISPLAY nor WAYLAND_DISPLAY is set), expected", "carpaint render"],
        ),
        (":none", ["display: found ", "carpaint render"]),
    ] {
        let output = command(folder.path()).env("DISPLAY", name).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
        assert!(!text.contains(".rs") && !text.contains("panicked"), "{text}");
    }
    let Some(display) = screen() else { return };
    let output = command(folder.path())
        .env("DISPLAY", &display.name)
        .args(["--adapter", "no such adapter"])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("no such adapter"), "{text}");
}

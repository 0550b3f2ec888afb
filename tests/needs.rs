//! What a scene needs of a paint: the picture stays the same to the bit, and no cell is missing unnoticed.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use carpaint::brdf::ClearCoat;
use carpaint::btf::{AngleGrid, FlakeBtf};
use carpaint::fit::{FitOptions, FlakeOptions, fit_btf};
use carpaint::paint::Paint;
use carpaint::render::{Options, Picture, Random, RenderPaint, needed_of_paint, render};
use carpaint::scene::{DirectionalLight, Environment, Scene, Shape};
use carpaint::simulate::{Composition, Model, ModelOptions, SynthesisOptions, synthesize};
use std::path::Path;
use std::sync::LazyLock;

/// Silver metallic, 30 x 30 angle bins, slices of 32 x 32 texels.
static PAINT: LazyLock<Paint> = LazyLock::new(|| {
    let btf = simulated("silver_metallic", 30);
    let fit = FitOptions { starts: 1, coat: Some(btf.coat), ..FitOptions::default() };
    fit_btf(&btf, &fit, &FlakeOptions::default(), &|| ()).unwrap().0
});

/// Slices of 32 x 32 texels of a preset.
fn simulated(preset: &str, bins: usize) -> FlakeBtf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/compositions/{preset}.toml"));
    let model = Model::new(&Composition::read(&path).unwrap(), ModelOptions::default()).unwrap();
    let grid = AngleGrid::triangle(bins).unwrap();
    let options = SynthesisOptions { size: [32; 2], texel_mm: Some(0.02), ..SynthesisOptions::new(grid) };
    synthesize(&model, &options, &|| ()).unwrap()
}

const OPTIONS: Options = Options { samples: 2, directions: 4, seed: 1, flakes: true, random: Random::Hash };

fn scene(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/scenes/{name}.toml"));
    Scene::read(&path).unwrap()
}

/// The middle of the picture, its pixels as large as they were.
fn middle(mut scene: Scene) -> Scene {
    scene.size = scene.size.map(|n| n / 4);
    scene.camera.vertical_fov_deg /= 4.0;
    scene
}

/// A sphere under twenty lamps: as many angles as a picture can show.
fn worst() -> Scene {
    let lamp = |k: u32| {
        let (turn, z) = (2.4 * f64::from(k), -0.95 + 0.1 * f64::from(k));
        let across = (1.0 - z * z).sqrt();
        let direction = [across * turn.cos(), across * turn.sin(), z];
        DirectionalLight { direction, ..DirectionalLight::default() }.into()
    };
    Scene {
        size: [90, 120],
        shape: Shape::named("sphere").unwrap(),
        lights: (0..20).map(lamp).collect(),
        ..Scene::default()
    }
}

fn kept(paint: &Paint, scene: &Scene) -> Paint {
    let cells = needed_of_paint(scene, &OPTIONS, paint, None).unwrap().unwrap();
    let mut kept = paint.clone();
    kept.flakes.as_mut().unwrap().keep(&cells);
    kept
}

#[test]
fn pictures_of_what_is_needed_are_the_same_to_the_bit() {
    let mut scenes: Vec<Scene> = ["capsule", "close-up", "sun-and-sky", "sunlit-panel", "mesh", "clear-sky"]
        .map(|n| middle(scene(n)))
        .into();
    scenes.push(worst());
    // Refracted directions open other angles.
    let refracting = Paint { coat: ClearCoat::ideal(1.5, true), ..PAINT.clone() };
    for (k, scene) in scenes.iter().enumerate() {
        for paint in [&*PAINT, &refracting] {
            let picture =
                |p: &Paint| render(scene, &[RenderPaint::new(p).unwrap()], &OPTIONS, &|| ()).unwrap();
            assert_eq!(picture(paint), picture(&kept(paint, scene)), "scene {k}");
        }
    }
}

#[test]
fn a_paint_needs_what_the_objects_that_wear_it_show() {
    let mut scene = Scene { size: [120, 90], ..scene("capsules") };
    // Few angles; and a body that only its edge is seen of.
    scene.objects[0].shape = Shape::Panel { size_mm: [20.0, 30.0], normal: [0.3, -1.0, 0.2] };
    scene.objects[2].position_mm = [58.0, 0.0, 0.0];
    let needs = |worn| needed_of_paint(&scene, &OPTIONS, &PAINT, worn).unwrap().unwrap();
    let all = needs(None);
    let each = [0, 1, 2].map(|k| needs(Some(k)));
    let mut joined = each[0].clone();
    each.iter().for_each(|cells| joined.extend(cells));
    assert!(joined == all && each[0].len() < all.len() && each[2].len() < all.len());
    // Worn by nothing: the mean alone.
    assert_eq!(needs(Some(3)).len(), 465);
    let kept = each.map(|cells| {
        let mut kept = PAINT.clone();
        kept.flakes.as_mut().unwrap().keep(&cells);
        RenderPaint::new(&kept).unwrap()
    });
    let whole = [(); 3].map(|()| RenderPaint::new(&PAINT).unwrap());
    let picture = |paints: &[RenderPaint]| render(&scene, paints, &OPTIONS, &|| ());
    assert_eq!(picture(&whole).unwrap(), picture(&kept).unwrap());
    let [a, b, c] = kept;
    let error = picture(&[c, a, b]).unwrap_err().to_string();
    assert!(error.contains("slice: found left out"), "{error}");
}

#[test]
fn a_panel_under_one_sun_needs_at_most_a_quarter() {
    let black = Environment::Constant { radiance: [0.0; 3] };
    let sun = Scene { environment: black, ..scene("sunlit-panel") };
    let cells = needed_of_paint(&sun, &OPTIONS, &PAINT, None).unwrap().unwrap();
    assert!(4 * cells.len() <= cells.total(), "{} of {}", cells.len(), cells.total());
    // The mean of every slice, for the surroundings, and some cells that the sun draws from.
    assert!(cells.len() > 465 && cells.len_of_level(cells.levels() - 1) == 465);
    // No light, no sparkle: the mean alone.
    let dark = Scene { lights: Vec::new(), ..sun };
    assert_eq!(needed_of_paint(&dark, &OPTIONS, &PAINT, None).unwrap().unwrap().len(), 465);
    // Under a sky flakes sparkle, too.
    let sky = needed_of_paint(&scene("sunlit-panel"), &OPTIONS, &PAINT, None).unwrap().unwrap();
    assert!(sky.len() > cells.len());
}

#[test]
fn a_missing_cell_is_an_error_and_not_a_hole() {
    let panel = middle(scene("sunlit-panel"));
    let refused = |paint: &Paint, scene: &Scene, options: &Options| {
        let error =
            render(scene, &[RenderPaint::new(paint).unwrap()], options, &|| ()).unwrap_err().to_string();
        assert!(error.contains("slice: found left out"), "{error}");
    };
    let reduced = kept(&PAINT, &panel);
    refused(&reduced, &middle(scene("capsule")), &OPTIONS);
    refused(&reduced, &panel, &Options { samples: 32, ..OPTIONS });
    let cells = reduced.flakes.as_ref().unwrap().cells();
    for (level, slice) in cells.iter().step_by(97) {
        let mut one_less = reduced.clone();
        let mut fewer = carpaint::btf::CellSet::none(465, cells.levels());
        cells.iter().filter(|c| *c != (level, slice)).for_each(|(l, s)| fewer.insert(l, s));
        one_less.flakes.as_mut().unwrap().keep(&fewer);
        refused(&one_less, &panel, &OPTIONS);
    }
    // A constant world without lamps still shows the mean.
    let plain =
        Scene { lights: Vec::new(), environment: Environment::Constant { radiance: [1.0; 3] }, ..panel };
    assert!(render(&plain, &[RenderPaint::new(&reduced).unwrap()], &OPTIONS, &|| ()).is_ok());
}

#[test]
#[cfg(feature = "cli")]
fn the_plan_is_printed_and_reduced_paints_survive_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.paint.exr");
    let reduced = kept(&PAINT, &scene("sunlit-panel"));
    reduced.write(&file).unwrap();
    assert_eq!(Paint::read(&file).unwrap().flakes, reduced.flakes);
    PAINT.write(&file).unwrap();
    let run = |arguments: &[&str]| {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/scenes");
        let mut command = common::carpaint();
        command.current_dir(folder.path()).arg("plan").arg(scenes.join("sunlit-panel.toml")).args(arguments);
        command.output().unwrap()
    };
    let output = run(&["a.paint.exr", "--samples", "2"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && text.contains("level 5: 465 of 465 slices"), "{text}");
    let output = run(&["a.paint.exr", "--samples", "2", "--json"]);
    let plan: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let cells = needed_of_paint(&scene("sunlit-panel"), &OPTIONS, &PAINT, None).unwrap().unwrap();
    assert_eq!((plan["cells"].as_u64(), plan["total"].as_u64()), (Some(cells.len() as u64), Some(2790)));
    Paint { flakes: None, ..PAINT.clone() }.write(&file).unwrap();
    let output = run(&["a.paint.exr"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("flakes: found none"));
}

#[test]
#[cfg(feature = "cli")]
fn couple_and_blend_for_a_scene_give_its_picture_and_take_flake_btfs() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    simulated("silver_metallic", 12).write(&file("a.btf.exr")).unwrap();
    simulated("brown_metallic", 12).write(&file("b.btf.exr")).unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/scenes/sunlit-panel.toml");
    let for_scene = ["--scene", scene.to_str().unwrap(), "--samples", "2"];
    let run = |arguments: &[&str]| {
        let mut command = common::carpaint();
        let output = command.current_dir(folder.path()).args(arguments).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{arguments:?}: {said}");
        said
    };
    run(&["fit", "b.btf.exr", "-o", "b.paint.exr"]);
    // A flake BTF is fitted on the way, alike.
    run(&["couple", "a.btf.exr", "b.btf.exr", "-o", "whole.paint.exr"]);
    run(&["couple", "a.btf.exr", "b.paint.exr", "-o", "other.paint.exr"]);
    run(&["compare", "whole.paint.exr", "other.paint.exr"]);
    let said = run(&[&["couple", "a.btf.exr", "b.btf.exr", "-o", "few.paint.exr"][..], &for_scene].concat());
    assert!(said.contains("for the scene") && said.contains("cells"), "{said}");
    let weights = ["--weights", "0.3,0.7", "-o"];
    run(&[&["blend", "whole.paint.exr"][..], &weights, &["1.paint.exr"]].concat());
    run(&[&["blend", "few.paint.exr"][..], &weights, &["2.paint.exr"]].concat());
    run(&[&["blend", "whole.paint.exr"][..], &weights, &["3.paint.exr"], &for_scene].concat());
    run(&["compare", "2.paint.exr", "3.paint.exr"]);
    for paint in ["1", "2"] {
        let names = [format!("{paint}.paint.exr"), format!("{paint}.exr")];
        run(&[&["render", &names[0], "-o", &names[1]][..], &for_scene].concat());
    }
    assert_eq!(Picture::read(&file("1.exr")).unwrap(), Picture::read(&file("2.exr")).unwrap());
    let mut command = common::carpaint();
    let refused =
        command.current_dir(folder.path()).args(["render", "2.paint.exr", "-o", "x.png"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&refused.stderr).contains("made for another scene")
            && !file("x.png").exists()
    );
}

//! `carpaint report` as a program.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;
#[path = "common/folder.rs"]
mod folder;

use folder::Folder;
use serde_json::Value;

#[test]
fn a_page_holds_its_curves_and_needs_nothing_else() {
    let f = Folder::new(&["report"]);
    let said = f.succeed(&["-o", "out", "--quick", "--only", "transport,inks"]);
    assert!(said.contains("solver (--solver)") && said.contains("default"), "{said}");
    let text = |name: &str| std::fs::read_to_string(f.path("out").join(name)).unwrap();
    let report: Value = serde_json::from_str(&text("report.json")).unwrap();
    let curves = report["curves"].as_array().unwrap();
    let stages: Vec<&str> = curves.iter().map(|c| c["stage"].as_str().unwrap()).collect();
    assert_eq!(stages, ["Transport", "Inks"]);
    for curve in curves {
        let points = curve["points"].as_array().unwrap();
        let defaults: Vec<&Value> = points.iter().filter(|p| p["is_default"] == true).collect();
        assert_eq!(defaults.len(), 1, "{curve}");
        assert_eq!(defaults[0]["cost"]["ratio"], 1.0, "its own time");
        assert!(points.iter().any(|p| p["is_on_front"] == true));
        for point in points {
            let [low, middle, high] =
                [&point["cost"]["quartiles"][0], &point["cost"]["seconds"], &point["cost"]["quartiles"][1]]
                    .map(|v| v.as_f64().unwrap());
            assert!(0.0 < low && low <= middle && middle <= high, "{point}");
            assert!(point["error"].as_f64().unwrap() >= 0.0, "{point}");
        }
    }
    // The proven optimum, up to roundings; 41 wavelengths are the truth of inks.
    let error =
        |stage: usize| curves[stage]["points"].as_array().unwrap().iter().find(|p| p["is_default"] == true);
    assert!(error(0).unwrap()["error"].as_f64().unwrap() < 1e-9);
    assert_eq!(error(1).unwrap()["error"], 0.0);
    let rows: usize = curves.iter().map(|c| c["points"].as_array().unwrap().len()).sum();
    assert_eq!(text("curves.csv").lines().count(), 1 + rows);
    let html = text("report.html");
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let page = roxmltree::Document::parse_with_options(&html, options).unwrap();
    assert_eq!(
        page.descendants().filter(|n| n.has_tag_name(("http://www.w3.org/2000/svg", "svg"))).count(),
        2
    );
    assert!(!html.contains("<script") && !html.contains("src="), "all in one file");
}

#[test]
fn bad_input_is_named_before_anything_is_measured() {
    let f = Folder::new(&["report"]);
    std::fs::write(f.path("file"), "").unwrap();
    std::fs::write(
        f.path("bare.toml"),
        "[substrate]\nalbedo = 0.5\n[[film]]\nthickness_um = 15\nindex = 1.5\n",
    )
    .unwrap();
    f.fail(&["-o", "file", "--quick"], &["file", "a folder"]);
    f.fail(&["none.toml", "-o", "out"], &["none.toml"]);
    f.fail(&["-o", "out", "--only", "magic"], &["--only", "magic", "transport"]);
    f.fail(&["bare.toml", "-o", "out", "--quick"], &["flakes of the composition", "none"]);
    assert!(!f.path("out").exists());
}

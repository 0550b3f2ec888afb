//! The dependency direction of DESIGN: lower modules never import higher ones, neighbours never import each other.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::path::Path;

/// From the bottom up; modules of one row do not import each other.
const LAYERS: &[&[&str]] = &[
    &["error"],
    &["check", "parallel"],
    &["math", "file"],
    &["color"],
    &["brdf"],
    &["btf"],
    &["cluster", "transport"],
    &["rivals", "sampler"],
    &["paint"],
    &["mix", "simulate", "fit", "measure", "proof"],
    &["scene"],
    &["dome", "render"],
    &["gpu", "hard_cases"],
    &["report", "viewer"],
    &["tradeoff"],
    &["cli"],
];

fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|row| row.contains(&module))
}

/// The module behind a name at the crate root: itself, or where a re-export comes from.
fn home(name: String) -> String {
    match name.as_str() {
        "Paint" => "paint".to_owned(),
        "Error" | "Result" => "error".to_owned(),
        _ => name,
    }
}

/// Top modules named in a source text that stands `depth` modules below the crate root (1 for a top module itself), after
/// `crate::` or after as many `super::` as lead there, `{a::b, c}` included. Comments do not count. A module inside a file
/// (`mod tests`) stands one below it, so that one `super::` more is taken for a way to the root, too.
fn imports(text: &str, depth: usize) -> BTreeSet<String> {
    let code: String = text.lines().map(|l| l.split("//").next().unwrap_or("").to_owned() + "\n").collect();
    let mut found = after("crate::", &code);
    // A nested module is the only place from which a longer chain compiles.
    for supers in [depth, depth + 1] {
        found
            .extend(after(&"super::".repeat(supers), &code).into_iter().filter(|name| layer(name).is_some()));
    }
    found
}

/// First names of the paths that begin with `root`, which nothing of a path precedes.
fn after(root: &str, code: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices(root) {
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        let rest = &code[at + root.len()..];
        if let Some(group) = rest.strip_prefix('{') {
            let mut depth = 0;
            let mut item = String::new();
            for c in group.chars() {
                match c {
                    '{' => depth += 1,
                    '}' if depth == 0 => break,
                    '}' => depth -= 1,
                    ',' if depth == 0 => {
                        found.extend(first_name(&item));
                        item.clear();
                    }
                    _ if depth == 0 => item.push(c),
                    _ => {}
                }
            }
            found.extend(first_name(&item));
        } else {
            found.extend(first_name(rest));
        }
    }
    found
}

fn first_name(path: &str) -> Option<String> {
    let name: String = path.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    (!name.is_empty()).then(|| home(name))
}

/// What a file of a module, `depth` modules below the crate root, may not import but does.
fn violations(module: &str, depth: usize, text: &str) -> Vec<String> {
    let own = layer(module).unwrap_or_else(|| panic!("module {module} has no layer: add it to LAYERS"));
    imports(text, depth)
        .into_iter()
        .filter(|other| other != module)
        .filter(|other| layer(other).is_some_and(|l| l >= own))
        .map(|other| format!("{module} imports {other}"))
        .collect()
}

fn sources(folder: &Path, out: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

#[test]
fn lower_modules_never_import_higher_ones() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    assert!(files.len() > 30, "the sources were found");
    let mut all = Vec::new();
    for file in files {
        let inside = file.strip_prefix(&root).unwrap();
        let module = inside.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs").to_owned();
        if ["lib", "main"].contains(&module.as_str()) {
            continue;
        }
        // `a.rs` and `a/mod.rs` are module a, `a/b.rs` is one below it.
        let is_folder = usize::from(inside.ends_with("mod.rs"));
        let depth = inside.iter().count() - is_folder;
        all.extend(violations(&module, depth, &std::fs::read_to_string(&file).unwrap()));
    }
    assert!(all.is_empty(), "{all:#?}");
}

#[test]
fn forbidden_imports_are_seen_in_every_form() {
    let cases: &[(&str, usize, &str, &[&str])] = &[
        ("math", 2, "use crate::color::Lab;", &["math imports color"]),
        ("fit", 2, "fn f() { crate::simulate::g() }", &["fit imports simulate"]),
        ("btf", 2, "use crate::{error::Result, paint::{A, B}, brdf};", &["btf imports paint"]),
        ("cluster", 2, "use crate::{\n    transport,\n};", &["cluster imports transport"]),
        ("cli", 2, "use crate::{mix::Mix, render};", &[]),
        ("math", 2, "// use crate::color;\nuse crate::error::Error;", &[]),
        // Re-exports at the crate root.
        ("btf", 2, "use crate::Paint;", &["btf imports paint"]),
        ("cluster", 2, "use crate::{Error, Paint, Result};", &["cluster imports paint"]),
        ("error", 1, "use crate::{Error, Result};", &[]),
        ("mix", 2, "use crate::Paint;", &[]),
        // Up to the root and down again.
        ("math", 2, "use super::super::color::Lab;", &["math imports color"]),
        ("math", 2, "fn f() -> super::super::Paint { todo() }", &["math imports paint"]),
        ("math", 1, "use super::{color, error};", &["math imports color"]),
        ("fit", 3, "use super::super::super::simulate;", &["fit imports simulate"]),
        (
            "fit",
            2,
            "mod tests { use super::super::super::{brdf, render::Picture}; }",
            &["fit imports render"],
        ),
        // A file of the same module that bears the name of another one.
        ("report", 2, "use super::transport;", &[]),
        ("render", 2, "use super::paint::RenderPaint;", &[]),
    ];
    for (module, depth, text, expected) in cases {
        assert_eq!(violations(module, *depth, text), *expected, "{text}");
    }
}

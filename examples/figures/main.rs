//! The figures of the five papers, with simulated paints: `cargo run --release --example figures -- [FIGURE...] [-o FOLDER]`.
//!
//! A figure is a file: it draws its picture and finds the number that its claim stands for. Without names all are drawn, `--list` names
//! them. The exit code is 1 where a claim does not hold.

mod ershov_1999;
mod ershov_2001;
mod golla_2018;
mod mosaic;
mod paints;
mod panel;
mod pictures;
mod plots;
mod pranovich_2024;
mod rump_2008;
mod smooth;

use carpaint::error::{Error, Result};
use clap::Parser;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Draw the figures of the papers and print the numbers that their claims stand for.
#[derive(Parser)]
struct Arguments {
    /// Figures by name (golla-2018-6), or papers (golla-2018) [default: all].
    names: Vec<String>,
    /// Folder to write into; made if missing.
    #[arg(short, long, default_value = "figures")]
    output: PathBuf,
    /// Name the figures and their claims alone.
    #[arg(long)]
    list: bool,
}

/// A figure of a paper.
struct Figure {
    /// Author, year and number: `golla-2018-6`.
    name: &'static str,
    /// What it is to show, in one sentence.
    claim: &'static str,
    /// Draws it, as files whose names begin with that path, and measures the claim.
    draw: fn(&Path) -> Result<Finding>,
}

/// What a figure's claim comes to.
struct Finding {
    /// The number or numbers, with unit, in a sentence.
    says: String,
    /// Whether the claim holds.
    holds: bool,
}

fn main() -> ExitCode {
    run(Arguments::parse()).unwrap_or_else(|error| {
        // Where standard error is closed there is nobody to tell.
        let _ = writeln!(std::io::stderr(), "error: {error}");
        ExitCode::from(2)
    })
}

fn run(arguments: Arguments) -> Result<ExitCode> {
    let figures = chosen(&arguments.names)?;
    if arguments.list {
        figures.iter().for_each(|figure| say(&format!("{}: {}", figure.name, figure.claim)));
        return Ok(ExitCode::SUCCESS);
    }
    std::fs::create_dir_all(&arguments.output).map_err(|e| Error::io(&arguments.output, e))?;
    let mut all_hold = true;
    for figure in figures {
        let Finding { says, holds } = (figure.draw)(&arguments.output.join(figure.name))?;
        let verdict = if holds { "holds" } else { "DOES NOT HOLD" };
        say(&format!("{}: {}\n  {verdict}: {says}", figure.name, figure.claim));
        all_hold &= holds;
    }
    Ok(ExitCode::from(u8::from(!all_hold)))
}

/// The figures of these names or papers, all without any.
fn chosen(names: &[String]) -> Result<Vec<&'static Figure>> {
    let papers = [
        ershov_1999::FIGURES,
        ershov_2001::FIGURES,
        rump_2008::FIGURES,
        golla_2018::FIGURES,
        pranovich_2024::FIGURES,
    ];
    let all: Vec<&Figure> = papers.into_iter().flatten().collect();
    let is_of = |figure: &Figure, name: &str| {
        figure.name.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
    };
    if let Some(name) = names.iter().find(|name| !all.iter().any(|figure| is_of(figure, name))) {
        return Err(Error::invalid("figures", "name", name, "one that --list prints"));
    }
    let wanted = |figure: &&Figure| names.is_empty() || names.iter().any(|name| is_of(figure, name));
    Ok(all.into_iter().filter(wanted).collect())
}

fn say(text: &str) {
    // A closed pipe is no reason to stop.
    let _ = writeln!(std::io::stdout(), "{text}");
}

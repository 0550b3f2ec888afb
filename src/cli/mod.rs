//! The command line: one file a command. Exit codes: 0 fine, 1 a comparison or validation found a difference, 2 bad input.

mod blend;
mod brdf_output;
mod budget;
mod calibrate;
mod capture;
mod compare;
mod couple;
mod demo;
mod device;
mod drawing;
mod eval;
mod eval_gonio;
mod eval_paint;
mod fit;
mod fit_ink;
mod fit_output;
mod flake_source;
mod goniometer;
mod halftone;
mod hard_cases;
mod inspect;
mod measure;
mod model;
mod output;
mod overlay;
mod page;
mod plan;
mod progress;
mod proof;
mod readings;
mod render;
mod report;
mod scene;
mod simulate;
mod synthesis;
mod transport;
mod validate;
mod validate_capture;
mod validate_tables;
#[cfg(feature = "viewer")]
mod view;

use crate::error::Result;
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Longest JSON file read; the reference files have some megabytes.
const MAX_JSON_BYTES: u64 = 1 << 28;

/// Measured metallic car paint: simulate, fit, couple, interpolate, render.
#[derive(Parser)]
#[command(name = "carpaint", version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::Arguments),
    Simulate(simulate::Arguments),
    Measure(measure::Arguments),
    Calibrate(calibrate::Arguments),
    Fit(fit::Arguments),
    Couple(couple::Arguments),
    Blend(blend::Arguments),
    Plan(plan::Arguments),
    Render(render::Arguments),
    Proof(proof::Arguments),
    #[cfg(feature = "viewer")]
    View(view::Arguments),
    Halftone(halftone::Arguments),
    Inspect(inspect::Arguments),
    Compare(compare::Arguments),
    Transport(transport::Arguments),
    Validate(validate::Arguments),
    Report(report::Arguments),
    Eval(eval::Arguments),
}

/// Runs the program on the process's arguments.
pub fn main() -> ExitCode {
    let outcome: Result<ExitCode> = match Arguments::parse().command {
        Command::Demo(a) => a.run(),
        Command::Simulate(a) => a.run(),
        Command::Measure(a) => a.run(),
        Command::Calibrate(a) => a.run(),
        Command::Fit(a) => a.run(),
        Command::Couple(a) => a.run(),
        Command::Blend(a) => a.run(),
        Command::Plan(a) => a.run(),
        Command::Render(a) => a.run(),
        Command::Proof(a) => a.run(),
        #[cfg(feature = "viewer")]
        Command::View(a) => a.run(),
        Command::Halftone(a) => a.run(),
        Command::Inspect(a) => a.run(),
        Command::Compare(a) => a.run(),
        Command::Transport(a) => a.run(),
        Command::Validate(a) => a.run(),
        Command::Report(a) => a.run(),
        Command::Eval(a) => a.run(),
    };
    outcome.unwrap_or_else(|error| {
        output::note!("error: {error}");
        ExitCode::from(2)
    })
}

//! The report as one page: no script, nothing from elsewhere.

use super::drawing::{escape, tradeoff};
use super::report::{Cell, Machine, Report};
use crate::tradeoff::{Axis, Curve, Point};
use std::fmt::Write;

const STYLE: &str = "body{font:15px/1.45 Helvetica,Arial,'DejaVu Sans',sans-serif;color:#22252a;max-width:1000px;margin:2em auto;padding:0 1em}\
    table{border-collapse:collapse;margin:.6em 0 1.2em}\
    th,td{padding:.2em .7em;border-bottom:1px solid #dfe2e6;text-align:right;font-variant-numeric:tabular-nums}\
    td{white-space:nowrap}th:first-child,td:first-child,.words{text-align:left;white-space:normal}\
    h1{font-size:1.6em}h2{font-size:1.25em;margin-top:2em}.note{color:#6b717a}\
    .default{background:#eef3f8;font-weight:600}.behind{color:#d55e00}svg{max-width:100%;height:auto}";

/// The page, as HTML that is XML, too.
pub fn html(report: &Report) -> String {
    let mut page = String::new();
    let machine = &report.machine;
    let _ = write!(
        page,
        "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\"><head><meta charset=\"utf-8\"/><title>carpaint: speed against error</title>\
         <style>{STYLE}</style></head><body>\n<h1>Speed against error</h1>\n\
         <p>Measured on {} with carpaint {}: {}, {}, {} cores, {}. Seed {}; settings of a knob are timed in turns, \
         {} at most. All of it took {:.0} s{}.</p>\n",
        escape(if report.paint.is_empty() { "a paint" } else { &report.paint }),
        machine.version,
        escape(&machine.system),
        escape(&machine.processor),
        machine.cores,
        escape(&machine.adapter),
        report.effort.seed,
        report.curves.iter().flat_map(|c| &c.points).map(|p| p.cost.turns).max().unwrap_or(0),
        report.seconds,
        report.peak_mib.map_or_else(String::new, |mib| format!(" and {mib:.0} MiB")),
    );
    defaults(&mut page, &report.curves);
    for (k, curve) in report.curves.iter().enumerate() {
        section(&mut page, k, curve);
    }
    page + "</body></html>\n"
}

/// A default beside its neighbors on the front: name, time, error, the next cheaper one, the next better one.
fn default_row(curve: &Curve) -> Option<[String; 5]> {
    let default = curve.points.iter().find(|point| point.is_default)?;
    let front = || curve.points.iter().filter(|point| point.is_on_front && !point.is_default);
    let cheaper = front().filter(|point| point.relative < default.relative);
    let cheaper = cheaper.max_by(|a, b| a.relative.total_cmp(&b.relative));
    let better = front().filter(|point| point.error < default.error);
    let better = better.min_by(|a, b| a.relative.total_cmp(&b.relative));
    let Cell { setting, error, .. } = Cell::of(default);
    Some([setting, time(default.cost.seconds), error, neighbor(cheaper), neighbor(better)])
}

/// What every default costs and buys, as Markdown.
pub fn defaults_table(report: &Report) -> String {
    let Machine { version, system, processor, cores, adapter } = &report.machine;
    let mut text = format!(
        "carpaint {version}, {system}, {processor}, {cores} cores, {adapter}; {}, seed {}. Written by `carpaint report`.\n\n\
         | stage | knob | default | time | error | next cheaper | next better | what the error is |\n|---|---|---|---|---|---|---|---|\n",
        report.paint, report.effort.seed
    );
    for curve in &report.curves {
        if let Some(cells) = default_row(curve) {
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} |",
                curve.stage,
                curve.knob,
                cells.join(" | "),
                curve.error
            );
        }
    }
    text
}

/// What every default costs, and what the next settings of the front would save or add.
fn defaults(page: &mut String, curves: &[Curve]) {
    *page += "<h2>Defaults</h2>\n<p class=\"note\">Beside each default the next cheaper and the next better setting of the front: times, \
        or bytes where a curve weighs these, are ratios to the default's.</p>\n<table><tr><th>stage and knob</th><th class=\"words\">default</th><th>time</th><th>error</th>\
        <th class=\"words\">cheaper</th><th class=\"words\">better</th></tr>\n";
    for (k, curve) in curves.iter().enumerate() {
        let Some(cells) = default_row(curve) else { continue };
        let [setting, time, error, cheaper, better] = cells.map(|cell| escape(&cell));
        let _ = writeln!(
            page,
            "<tr><td><a href=\"#c{k}\">{}: {}</a></td><td class=\"words\">{setting}</td><td>{time}</td><td>{error}</td>\
             <td class=\"words\">{cheaper}</td><td class=\"words\">{better}</td></tr>",
            escape(curve.stage),
            escape(curve.knob),
        );
    }
    *page += "</table>\n";
}

fn neighbor(point: Option<&Point>) -> String {
    let Some(point) = point else { return "-".to_owned() };
    let Cell { setting, ratio, error } = Cell::of(point);
    format!("{setting}: \u{d7}{ratio}, error {error}")
}

/// A curve: diagram, table, and why the default is what it is.
fn section(page: &mut String, k: usize, curve: &Curve) {
    let diagram = tradeoff(curve);
    // Inside of a page there is no head of a document.
    let diagram = diagram.find("<svg").map_or("", |at| &diagram[at..]);
    let _ = write!(
        page,
        "<h2 id=\"c{k}\">{}: {}</h2>\n<p>Error: {}.</p>\n{diagram}\n<p>{}</p>\n<table><tr><th>setting</th><th>time</th><th>quartiles</th>\
         <th>{}</th><th>error</th>{}<th></th></tr>\n",
        escape(curve.stage),
        escape(curve.knob),
        escape(curve.error),
        escape(curve.why),
        if curve.axis == Axis::Time { "ratio" } else { "ratio of bytes" },
        if curve.points.iter().any(|p| p.bytes.is_some()) { "<th>bytes</th>" } else { "" }
    );
    for point in &curve.points {
        let Cell { setting, ratio, error } = Cell::of(point);
        let [low, high] = point.cost.quartiles.map(time);
        let (class, words) = match (point.is_default, point.is_on_front) {
            (true, true) => ("default", "default"),
            (true, false) => ("default", "default, behind the front"),
            (false, true) => ("", ""),
            (false, false) => ("behind", "behind the front"),
        };
        let _ = writeln!(
            page,
            "<tr class=\"{class}\"><td>{}</td><td>{}</td><td>{low} to {high}</td><td>{ratio}</td><td>{error}</td>{}\
             <td class=\"words\">{words}</td></tr>",
            escape(&setting),
            time(point.cost.seconds),
            point.bytes.map_or_else(String::new, |bytes| format!("<td>{bytes:.0}</td>"))
        );
    }
    *page += "</table>\n";
}

/// A time for people.
fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.1} \u{b5}s", 1e6 * s),
        s if s < 0.1 => format!("{:.2} ms", 1e3 * s),
        s if s < 1.0 => format!("{:.0} ms", 1e3 * s),
        s => format!("{s:.2} s"),
    }
}

//! The few shapes of SVG that the pictures need.

use std::fmt::Write;

/// Ink of lines and letters.
pub const INK: &str = "#22252a";
/// Ink of what explains.
pub const FAINT: &str = "#6b717a";

/// Shapes in the order drawn.
#[derive(Default)]
pub struct Svg {
    body: String,
    clips: usize,
}

impl Svg {
    /// A shape, with its attributes.
    pub fn shape(&mut self, element: &str) {
        let _ = writeln!(self.body, "<{element}/>");
    }

    pub fn rect(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], style: &str) {
        self.shape(&format!(r#"rect x="{x:.2}" y="{y:.2}" width="{width:.2}" height="{height:.2}" {style}"#));
    }

    pub fn line(&mut self, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], style: &str) {
        self.shape(&format!(r#"line x1="{x1:.2}" y1="{y1:.2}" x2="{x2:.2}" y2="{y2:.2}" {style}"#));
    }

    pub fn circle(&mut self, [x, y]: [f64; 2], radius: f64, style: &str) {
        self.shape(&format!(r#"circle cx="{x:.2}" cy="{y:.2}" r="{radius:.2}" {style}"#));
    }

    /// An open line through points.
    pub fn polyline(&mut self, points: &[[f64; 2]], style: &str) {
        let list: Vec<String> = points.iter().map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
        self.shape(&format!(r#"polyline points="{}" fill="none" {style}"#, list.join(" ")));
    }

    /// Text of a size, `anchor` being start, middle or end.
    pub fn text(&mut self, at: [f64; 2], size: f64, anchor: &str, text: &str) {
        self.letters(at, size, anchor, INK, text);
    }

    /// Small text that explains.
    pub fn note(&mut self, at: [f64; 2], anchor: &str, text: &str) {
        self.letters(at, 12.0, anchor, FAINT, text);
    }

    fn letters(&mut self, [x, y]: [f64; 2], size: f64, anchor: &str, fill: &str, text: &str) {
        let style = format!(r#"font-size="{size}" text-anchor="{anchor}" fill="{fill}""#);
        let _ = writeln!(self.body, r#"<text x="{x:.2}" y="{y:.2}" {style}>{}</text>"#, escape(text));
    }

    /// Shapes that `draw` adds are moved.
    pub fn moved(&mut self, [x, y]: [f64; 2], draw: impl FnOnce(&mut Self)) {
        let _ = writeln!(self.body, r#"<g transform="translate({x:.2} {y:.2})">"#);
        draw(self);
        self.body.push_str("</g>\n");
    }

    /// Shapes that `draw` adds are seen inside of a rectangle only.
    pub fn clipped(&mut self, at: [f64; 2], size: [f64; 2], draw: impl FnOnce(&mut Self)) {
        self.clips += 1;
        let name = format!("clip{}", self.clips);
        let _ = write!(self.body, r#"<clipPath id="{name}">"#);
        self.rect(at, size, "");
        let _ = writeln!(self.body, r#"</clipPath><g clip-path="url(#{name})">"#);
        draw(self);
        self.body.push_str("</g>\n");
    }

    /// The document, of a size.
    pub fn finish(self, [width, height]: [f64; 2]) -> String {
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" \
             height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"Helvetica, Arial, 'DejaVu \
             Sans', sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{}</svg>\n",
            self.body
        )
    }
}

/// Text as XML holds it; characters that XML forbids are left out.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => {}
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_break_out() {
        assert_eq!(escape("a<b>&\"c\"\n\u{0}\u{ffff}é"), "a&lt;b&gt;&amp;&quot;c&quot;  é");
    }
}

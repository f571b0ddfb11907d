//! Pictures as SVG: small, with text as text, and with where they come from.

use std::fmt::Write;

use super::display::{Anchor, Item, Picture, Provenance, Segment, Spot, Stroke, Text};
use super::{Color, clip};

/// Fonts of letters that need no columns.
const FONTS: &str = "Helvetica, Arial, 'Liberation Sans', 'Noto Sans', sans-serif";
/// Fonts of letters in columns.
const MONO: &str = "'DejaVu Sans Mono', 'Noto Sans Mono', Menlo, Consolas, monospace";

/// The picture as the text of an SVG file; the same picture is always the same text.
#[must_use]
pub fn svg(picture: &Picture) -> String {
    let mut out = Out {
        text: String::new(),
        clips: 0,
    };
    let (width, height) = (number(picture.size.0), number(picture.size.1));
    out.line(r#"<?xml version="1.0" encoding="UTF-8"?>"#);
    out.line(&format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width}pt" height="{height}pt" viewBox="0 0 {width} {height}" font-family="{FONTS}">"#
    ));
    out.provenance(&picture.provenance);
    out.line(&format!(
        r#"<rect width="{width}" height="{height}" {}/>"#,
        paint("fill", picture.background)
    ));
    clip::each(picture, |item| out.item(item));
    out.line("</svg>");
    out.text
}

struct Out {
    text: String,
    clips: usize,
}

impl Out {
    fn line(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn provenance(&mut self, provenance: &Provenance) {
        self.line(&format!("<title>{}</title>", escaped(&provenance.title)));
        self.line(&format!(
            "<desc>{}</desc>",
            escaped(&provenance.description)
        ));
        let facts = provenance.facts.iter();
        let facts: String = facts
            .map(|(name, value)| format!(r#" {name}="{}""#, escaped(value)))
            .collect();
        if !facts.is_empty() {
            self.line(&format!(
                r#"<metadata><figure xmlns="urn:nearmiss:figure"{facts}/></metadata>"#
            ));
        }
    }

    fn item(&mut self, item: &Item) {
        match item {
            Item::Path { path, fill, stroke } => {
                let fill = fill.map_or_else(|| r#"fill="none""#.to_string(), |c| paint("fill", c));
                let stroke = stroke.as_ref().map(stroke_words).unwrap_or_default();
                let data = path_data(path);
                self.line(&format!(r#"<path d="{data}" {fill}{stroke}/>"#));
            }
            Item::Text(text) => self.text(text),
            Item::Begin { name, clip } => {
                let Some(area) = clip else {
                    return self.line(&format!(r#"<g class="{name}">"#));
                };
                self.clips += 1;
                let id = format!("clip{}", self.clips);
                self.line(&format!(
                    r#"<clipPath id="{id}"><rect x="{}" y="{}" width="{}" height="{}"/></clipPath>"#,
                    number(area.x),
                    number(area.y),
                    number(area.width),
                    number(area.height)
                ));
                self.line(&format!(r#"<g class="{name}" clip-path="url(#{id})">"#));
            }
            Item::End => self.line("</g>"),
        }
    }

    fn text(&mut self, text: &Text) {
        let (x, y) = (number(text.at.0), number(text.at.1));
        let mut attributes = format!(r#" font-size="{}""#, number(text.size));
        if text.upwards {
            let _ = write!(attributes, r#" transform="translate({x} {y}) rotate(-90)""#);
        } else {
            let _ = write!(attributes, r#" x="{x}" y="{y}""#);
        }
        match text.anchor {
            Anchor::Start => {}
            Anchor::Middle => attributes.push_str(r#" text-anchor="middle""#),
            Anchor::End => attributes.push_str(r#" text-anchor="end""#),
        }
        if text.bold {
            attributes.push_str(r#" font-weight="bold""#);
        }
        if let Some(pitch) = text.pitch {
            let length = number(pitch * text.words.chars().count() as f64);
            let _ = write!(
                attributes,
                r#" font-family="{MONO}" xml:space="preserve" textLength="{length}" lengthAdjust="spacingAndGlyphs""#
            );
        }
        let words = escaped(&text.words);
        if let Some(halo) = text.halo {
            // A second text below, as not every program knows paint-order.
            let (fill, stroke) = (paint("fill", halo), paint("stroke", halo));
            let width = number(text.size * HALO);
            self.line(&format!(
                r#"<text{attributes} {fill} {stroke} stroke-width="{width}" stroke-linejoin="round" aria-hidden="true">{words}</text>"#
            ));
        }
        self.line(&format!(
            "<text{attributes} {}>{words}</text>",
            paint("fill", text.color)
        ));
    }
}

/// Width of the line of a halo in parts of the size of the letters.
pub(super) const HALO: f64 = 0.3;

fn paint(what: &str, color: Color) -> String {
    if color.opacity < 1.0 {
        format!(
            r#"{what}="{color}" {what}-opacity="{}""#,
            number(color.opacity)
        )
    } else {
        format!(r#"{what}="{color}""#)
    }
}

fn stroke_words(stroke: &Stroke) -> String {
    let mut words = format!(
        r#" {} stroke-width="{}""#,
        paint("stroke", stroke.color),
        number(stroke.width)
    );
    if !stroke.dashes.is_empty() {
        let dashes: Vec<String> = stroke.dashes.iter().map(|d| number(*d)).collect();
        let _ = write!(words, r#" stroke-dasharray="{}""#, dashes.join(" "));
        if stroke.phase > 0.0 {
            let _ = write!(words, r#" stroke-dashoffset="{}""#, number(stroke.phase));
        }
    }
    if stroke.round {
        words.push_str(r#" stroke-linecap="round" stroke-linejoin="round""#);
    }
    words
}

fn path_data(path: &[Segment]) -> String {
    let mut data = String::new();
    let pair = |(x, y): &Spot| format!("{} {}", number(*x), number(*y));
    for segment in path {
        let _ = match segment {
            Segment::Move(p) => write!(data, "M{}", pair(p)),
            Segment::Line(p) => write!(data, "L{}", pair(p)),
            Segment::Curve(a, b, c) => write!(data, "C{} {} {}", pair(a), pair(b), pair(c)),
            Segment::Close => write!(data, "Z"),
        };
    }
    data
}

/// A hundredth of a point is finer than any printer.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    match short {
        "-0" | "" => "0".into(),
        short => short.into(),
    }
}

/// Text as XML may hold it: no markup, and what XML forbids as the sign for it.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::Area;

    #[test]
    fn hostile_words_stay_words() {
        let hostile = "\"><script>alert(1)</script>&\u{1b}[31m\u{0}'";
        let mut picture = Picture::new((10.0, 10.0), Color::hex(0xffffff));
        picture.provenance = Provenance {
            title: hostile.into(),
            description: hostile.into(),
            facts: vec![("scenario", hostile.into())],
        };
        let text = Text::new((1.0, 2.0), hostile, 7.0, Color::hex(0));
        picture.text(text.with_halo(Color::hex(0xffffff)));
        let svg = svg(&picture);
        assert!(!svg.contains("<script") && !svg.contains('\u{1b}') && !svg.contains('\u{0}'));
        assert_eq!(svg.matches("&lt;script&gt;").count(), 5);
        assert_eq!(svg.matches('"').count() % 2, 0);
    }

    #[test]
    fn numbers_are_short_and_groups_end() {
        for (value, written) in [(1.0, "1"), (-0.001, "0"), (2.5, "2.5"), (1.0 / 3.0, "0.33")] {
            assert_eq!(number(value), written);
        }
        let mut picture = Picture::new((10.0, 10.0), Color::hex(0xffffff));
        let area = Area {
            x: 0.0,
            y: 0.0,
            width: 5.0,
            height: 5.0,
        };
        picture.group("empty", None, |_| {});
        picture.group("full", Some(area), |p| p.rectangle(&area, None, None));
        let svg = svg(&picture);
        assert_eq!(svg.matches("<g ").count(), 1);
        assert_eq!(svg.matches("</g>").count(), 1);
        assert!(svg.contains("url(#clip1)"));
    }
}

//! Pictures in pixels, with smooth edges: as PNG with resolution and provenance, and as sixels for terminals.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write;

use tiny_skia::{
    FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Stroke as Line,
    StrokeDash, Transform,
};

use super::animation::Colors;
use super::display::{Anchor, Area, Item, Picture, Segment, Stroke, Text};
use super::svg::HALO;
use super::{Color, clip, glyphs};

/// Pixels that a picture has at most.
pub const MOST_PIXELS: u64 = 64_000_000;

/// Why a picture cannot be made of pixels.
#[derive(Debug, thiserror::Error)]
pub enum RasterError {
    /// It would be too large, or nothing at all.
    #[error(
        "{width} × {height} pixels: pictures have 1 to {} million; choose another size or a lower resolution",
        MOST_PIXELS / 1_000_000
    )]
    Size {
        /// Pixels.
        width: u64,
        /// Pixels.
        height: u64,
    },
    /// The encoder refused.
    #[error("the PNG could not be written: {0}")]
    Encoding(String),
}

/// Pixels with smooth edges, opaque.
pub fn pixels(picture: &Picture, dpi: f64) -> Result<Pixmap, RasterError> {
    let scale = dpi / 72.0;
    // A size in pixels comes back as exactly that size.
    let count = |points: f64| (points * scale - 1e-6).ceil().max(0.0) as u64;
    let (width, height) = (count(picture.size.0), count(picture.size.1));
    let size = RasterError::Size { width, height };
    let fits = width * height <= MOST_PIXELS && width <= 65_000 && height <= 65_000;
    let (Ok(w), Ok(h), true) = (u32::try_from(width), u32::try_from(height), fits) else {
        return Err(size);
    };
    let transform = Transform::from_scale(scale as f32, scale as f32);
    painted(picture, w, h, transform, true, &|_, _| true).ok_or(size)
}

/// The whole picture in so many pixels, whatever their proportions, with those strokes that are `seen` by their group;
/// `None` for none. Surfaces have hard edges: between soft ones a cell would have more colours than it can show.
pub fn stretched(
    picture: &Picture,
    width: u32,
    height: u32,
    seen: &dyn Fn(&str, &Stroke) -> bool,
) -> Option<Pixmap> {
    let (x, y) = (
        f64::from(width) / picture.size.0,
        f64::from(height) / picture.size.1,
    );
    let transform = Transform::from_scale(x as f32, y as f32);
    painted(picture, width, height, transform, false, seen)
}

fn painted(
    picture: &Picture,
    width: u32,
    height: u32,
    transform: Transform,
    soft: bool,
    seen: &dyn Fn(&str, &Stroke) -> bool,
) -> Option<Pixmap> {
    let mut pixmap = Pixmap::new(width, height)?;
    let Color {
        red, green, blue, ..
    } = picture.background;
    pixmap.fill(tiny_skia::Color::from_rgba8(red, green, blue, 255));
    let mut canvas = Canvas {
        pixmap,
        transform,
        soft,
        clips: vec![None],
    };
    let mut groups = Vec::new();
    clip::each(picture, |item| {
        match item {
            Item::Begin { name, .. } => groups.push(*name),
            Item::End => drop(groups.pop()),
            _ => {}
        }
        let group = groups.last().copied().unwrap_or_default();
        canvas.item(item, &|stroke| seen(group, stroke));
    });
    Some(canvas.pixmap)
}

struct Canvas {
    pixmap: Pixmap,
    transform: Transform,
    /// Whether the edges of what is filled are anti-aliased.
    soft: bool,
    /// What is seen at present, the innermost last.
    clips: Vec<Option<Mask>>,
}

impl Canvas {
    fn item(&mut self, item: &Item, seen: &dyn Fn(&Stroke) -> bool) {
        match item {
            Item::Path { path, fill, stroke } => {
                let stroke = stroke.as_ref().filter(|stroke| seen(stroke));
                if fill.is_none() && stroke.is_none() {
                    return;
                }
                let Some(path) = outline(path) else { return };
                if let Some(color) = fill {
                    self.fill(&path, *color, FillRule::Winding, self.transform);
                }
                if let Some(stroke) = stroke {
                    self.stroke(&path, stroke, self.transform);
                }
            }
            Item::Text(text) => self.text(text),
            Item::Begin { clip, .. } => self.begin(clip.as_ref()),
            Item::End => {
                self.clips.pop();
            }
        }
    }

    fn begin(&mut self, clip: Option<&Area>) {
        let before = self.clips.last().cloned().flatten();
        let clip = clip.and_then(|area| {
            let path = tiny_skia::Rect::from_xywh(
                area.x as f32,
                area.y as f32,
                area.width as f32,
                area.height as f32,
            );
            let path = PathBuilder::from_rect(path?);
            let mut mask = match before.clone() {
                Some(mask) => mask,
                None => {
                    let mut mask = Mask::new(self.pixmap.width(), self.pixmap.height())?;
                    mask.invert();
                    mask
                }
            };
            mask.intersect_path(&path, FillRule::Winding, true, self.transform);
            Some(mask)
        });
        self.clips.push(clip.or(before));
    }

    fn fill(&mut self, path: &Path, color: Color, rule: FillRule, transform: Transform) {
        let mask = self.clips.last().and_then(Option::as_ref);
        let paint = Paint {
            anti_alias: self.soft,
            ..paint(color)
        };
        self.pixmap.fill_path(path, &paint, rule, transform, mask);
    }

    fn stroke(&mut self, path: &Path, stroke: &Stroke, transform: Transform) {
        let mask = self.clips.last().and_then(Option::as_ref);
        let line = line(stroke);
        self.pixmap
            .stroke_path(path, &paint(stroke.color), &line, transform, mask);
    }

    fn text(&mut self, text: &Text) {
        let Some((path, width)) = letters(text) else {
            return;
        };
        let shift = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -width / 2.0,
            Anchor::End => -width,
        };
        let mut transform = self
            .transform
            .pre_translate(text.at.0 as f32, text.at.1 as f32);
        if text.upwards {
            transform = transform.pre_rotate(-90.0);
        }
        let transform = transform.pre_translate(shift, 0.0);
        if let Some(halo) = text.halo {
            let stroke = Stroke::new(halo, text.size * HALO).rounded();
            self.stroke(&path, &stroke, transform);
        }
        self.fill(&path, text.color, FillRule::EvenOdd, transform);
    }
}

/// A line as the painter takes it.
pub fn line(stroke: &Stroke) -> Line {
    let dashes: Vec<f32> = stroke.dashes.iter().map(|d| *d as f32).collect();
    Line {
        width: stroke.width as f32,
        line_cap: if stroke.round {
            LineCap::Round
        } else {
            LineCap::Butt
        },
        line_join: if stroke.round {
            LineJoin::Round
        } else {
            LineJoin::Miter
        },
        dash: StrokeDash::new(dashes, stroke.phase as f32),
        ..Line::default()
    }
}

/// A colour as the painter takes it.
pub fn paint(color: Color) -> Paint<'static> {
    let mut paint = Paint::default();
    let opacity = (color.opacity * 255.0).round().clamp(0.0, 255.0) as u8;
    paint.set_color_rgba8(color.red, color.green, color.blue, opacity);
    paint
}

/// An outline as the painter takes it; `None` for nothing.
pub fn outline(path: &[Segment]) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for segment in path {
        match *segment {
            Segment::Move((x, y)) => builder.move_to(x as f32, y as f32),
            Segment::Line((x, y)) => builder.line_to(x as f32, y as f32),
            Segment::Curve(a, b, c) => {
                let [a, b, c] = [a, b, c].map(|(x, y)| (x as f32, y as f32));
                builder.cubic_to(a.0, a.1, b.0, b.1, c.0, c.1);
            }
            Segment::Close => builder.close(),
        }
    }
    builder.finish()
}

/// The outlines of a line of text from its beginning on, and its width, points; `None` for nothing but spaces.
fn letters(text: &Text) -> Option<(Path, f32)> {
    let size = text.size as f32;
    let mut builder = PathBuilder::new();
    let mut x = 0.0;
    let words: Cow<'_, str> = if text.words.contains('…') && text.pitch.is_none() {
        text.words.replace('…', "...").into()
    } else {
        text.words.as_str().into()
    };
    for c in words.chars() {
        let glyph = glyphs::glyph(c, text.bold);
        let (advance, shift, across) = match text.pitch {
            // As wide as its column.
            Some(pitch) => (pitch as f32, 0.0, pitch as f32 / (glyphs::pitch() * size)),
            None => {
                let (advance, shift) = glyphs::advance(c, &glyph);
                (advance * size, shift * size, glyphs::narrow())
            }
        };
        for ring in &glyph.contours {
            for (i, (gx, gy)) in ring.iter().enumerate() {
                let (gx, gy) = (x + shift + gx * across * size, gy * size);
                match i {
                    0 => builder.move_to(gx, gy),
                    _ => builder.line_to(gx, gy),
                }
            }
            builder.close();
        }
        x += advance;
    }
    Some((builder.finish()?, x))
}

/// Red, green and blue of every pixel.
pub fn rgb(pixmap: &Pixmap) -> Vec<u8> {
    let opaque = pixmap.pixels().iter();
    opaque
        .flat_map(|p| [p.red(), p.green(), p.blue()])
        .collect()
}

/// The picture as a PNG file of so many pixels an inch; the same picture is always the same bytes.
///
/// # Errors
/// It would have too many pixels.
pub fn png(picture: &Picture, dpi: f64) -> Result<Vec<u8>, RasterError> {
    let pixmap = pixels(picture, dpi)?;
    let refused = |error: png::EncodingError| RasterError::Encoding(error.to_string());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let per_metre = (dpi / 0.0254).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: per_metre,
        yppu: per_metre,
        unit: png::Unit::Meter,
    }));
    let provenance = &picture.provenance;
    let facts = provenance.facts.iter().map(|(name, value)| (*name, value));
    let named = [
        ("Title", &provenance.title),
        ("Description", &provenance.description),
    ];
    let told = named.into_iter().chain(facts);
    for (name, value) in told.filter(|(_, value)| !value.is_empty()) {
        let keyword = match name {
            "program" => "Software",
            other => other,
        };
        // International text: any character may stand in a name.
        encoder
            .add_itxt_chunk(keyword.into(), value.replace('\0', "\u{fffd}"))
            .map_err(refused)?;
    }
    let mut writer = encoder.write_header().map_err(refused)?;
    writer.write_image_data(&rgb(&pixmap)).map_err(refused)?;
    writer.finish().map_err(refused)?;
    Ok(bytes)
}

/// The picture as a sixel sequence of at most 256 colours; one pixel of it is one of the terminal's.
///
/// # Errors
/// It would have too many pixels.
pub fn sixel(picture: &Picture, dpi: f64) -> Result<String, RasterError> {
    let pixmap = pixels(picture, dpi)?;
    let (width, height) = (pixmap.width() as usize, pixmap.height());
    let frame = rgb(&pixmap);
    let mut colors = Colors::from_frames(std::iter::once(&frame[..]));
    let mut out = format!("\x1bP0;1q\"1;1;{width};{height}");
    for (place, color) in colors.table().chunks_exact(3).enumerate() {
        let _ = write!(out, "#{place};2");
        for value in color {
            let _ = write!(out, ";{}", (u32::from(*value) * 100 + 127) / 255);
        }
    }
    let places: Vec<u8> = frame
        .chunks_exact(3)
        .map(|p| colors.place([p[0], p[1], p[2]]))
        .collect();
    for (i, band) in places.chunks(6 * width).enumerate() {
        if i > 0 {
            out.push('-');
        }
        // For each colour and column, the rows that have it, as bits.
        let mut layers: BTreeMap<u8, Vec<u8>> = BTreeMap::new();
        for (y, row) in band.chunks(width).enumerate() {
            for (x, place) in row.iter().enumerate() {
                layers.entry(*place).or_insert_with(|| vec![0; width])[x] |= 1 << y;
            }
        }
        for (place, columns) in layers {
            let _ = write!(out, "#{place}");
            for run in columns.chunk_by(|a, b| a == b) {
                let sixel = char::from(b'?' + run[0]);
                match run.len() {
                    count @ 0..4 => out.extend(std::iter::repeat_n(sixel, count)),
                    count => {
                        let _ = write!(out, "!{count}{sixel}");
                    }
                }
            }
            out.push('$');
        }
    }
    out.push_str("\x1b\\");
    Ok(out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{Color, Stroke};

    /// Reads sixels back: the width and the colours of all pixels, percent.
    fn decoded(sent: &str) -> (usize, Vec<[u32; 3]>) {
        let body = sent.strip_prefix("\x1bP0;1q\"").unwrap();
        let body = body.strip_suffix("\x1b\\").unwrap();
        let (attributes, _) = body.split_once('#').unwrap();
        let size: Vec<usize> = attributes.split(';').map(|n| n.parse().unwrap()).collect();
        let (width, height) = (size[2], size[3]);
        let mut palette = BTreeMap::new();
        let mut seen = vec![None; width * height];
        let (mut x, mut y, mut color) = (0, 0, 0);
        let mut rest = &body[attributes.len()..];
        let number = |rest: &mut &str| {
            let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap();
            let value: usize = rest[..end].parse().unwrap();
            *rest = &rest[end..];
            value
        };
        while let Some(c) = rest.chars().next() {
            rest = &rest[1..];
            let count = if c == '!' { number(&mut rest) } else { 1 };
            match c {
                '#' => {
                    color = number(&mut rest);
                    if let Some(values) = rest.strip_prefix(";2;") {
                        rest = values;
                        let mut value = || {
                            let value = number(&mut rest) as u32;
                            rest = rest.strip_prefix(';').unwrap_or(rest);
                            value
                        };
                        palette.insert(color, [value(), value(), value()]);
                    }
                    continue;
                }
                '$' => x = 0,
                '-' => (x, y) = (0, y + 6),
                '!' | '?'..='~' => {
                    let sixel = if c == '!' {
                        let sixel = rest.as_bytes()[0];
                        rest = &rest[1..];
                        sixel
                    } else {
                        c as u8
                    };
                    for bit in (0..6).filter(|bit| (sixel - b'?') >> bit & 1 == 1) {
                        for x in x..x + count {
                            let pixel = &mut seen[(y + bit) * width + x];
                            assert!(pixel.is_none(), "one colour a pixel");
                            *pixel = Some(palette[&color]);
                        }
                    }
                    x += count;
                }
                other => panic!("{other:?} is no sixel"),
            }
        }
        (width, seen.into_iter().map(Option::unwrap).collect())
    }

    #[test]
    fn sixels_are_the_pixels_of_the_picture() {
        let mut picture = Picture::new((31.0, 20.0), Color::rgb(255, 0, 0));
        let shape = [(3.0, 2.0), (28.0, 5.0), (12.0, 18.0)];
        picture.polygon(&shape, Some(Color::rgb(0, 100, 255)), None::<Stroke>);
        let pixmap = pixels(&picture, 72.0).unwrap();
        let (width, seen) = decoded(&sixel(&picture, 72.0).unwrap());
        assert_eq!((width, seen.len()), (31, 31 * 20));
        for (pixel, seen) in rgb(&pixmap).chunks_exact(3).zip(seen) {
            let off = pixel.iter().zip(seen);
            let off = off.map(|(value, percent)| u32::from(*value).abs_diff(percent * 255 / 100));
            assert!(off.max() <= Some(2), "{pixel:?} {seen:?}");
        }
    }
}

//! Pictures as sixels, which some terminals show: six rows of pixels at a time, colour by colour.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::Picture;
use super::animation::Colors;
use super::raster::{RasterError, pixels, rgb};

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

//! Pictures one after the other as an animated GIF with 256 colours, a few of them in memory at a time.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

use gif::{Encoder, Frame, Repeat};
use rayon::prelude::*;
use tiny_skia::Pixmap;

use super::Picture;
use super::raster::{RasterError, pixels, rgb};

/// Why there is no animation.
#[derive(Debug, thiserror::Error)]
pub enum AnimationError {
    /// A frame cannot be painted.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// It could not be written.
    #[error("{}", nearmiss_base::system::error_text(.0))]
    Io(#[from] std::io::Error),
    /// The encoder refused.
    #[error("the GIF could not be written: {0}")]
    Encoding(String),
    /// A picture cannot be drawn.
    #[error("{0}")]
    Picture(String),
    /// There is no ffmpeg.
    #[error(
        "no ffmpeg on PATH; install it (https://ffmpeg.org), or write a .gif, which needs none"
    )]
    NoFfmpeg,
    /// ffmpeg failed.
    #[error("ffmpeg: {0}")]
    Ffmpeg(String),
    /// It was stopped.
    #[error("stopped")]
    Stopped,
}

impl From<gif::EncodingError> for AnimationError {
    fn from(error: gif::EncodingError) -> Self {
        match error {
            gif::EncodingError::Io(error) => Self::Io(error),
            other => Self::Encoding(other.to_string()),
        }
    }
}

/// Hundredths of a second that viewers show a frame at least; shorter ones are shown much longer.
const MIN_FRAME_TIME: f64 = 2.0;
/// Hundredths of a second that the last frame stays in addition.
const LAST_FRAME_PAUSE: u16 = 100;
/// Frames whose colours are looked at.
const SAMPLES: usize = 6;

/// Writes `count` pictures, each `dt` seconds after the one before, for ever anew; gives the number of frames. Where
/// steps are shorter than viewers can show, some are left out.
///
/// # Errors
/// See [`AnimationError`].
pub fn animate(
    out: impl Write,
    count: usize,
    dt: f64,
    dpi: f64,
    picture: impl Fn(usize) -> Result<Picture, String> + Sync,
    stop: &AtomicBool,
) -> Result<usize, AnimationError> {
    let stride = (MIN_FRAME_TIME / (dt * 100.0)).ceil().clamp(1.0, 1000.0) as usize;
    let shown: Vec<usize> = (0..count).step_by(stride).collect();
    let paint = |place: &usize| -> Result<Pixmap, AnimationError> {
        if stop.load(Ordering::Relaxed) {
            return Err(AnimationError::Stopped);
        }
        let picture = picture(*place).map_err(AnimationError::Picture)?;
        Ok(pixels(&picture, dpi)?)
    };
    let every = shown.len().div_ceil(SAMPLES).max(1);
    let samples: Vec<usize> = shown
        .iter()
        .copied()
        .step_by(every)
        .chain(shown.last().copied())
        .collect();
    let samples: Result<Vec<Vec<u8>>, _> = samples
        .par_iter()
        .map(|place| Ok::<_, AnimationError>(rgb(&paint(place)?)))
        .collect();
    let mut colors = Colors::from_frames(samples?.iter().map(Vec::as_slice));

    let mut writer: Option<Encoder<_>> = None;
    let mut out = Some(out);
    let mut before: Vec<u8> = Vec::new();
    let (mut written, mut time) = (0, 0.0);
    each_frame(&shown, paint, |pixmap| {
        let (width, height) = (pixmap.width() as usize, pixmap.height() as usize);
        let places: Vec<u8> = rgb(&pixmap)
            .chunks_exact(3)
            .map(|p| colors.place([p[0], p[1], p[2]]))
            .collect();
        if let Some(out) = out.take() {
            let size = |pixels: usize| u16::try_from(pixels).unwrap_or(u16::MAX);
            let mut encoder = Encoder::new(out, size(width), size(height), &colors.table())?;
            encoder.set_repeat(Repeat::Infinite)?;
            writer = Some(encoder);
        }
        let Some(encoder) = &mut writer else {
            return Ok(());
        };
        // Rounded from the beginning, so that mistakes do not add up.
        let end = time + dt * 100.0 * stride as f64;
        let last = written + 1 == shown.len();
        let mut frame = changed(&before, &places, width);
        frame.delay =
            (end.round() - f64::round(time)) as u16 + if last { LAST_FRAME_PAUSE } else { 0 };
        encoder.write_frame(&frame)?;
        time = end;
        written += 1;
        before = places;
        Ok(())
    })?;
    if let Some(encoder) = writer {
        encoder.into_inner()?.flush()?;
    }
    Ok(written)
}

/// Paints the pictures at these places, a few at a time, and hands them over in their order.
pub(super) fn each_frame<P: Send>(
    places: &[usize],
    paint: impl Fn(&usize) -> Result<P, AnimationError> + Sync,
    mut write: impl FnMut(P) -> Result<(), AnimationError>,
) -> Result<(), AnimationError> {
    for some in places.chunks(rayon::current_num_threads().max(1)) {
        let painted: Result<Vec<P>, _> = some.par_iter().map(&paint).collect();
        for picture in painted? {
            write(picture)?;
        }
    }
    Ok(())
}

/// The smallest box in which something is different; a single pixel where nothing is.
fn changed(before: &[u8], now: &[u8], width: usize) -> Frame<'static> {
    let height = now.len() / width.max(1);
    let row = |all: &[u8], y: usize| -> Vec<u8> { all[y * width..(y + 1) * width].to_vec() };
    let differs = |y: &usize| before.len() != now.len() || row(before, *y) != row(now, *y);
    let top = (0..height).find(differs).unwrap_or(0);
    let bottom = (top..height).rev().find(differs).unwrap_or(top);
    let column = |x: &usize| {
        (top..=bottom).any(|y| {
            before.get(y * width + x) != now.get(y * width + x) || before.len() != now.len()
        })
    };
    let left = (0..width).find(column).unwrap_or(0);
    let right = (left..width).rev().find(column).unwrap_or(left);
    let rows = (top..=bottom).flat_map(|y| &now[y * width + left..=y * width + right]);
    let size = |pixels: usize| u16::try_from(pixels).unwrap_or(u16::MAX);
    Frame {
        left: size(left),
        top: size(top),
        width: size(right - left + 1),
        height: size(bottom - top + 1),
        buffer: rows.copied().collect::<Vec<u8>>().into(),
        ..Frame::default()
    }
}

/// Colours of an animation, and the nearest of them for any other.
pub struct Colors {
    entries: Vec<[u8; 3]>,
    /// Those already looked up.
    known: BTreeMap<[u8; 3], u8>,
    /// The last one: most pixels are as the one before.
    last: Option<([u8; 3], u8)>,
}

/// Colours that a GIF holds.
const MAX_COLORS: usize = 256;

/// A box of colours: each with how often it occurs.
type Crate = Vec<([u8; 3], u64)>;

impl Colors {
    /// Colours for frames of these pixels, red, green and blue each.
    pub fn from_frames<'a>(frames: impl Iterator<Item = &'a [u8]>) -> Self {
        let mut counts: BTreeMap<[u8; 3], u64> = BTreeMap::new();
        for frame in frames {
            let pixels = frame.as_chunks::<3>().0;
            for same in pixels.chunk_by(|a, b| a == b) {
                *counts.entry(same[0]).or_default() += same.len() as u64;
            }
        }
        // A colour that fills the ground shall not push out those of the vehicles.
        let soft = counts.into_iter().map(|(c, n)| (c, n.isqrt() + 1));
        let mut crates: Vec<Crate> = vec![soft.collect()];
        while crates.len() < MAX_COLORS {
            let widest = (0..crates.len())
                .filter(|&i| crates[i].len() > 1)
                .max_by_key(|&i| weight(&crates[i]));
            let Some(widest) = widest else { break };
            let (low, high) = cut(crates.swap_remove(widest));
            crates.extend([low, high]);
        }
        let entries = crates.iter().filter(|c| !c.is_empty()).map(mean).collect();
        Self {
            entries,
            known: BTreeMap::new(),
            last: None,
        }
    }

    /// All of them, red, green and blue each.
    pub fn table(&self) -> Vec<u8> {
        self.entries.concat()
    }

    /// The place of the nearest colour.
    pub fn place(&mut self, color: [u8; 3]) -> u8 {
        match self.last {
            Some((last, place)) if last == color => place,
            _ => {
                let place = self.find(color);
                self.last = Some((color, place));
                place
            }
        }
    }

    fn find(&mut self, color: [u8; 3]) -> u8 {
        if let Some(place) = self.known.get(&color) {
            return *place;
        }
        let off = |entry: &[u8; 3]| -> u32 {
            let pairs = entry.iter().zip(&color);
            // Eyes see green best.
            pairs
                .zip([3, 4, 2])
                .map(|((a, b), w)| w * u32::from(a.abs_diff(*b)).pow(2))
                .sum()
        };
        let places = 0..self.entries.len();
        let nearest = places.min_by_key(|&i| off(&self.entries[i])).unwrap_or(0);
        let nearest = u8::try_from(nearest).unwrap_or(u8::MAX);
        self.known.insert(color, nearest);
        nearest
    }
}

/// The channel along which colours differ most, and by how much.
fn spread(colors: &Crate) -> (usize, u8) {
    let range = |channel: usize| {
        let values = || colors.iter().map(|(c, _)| c[channel]);
        values().max().unwrap_or(0) - values().min().unwrap_or(0)
    };
    (0..3)
        .map(|channel| (channel, range(channel)))
        .max_by_key(|(_, r)| *r)
        .unwrap_or((0, 0))
}

fn weight(colors: &Crate) -> u64 {
    let count: u64 = colors.iter().map(|(_, n)| n).sum();
    count * u64::from(spread(colors).1).pow(2)
}

/// In two, so that both are shown about as often.
fn cut(mut colors: Crate) -> (Crate, Crate) {
    let (channel, _) = spread(&colors);
    colors.sort_by_key(|(c, _)| (c[channel], *c));
    let all: u64 = colors.iter().map(|(_, n)| n).sum();
    let mut sum = 0;
    let half = colors.iter().position(|(_, n)| {
        sum += n;
        2 * sum >= all
    });
    let at = half.unwrap_or(0) + 1;
    let high = colors.split_off(at.min(colors.len() - 1).max(1));
    (colors, high)
}

fn mean(colors: &Crate) -> [u8; 3] {
    let count: u64 = colors.iter().map(|(_, n)| n).sum();
    let channel = |i: usize| {
        let sum: u64 = colors.iter().map(|(c, n)| u64::from(c[i]) * n).sum();
        u8::try_from((sum + count / 2) / count.max(1)).unwrap_or(u8::MAX)
    };
    [channel(0), channel(1), channel(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_changes_is_written() {
        let before = vec![0; 12];
        let mut now = before.clone();
        now[5] = 1;
        now[10] = 2;
        let frame = changed(&before, &now, 4);
        assert_eq!(
            (frame.left, frame.top, frame.width, frame.height),
            (1, 1, 2, 2)
        );
        assert_eq!(frame.buffer.as_ref(), [1, 0, 0, 2]);
        let same = changed(&now, &now, 4);
        assert_eq!((same.width, same.height), (1, 1));
        let first = changed(&[], &now, 4);
        assert_eq!((first.width, first.height), (4, 3));
    }

    #[test]
    fn few_colours_are_kept_exactly() {
        let frame: Vec<u8> = (0..200_u8).flat_map(|i| [i, 255 - i, 7]).collect();
        let mut colors = Colors::from_frames(std::iter::once(&frame[..]));
        let table = colors.table();
        for pixel in frame.chunks_exact(3) {
            let place = usize::from(colors.place([pixel[0], pixel[1], pixel[2]]));
            assert_eq!(&table[3 * place..3 * place + 3], pixel);
        }
    }

    #[test]
    fn many_colours_become_near_ones() {
        let all = (0..64_u8).flat_map(|r| (0..64_u8).map(move |g| [4 * r, 4 * g, 128]));
        let frame: Vec<u8> = all.flatten().collect();
        let mut colors = Colors::from_frames(std::iter::once(&frame[..]));
        let table = colors.table();
        assert_eq!(table.len(), 3 * MAX_COLORS);
        for pixel in frame.chunks_exact(3) {
            let place = usize::from(colors.place([pixel[0], pixel[1], pixel[2]]));
            let found = &table[3 * place..3 * place + 3];
            let off = pixel.iter().zip(found).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(off <= Some(24), "{pixel:?} {found:?}");
        }
    }
}

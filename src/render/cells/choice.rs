//! For each cell of the map the block character and the two colours that show its part of the picture with the least
//! squared error.
//!
//! A character parts the samples of its cell in two; of each part the best colour is the mean, or the nearest one that
//! the terminal has. Of every part only the sum is needed, which sums of rows and columns give.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;
use rayon::prelude::*;
use tiny_skia::Pixmap;

use super::Blocks;
use super::colors::Inks;

/// Samples of a cell: columns and rows.
pub const SAMPLES: (usize, usize) = (8, 16);
const ACROSS: usize = SAMPLES.0;
const DOWN: usize = SAMPLES.1;
const ALL: f32 = (ACROSS * DOWN) as f32;

/// A cell that is better by less than this with two colours, squared a sample, has one.
const NOTABLE: f32 = 1.0;

/// Red, green and blue of some samples, added up: 16 bits each, which those of a cell do not fill.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Sum(u64);

impl std::ops::AddAssign for Sum {
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl std::ops::Sub for Sum {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Sum {
    fn of(pixel: &[u8]) -> Self {
        Self(u64::from(pixel[0]) | u64::from(pixel[1]) << 16 | u64::from(pixel[2]) << 32)
    }

    fn parts(self) -> [f32; 3] {
        [0, 16, 32].map(|at| f32::from((self.0 >> at) as u16))
    }

    /// What their mean takes off the squares of so many samples.
    fn gain(self, count: f32) -> f32 {
        self.parts().iter().map(|v| v * v).sum::<f32>() / count
    }

    /// The nearest colour to their mean, and what it takes off the squares.
    fn shown(self, count: f32, inks: Inks) -> (Color, f32) {
        let parts = self.parts();
        let (color, shown) = inks.nearest(parts.map(|v| v / count));
        let both = parts.iter().zip(shown);
        let gain = both.map(|(sum, v)| v * (2.0 * sum - count * v)).sum();
        (color, gain)
    }
}

/// The samples of a cell by rows, in two halves, and by columns.
struct Cell {
    halves: [[Sum; 2]; DOWN],
    columns: [Sum; ACROSS],
    all: Sum,
}

impl Cell {
    /// `None` where all samples are equal, but for the first of them.
    fn new(rows: impl Iterator<Item = impl AsRef<[u8]>> + Clone) -> Result<Self, Sum> {
        let mut each = rows.clone();
        let first = each.next();
        let pixel = first.as_ref().map_or(&[0; 4][..], |row| &row.as_ref()[..4]);
        let is_same = |row: &[u8]| row.chunks_exact(4).all(|p| p == pixel);
        if rows.clone().all(|row| is_same(row.as_ref())) {
            return Err(Sum::of(pixel));
        }
        let mut cell = Self {
            halves: [[Sum::default(); 2]; DOWN],
            columns: [Sum::default(); ACROSS],
            all: Sum::default(),
        };
        for (halves, row) in cell.halves.iter_mut().zip(rows) {
            for (x, pixel) in row.as_ref().chunks_exact(4).enumerate() {
                let sum = Sum::of(pixel);
                halves[x * 2 / ACROSS] += sum;
                cell.columns[x] += sum;
            }
            cell.all += halves[0];
            cell.all += halves[1];
        }
        Ok(cell)
    }

    /// Hands over each way to part the cell: the character, and the sum and the number of the samples it covers.
    fn each(&self, blocks: Blocks, mut with: impl FnMut(char, Sum, f32)) {
        let mut below = Sum::default();
        for (i, halves) in self.halves.iter().rev().enumerate().take(DOWN - 1) {
            below += halves[0];
            below += halves[1];
            let eighths = (i + 1) * 8 / DOWN;
            if (i + 1) * 8 == eighths * DOWN {
                with(EIGHTHS_BELOW[eighths - 1], below, ((i + 1) * ACROSS) as f32);
            }
        }
        let mut left = Sum::default();
        for (i, column) in self.columns.iter().enumerate().take(ACROSS - 1) {
            left += *column;
            with(EIGHTHS_LEFT[i], left, ((i + 1) * DOWN) as f32);
        }
        self.parts(Blocks::Quadrants, &mut with);
        if blocks != Blocks::Quadrants {
            self.parts(blocks, &mut with);
        }
    }

    /// The same of the parts that these blocks have.
    fn parts(&self, blocks: Blocks, with: &mut impl FnMut(char, Sum, f32)) {
        let (_, bands) = blocks.per_cell();
        let mut parts = [(Sum::default(), 0.0); 8];
        for (y, halves) in self.halves.iter().enumerate() {
            // The band in which most of the row is.
            let band = (2 * y + 1) * bands / (2 * DOWN);
            for (side, half) in halves.iter().enumerate() {
                let (sum, count) = &mut parts[band * 2 + side];
                *sum += *half;
                *count += (ACROSS / 2) as f32;
            }
        }
        // The last part is never covered: the colours are exchanged instead.
        for set in 1_usize..1 << (2 * bands - 1) {
            let mut sum = Sum::default();
            let mut covered = 0.0;
            for (_, (part, count)) in parts.iter().enumerate().filter(|(i, _)| set >> i & 1 == 1) {
                sum += *part;
                covered += count;
            }
            with(blocks.symbol(set), sum, covered);
        }
    }

    /// The best character with its colours.
    fn choose(&self, blocks: Blocks, inks: Inks) -> Shown {
        let (color, one) = self.all.shown(ALL, inks);
        let mut best = (' ', color, color);
        let mut most = one + NOTABLE * ALL;
        self.each(blocks, |symbol, covered, count| {
            let (rest, others) = (self.all - covered, ALL - count);
            // No colours are better than the means.
            if covered.gain(count) + rest.gain(others) <= most {
                return;
            }
            let (front, gain) = covered.shown(count, inks);
            let (back, more) = rest.shown(others, inks);
            if gain + more > most && front != back {
                (best, most) = ((symbol, front, back), gain + more);
            }
        });
        best
    }
}

const EIGHTHS_BELOW: [char; 7] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇'];
const EIGHTHS_LEFT: [char; 7] = ['▏', '▎', '▍', '▌', '▋', '▊', '▉'];

/// Writes the cells that show a picture of [`SAMPLES`] a cell.
pub fn write(buffer: &mut Buffer, area: Rect, pixmap: &Pixmap, blocks: Blocks, inks: Inks) {
    let stride = pixmap.width() as usize * 4;
    let rows = pixmap.data().par_chunks(DOWN * stride);
    let chosen: Vec<Vec<Shown>> = rows
        .map(|row| choose_row(row, stride, blocks, inks))
        .collect();
    for (y, row) in (area.y..area.bottom()).zip(chosen) {
        for (x, (symbol, front, back)) in (area.x..area.right()).zip(row) {
            if let Some(cell) = buffer.cell_mut((x, y)) {
                cell.set_char(symbol).set_bg(back);
                if front != back {
                    cell.set_fg(front);
                }
            }
        }
    }
}

/// A part of a cell has the colour that so many of its samples have: a body that reaches a little into the next cells would
/// tint them, and have a halo.
const PLAIN: f32 = 0.85;

/// The samples of a cell that a character covers: of each row a bit a column, the leftmost lowest.
fn covered(symbol: char) -> [u8; DOWN] {
    let first = |columns: usize| ((1_u16 << columns) - 1) as u8;
    let row: &dyn Fn(usize) -> u8 = match symbol {
        '▁'..='▇' => &|y| {
            let below = (DOWN - y) * 8 <= (symbol as usize - 0x2580) * DOWN;
            if below { u8::MAX } else { 0 }
        },
        '▉'..='▏' => &|_| first((0x2590 - symbol as usize) * ACROSS / 8),
        _ => match Blocks::of_symbol(symbol) {
            None => &|_| 0,
            Some((blocks, parts)) => {
                let (_, bands) = blocks.per_cell();
                &move |y| {
                    let pair = parts >> (2 * ((2 * y + 1) * bands / (2 * DOWN)));
                    let left = first(ACROSS / 2);
                    [0, left, !left, u8::MAX][pair & 3]
                }
            }
        },
    };
    std::array::from_fn(row)
}

/// The same with the plain colours of its parts.
fn plainly<'a>(
    (symbol, front, back): Shown,
    lines: impl Iterator<Item = &'a [u8]> + Clone,
    inks: Inks,
) -> Shown {
    let rows = covered(symbol);
    // Each sample, and whether the character covers it.
    let samples = || {
        lines.clone().zip(rows).flat_map(|(line, row)| {
            let each = line.chunks_exact(4).enumerate();
            each.map(move |(x, p)| (usize::from(row >> x & 1), [p[0], p[1], p[2]]))
        })
    };
    // The only one of each part that more than half can have.
    let mut leading = [([0; 3], 0_u32); 2];
    for (part, sample) in samples() {
        let (most, votes) = &mut leading[part];
        if *votes == 0 {
            *most = sample;
        }
        *votes = if sample == *most {
            *votes + 1
        } else {
            *votes - 1
        };
    }
    let mut counts = [(0.0, 0.0); 2];
    for (part, sample) in samples() {
        let (all, alike) = &mut counts[part];
        *all += 1.0;
        *alike += f32::from(u8::from(sample == leading[part].0));
    }
    let color = |part: usize| {
        let (all, alike) = counts[part];
        (alike >= PLAIN * all).then(|| inks.nearest(leading[part].0.map(f32::from)).0)
    };
    let back = color(0).unwrap_or(back);
    match color(1).unwrap_or(front) {
        front if symbol != ' ' && front != back => (symbol, front, back),
        _ => (' ', back, back),
    }
}

/// A character, its colour, and that of the other part.
type Shown = (char, Color, Color);

/// The cells of a row.
fn choose_row(samples: &[u8], stride: usize, blocks: Blocks, inks: Inks) -> Vec<Shown> {
    let mut last = None;
    let cells = (0..stride).step_by(ACROSS * 4).map(|start| {
        let lines = samples.chunks_exact(stride);
        let lines = lines.map(|line| &line[start..start + ACROSS * 4]);
        match Cell::new(lines.clone()) {
            Ok(cell) => plainly(cell.choose(blocks, inks), lines, inks),
            Err(pixel) => {
                // Most cells are like the one before.
                let color = match last {
                    Some((known, color)) if known == pixel => color,
                    _ => inks.nearest(pixel.parts()).0,
                };
                last = Some((pixel, color));
                (' ', color, color)
            }
        }
    });
    cells.collect()
}

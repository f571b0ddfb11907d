//! Filled polygons for ratatui's canvas, which only draws outlines.

use ratatui::style::Color;
use ratatui::widgets::canvas::{Painter, Shape};

/// A filled polygon in the canvas's coordinates.
#[derive(Debug, Clone)]
pub struct Fill<'a> {
    /// The corners in order, not closed.
    pub ring: &'a [(f64, f64)],
    /// The dots' colour.
    pub color: Color,
    /// Of so many dots in both directions one is set; 1 for all of them.
    pub every: usize,
}

impl<'a> Fill<'a> {
    /// All dots inside.
    pub fn solid(ring: &'a [(f64, f64)], color: Color) -> Self {
        Self {
            ring,
            color,
            every: 1,
        }
    }

    /// One dot of sixteen inside, so that what lies under it stays readable.
    pub fn dotted(ring: &'a [(f64, f64)], color: Color) -> Self {
        Self {
            ring,
            color,
            every: 4,
        }
    }
}

impl Shape for Fill<'_> {
    fn draw(&self, painter: &mut Painter<'_, '_>) {
        let ([left, right], [bottom, top]) = {
            let (x, y) = painter.bounds();
            (*x, *y)
        };
        // How many dots there are is asked of the painter at the far corner.
        let Some((columns, rows)) = painter.get_point(right, bottom) else {
            return;
        };
        let (dx, dy) = (
            (right - left) / columns.max(1) as f64,
            (top - bottom) / rows.max(1) as f64,
        );
        if self.ring.len() < 3 {
            return;
        }
        let span = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::MAX, f64::MIN), |(low, high), v| {
                (low.min(v), high.max(v))
            })
        };
        let (low, high) = span(&mut self.ring.iter().map(|p| p.1));
        let row_of = |y: f64| ((top - y) / dy).clamp(0.0, rows as f64);
        let mut crossings: Vec<f64> = Vec::new();
        for row in row_of(high).floor() as usize..=row_of(low).ceil() as usize {
            if !row.is_multiple_of(self.every) {
                continue;
            }
            // Every other row is shifted, so that the dots stand like bricks.
            let shift = row / self.every % 2 * (self.every / 2);
            let y = top - row as f64 * dy;
            crossings.clear();
            for (i, &(x1, y1)) in self.ring.iter().enumerate() {
                let (x2, y2) = self.ring[(i + 1) % self.ring.len()];
                if (y1 > y) != (y2 > y) {
                    crossings.push(x1 + (y - y1) / (y2 - y1) * (x2 - x1));
                }
            }
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let column_of = |x: f64| ((x - left) / dx).clamp(0.0, columns as f64);
                let (from, to) = (
                    column_of(pair[0]).ceil() as usize,
                    column_of(pair[1]).floor() as usize,
                );
                if pair[1] < left || pair[0] > right {
                    continue;
                }
                for column in from..=to {
                    if (column + shift).is_multiple_of(self.every) {
                        painter.paint(column, row, self.color);
                    }
                }
            }
        }
    }
}

//! How the area of the map is divided between two maps.

use ratatui::layout::Rect;

/// The fewest columns and rows in which a map is of use.
const LEAST: (u16, u16) = (24, 6);

/// Two maps with a line between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Halves {
    /// The map of the clock's moment: on the left, or above.
    pub first: Rect,
    /// The line: a column, or a row.
    pub line: Rect,
    /// The map of the second moment.
    pub second: Rect,
}

impl Halves {
    /// Divides an area so that both maps are as little elongated as possible; `aspect` is how much higher than wide a
    /// cell is. `None` where there is no room for two.
    #[must_use]
    pub fn of(area: Rect, aspect: f64) -> Option<Self> {
        let wide = f64::from(area.width) >= f64::from(area.height) * aspect;
        let (beside, above) = (Self::beside(area), Self::above(area));
        let order = if wide {
            [beside, above]
        } else {
            [above, beside]
        };
        let mut both = order.into_iter();
        both.find(|halves| halves.second.width >= LEAST.0 && halves.second.height >= LEAST.1)
    }

    fn beside(area: Rect) -> Self {
        let rest = area.width.saturating_sub(1);
        let part = |x, width| Rect { x, width, ..area };
        let first = part(area.x, rest - rest / 2);
        Self {
            first,
            line: part(first.right(), 1),
            second: part(first.right() + 1, rest / 2),
        }
    }

    fn above(area: Rect) -> Self {
        let rest = area.height.saturating_sub(1);
        let part = |y, height| Rect { y, height, ..area };
        let first = part(area.y, rest - rest / 2);
        Self {
            first,
            line: part(first.bottom(), 1),
            second: part(first.bottom() + 1, rest / 2),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn maps_stand_beside_or_above_each_other_and_fill_the_area() {
        for (width, height, beside) in [(72, 28, true), (41, 15, false), (40, 30, false)] {
            let area = Rect::new(3, 2, width, height);
            let halves = Halves::of(area, 2.0).unwrap();
            assert_eq!(halves.first.y == halves.second.y, beside, "{area}");
            let parts = [halves.first, halves.line, halves.second];
            let cells: u32 = parts.iter().map(|part| part.area()).sum();
            assert_eq!(cells, area.area());
            assert!(parts.iter().all(|part| area.union(*part) == area));
            assert!(!halves.first.intersects(halves.second));
            assert_eq!(halves.line.width.min(halves.line.height), 1);
        }
        for (width, height) in [(0, 0), (1, 1), (41, 12), (30, 11), (200, 5)] {
            assert_eq!(Halves::of(Rect::new(0, 0, width, height), 2.0), None);
        }
    }
}

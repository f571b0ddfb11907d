//! Lines of a plot, dot by dot: dashes, so that lines are told apart without colours.

use ratatui::style::Color;
use ratatui::widgets::canvas::{Context, Points};

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// Without gaps.
    Solid,
    /// Dashes.
    Dashed,
    /// Dots.
    Dotted,
    /// Dashes and dots.
    Alternating,
    /// Long dashes.
    Long,
}

impl Dash {
    /// Those of marked obstacles, one after the other.
    pub const MARKED: [Self; 3] = [Self::Dotted, Self::Alternating, Self::Long];

    /// Its sign in a legend: the dots of a level line, as it is drawn.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Solid => "⠒⠒",
            Self::Dashed => "⠒⠒⠀⠀⠒⠒",
            Self::Dotted => "⠂⠀⠂",
            Self::Alternating => "⠒⠒⠂⠐⠀",
            Self::Long => "⠒⠒⠒⠒⠂⠀⠐",
        }
    }

    /// Whether the dot at this place along the line is drawn.
    fn shows(self, place: usize) -> bool {
        match self {
            Self::Solid => true,
            Self::Dashed => place % 8 < 4,
            Self::Dotted => place.is_multiple_of(4),
            Self::Alternating => matches!(place % 10, 0..=4 | 7),
            Self::Long => place % 13 < 9,
        }
    }
}

/// Draws a line through points, in dots of the canvas; a lonely point is a dot.
pub fn stroke(ctx: &mut Context<'_>, points: &[(f64, f64)], dash: Dash, color: Color) {
    let all = dots(points);
    let shown = all.iter().enumerate().filter(|(i, _)| dash.shows(*i));
    let coords: Vec<(f64, f64)> = shown
        .map(|(_, (x, y))| (f64::from(*x), f64::from(*y)))
        .collect();
    ctx.draw(&Points {
        coords: &coords,
        color,
    });
}

/// Every dot on the way from point to point, each once.
fn dots(points: &[(f64, f64)]) -> Vec<(i32, i32)> {
    // Dots of a canvas are few; what is not a number becomes zero.
    let rounded = |(x, y): &(f64, f64)| (x.round() as i32, y.round() as i32);
    let mut all: Vec<(i32, i32)> = points.first().map(rounded).into_iter().collect();
    for pair in points.windows(2) {
        let (from, to) = (rounded(&pair[0]), rounded(&pair[1]));
        let (dx, dy) = (
            f64::from(to.0) - f64::from(from.0),
            f64::from(to.1) - f64::from(from.1),
        );
        let count = dx.abs().max(dy.abs());
        for i in 1..=count as u32 {
            let part = f64::from(i) / count;
            let at = |start: i32, by: f64| (f64::from(start) + part * by).round() as i32;
            all.push((at(from.0, dx), at(from.1, dy)));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_have_no_gaps_and_dashes_do() {
        let all = dots(&[(0.0, 0.0), (9.0, 3.0), (9.0, 12.0)]);
        assert_eq!(all.len(), 1 + 9 + 9);
        let near = |pair: &[(i32, i32)]| {
            (pair[0].0 - pair[1].0).abs() <= 1 && (pair[0].1 - pair[1].1).abs() <= 1
        };
        assert!(all.windows(2).all(near), "{all:?}");
        for dash in Dash::MARKED.into_iter().chain([Dash::Dashed]) {
            let shown = (0..60).filter(|place| dash.shows(*place)).count();
            assert!((10..50).contains(&shown), "{dash:?}");
        }
    }
}

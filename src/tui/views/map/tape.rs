//! The measuring tape: a line with its length, exact between bodies.

use ratatui::style::{Modifier, Style};
use ratatui::widgets::canvas::Context;

use super::board::{Board, Body};
use super::{Projection, stroke};
use crate::tui::model::{Measurement, Model, On, Tape};
use crate::tui::widgets::words::hundredths;

pub fn line(ctx: &mut Context<'_>, model: &Model, view: &Projection) {
    if let Some((_, measured)) = model.measured() {
        let (from, to) = measured.gap.ends;
        stroke(ctx, view, &[from, to], model.theme.accent);
    }
}

pub fn ends(board: &mut Board<'_>, model: &Model, view: &Projection) {
    let Some((tape, measured)) = model.measured() else {
        return;
    };
    let style = Style::new()
        .fg(model.theme.accent)
        .add_modifier(Modifier::BOLD);
    let (from, to) = measured.gap.ends;
    board.put(view.at(&from), "+", style);
    // The end that keys move.
    board.put(view.at(&to), "#", style);
    let middle = view.at(&nalgebra::center(&from, &to));
    let words = words(&tape, &measured);
    let body = Body::around([middle]).map(|body| board.cells(&body));
    let placed = body.is_some_and(|cells| board.beside(&cells, &words, style));
    if !placed {
        // Where the middle is out of sight, the pointer's end may be in it.
        if let Some(end) = Body::around([view.at(&to)]) {
            let cells = board.cells(&end);
            board.beside(&cells, &words, style);
        }
    }
}

/// The length, what it was taken between, and the time that the ego needs for it.
pub fn words(tape: &Tape, measured: &Measurement) -> String {
    let mut words = format!("{} m", hundredths(measured.gap.metres));
    if let (Some(seconds), Some(speed)) = (measured.seconds, measured.speed) {
        words += &format!(" · {seconds:.1} s at {speed:.1} m/s");
    }
    if measured.bodies > 0 {
        let name = |on: Option<On>| match on {
            Some(On::Ego) => "ego".to_string(),
            Some(On::Obstacle(id)) => id.to_string(),
            None => "point".to_string(),
        };
        words += &format!(" · {} to {}", name(tape.from.on), name(tape.to.on));
    }
    words
}

//! The measuring tape: a line with its length, exact between bodies.

use ratatui::style::{Modifier, Style};

use super::CellView;
use super::label_placer::{Body, LabelPlacer};
use crate::model::{Measurement, Model, Moment, On, Tape};
use crate::widgets::words::hundredths;
use nearmiss_render::scene::{LineStyle, Overlay, Role};

/// The line between the two ends.
pub fn line(model: &Model, moment: &Moment<'_>) -> Option<Overlay> {
    let measured = moment.measured(model.map.tape.as_ref()?);
    let (from, to) = measured.gap.ends;
    Some(Overlay::path(Role::Tape, LineStyle::Solid, vec![from, to]))
}

/// The two ends, where they are.
pub fn ends(board: &mut LabelPlacer<'_>, model: &Model, moment: &Moment<'_>, view: &CellView) {
    let Some(tape) = &model.map.tape else {
        return;
    };
    let (from, to) = moment.measured(tape).gap.ends;
    board.put(view.at(&from), "+", style(model));
    // The end that keys move.
    board.put(view.at(&to), "#", style(model));
}

fn style(model: &Model) -> Style {
    Style::new()
        .fg(model.theme.accent)
        .add_modifier(Modifier::BOLD)
}

/// The measurement, as much as fits beside its middle, or beside its end.
pub fn label(board: &mut LabelPlacer<'_>, model: &Model, moment: &Moment<'_>, view: &CellView) {
    let Some(tape) = &model.map.tape else {
        return;
    };
    let measured = moment.measured(tape);
    let (from, to) = measured.gap.ends;
    let places = [view.at(&nalgebra::center(&from, &to)), view.at(&to)];
    let all = words(tape, &measured);
    for count in (1..=all.len()).rev() {
        let words = all[..count].join(" · ");
        for place in places {
            if let Some(body) = Body::around([place]) {
                let cells = board.cells(&body);
                if board.beside(&cells, &words, style(model)) {
                    return;
                }
            }
        }
    }
}

/// The length, what it was taken between, and the time that the ego needs for it; the most telling first.
fn words(tape: &Tape, measured: &Measurement) -> Vec<String> {
    let mut words = vec![format!("{} m", hundredths(measured.gap.metres))];
    if let (Some(seconds), Some(speed)) = (measured.seconds, measured.speed) {
        words.push(format!("{seconds:.1} s at {speed:.1} m/s"));
    }
    if measured.bodies > 0 {
        let name = |on: Option<On>| match on {
            Some(On::Ego) => "ego".to_string(),
            Some(On::Obstacle(id)) => id.to_string(),
            None => "point".to_string(),
        };
        words.push(format!("{} to {}", name(tape.from.on), name(tape.to.on)));
    }
    words
}

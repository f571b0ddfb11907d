//! The list of versions of a prompt, to choose one for a side.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::super::Step;
use super::draw::LETTERS;
use crate::action::Action;
use crate::model::Model;
use crate::widgets::window;
use crate::widgets::words::{fit, pad};
use nearmiss_scene::description::visible;

/// Columns of a version's name.
const NAME: usize = 34;

/// Opens the list for a side.
pub fn open(model: &mut Model, side: usize) {
    let all = model.prompt_versions();
    if all.len() < 2 {
        model.say("only one version of this prompt is known");
        return;
    }
    let now = model.versions.sides.as_ref().map(|sides| &sides[side].hash);
    let place = all.iter().position(|one| Some(&one.hash) == now);
    model.versions.choosing = Some((side, place.unwrap_or(0)));
}

/// Takes the selected version.
pub fn chosen(model: &mut Model) -> Step {
    let all = model.prompt_versions();
    let Some((side, place)) = model.versions.choosing.take() else {
        return Step::stay();
    };
    let (Some(version), Some(sides)) = (all.get(place), &mut model.versions.sides) else {
        return Step::stay();
    };
    if sides[side] == *version {
        return Step::stay();
    }
    if sides[1 - side].hash == version.hash {
        // Both sides cannot have the same: they change places.
        sides.swap(0, 1);
    } else {
        sides[side] = version.clone();
    }
    Step::Perform(Action::ChangeVersion)
}

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model, (side, selected): (usize, usize)) {
    let all = model.prompt_versions();
    let title = format!("version {}", LETTERS[side]);
    let height = u16::try_from(all.len() + 2).unwrap_or(u16::MAX);
    let inner = window::window(frame, screen, model, &title, (84, height));
    let rows = usize::from(inner.height);
    let width = usize::from(inner.width);
    let top = (selected + 1).saturating_sub(rows);
    let dim = Style::new().fg(model.theme.dim);
    let lines = all.iter().enumerate().skip(top).take(rows);
    let lines = lines.map(|(place, version)| {
        let chosen = place == selected;
        let origin = fit(&visible(&version.origin()), width.saturating_sub(NAME + 3));
        let line = Line::from(vec![
            Span::raw(if chosen { "▸ " } else { "  " }),
            Span::raw(pad(&visible(&version.name()), NAME)),
            Span::styled(format!(" {origin}"), dim),
        ]);
        match chosen {
            true => model.theme.select(line),
            false => line.style(model.theme.base()),
        }
    });
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), inner);
}

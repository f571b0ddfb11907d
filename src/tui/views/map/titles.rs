//! Titles of the maps: how much is seen, and of two maps which moment each shows.

use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use unicode_width::UnicodeWidthStr;

use crate::model::{Model, Moment};

/// Of the only map, or of the first of two: `half` is its area.
pub fn first(model: &Model, half: Option<Rect>, inner: Rect) -> Line<'static> {
    let camera = &model.camera;
    let width = half.map_or(inner.width, |half| half.width);
    let size = half.map_or((inner.width, inner.height), |half| {
        (half.width, half.height.saturating_sub(1))
    });
    let cell = model
        .moment()
        .map_or(camera.cell, |now| model.camera_of(size, &now).cell);
    let across = format!("{:.0} m", cell * f64::from(width));
    let mode = match (camera.follow, camera.ego_up) {
        (true, true) => Some("follows ego, ego up"),
        (true, false) => Some("follows ego"),
        (false, true) => Some("ego up"),
        (false, false) => None,
    };
    let dim = Style::new().fg(model.theme.dim);
    let Some((half, now)) = half.zip(model.moment()) else {
        let mut title = Line::from(format!("map · {across}"));
        let mode = mode.map_or(String::new(), |mode| format!(" · {mode}"));
        title.push_span(Span::styled(mode, dim));
        return title;
    };
    let mut title = second(&now, half);
    for words in [Some(across.as_str()), mode].into_iter().flatten() {
        let words = format!(" · {words}");
        if title.width() + words.width() <= room(half) {
            title.push_span(Span::styled(words, dim));
        }
    }
    title
}

/// Of the second map: its moment, in as many words as there is room for.
pub fn second(moment: &Moment<'_>, half: Rect) -> Line<'static> {
    let driven = |brief| Some(moment.driven_words(moment.driven?, brief));
    let mut words = [Some(moment.words()), driven(false), driven(true)]
        .into_iter()
        .flatten();
    let fits = words.find(|words| words.width() <= room(half));
    Line::from(fits.unwrap_or_else(|| moment.when()))
}

/// A title has a blank on both sides.
fn room(half: Rect) -> usize {
    usize::from(half.width).saturating_sub(2)
}

//! A variant in three maps at the moment that matters in it: the original, the attack, and the good driver who survives
//! it, above the gaps to the attacker over time.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear};
use unicode_width::UnicodeWidthStr;

use crate::features::map::draw::still;
use crate::features::map::state::DrivenBy;
use crate::features::plot::draw::axes::Dash;
use crate::features::plot::draw::marks::{GapCurve, gaps};
use crate::model::{Model, Moment};
use crate::widgets::words::fit;

/// Fewest columns and rows of the strip.
const LEAST: (u16, u16) = (56, 24);
/// Rows of the gaps.
const GAPS: u16 = 9;

/// Whether there is room, and something to show.
pub fn fits(model: &Model, area: Rect) -> bool {
    area.width >= LEAST.0 && area.height >= LEAST.1 && model.strip().is_some()
}

/// Draws it.
pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let Some(strip) = model.strip() else { return };
    let theme = &model.theme;
    f.render_widget(Clear, area);
    f.render_widget(Block::new().style(theme.base()), area);
    let [maps, below] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(GAPS)]).areas(area);
    let drives: Vec<(&str, Color, Dash, Moment<'_>)> = [
        Some(("original", theme.text, Dash::Dotted, strip.original)),
        Some(("attack", theme.danger, Dash::Solid, strip.attack)),
        strip
            .survived
            .map(|drive| ("good driver", theme.safe, Dash::Dashed, drive)),
    ]
    .into_iter()
    .flatten()
    .collect();
    let parts = Layout::vertical(vec![Constraint::Fill(1); drives.len()]).split(maps);
    for ((name, color, _, moment), part) in drives.iter().zip(parts.iter()) {
        let title = title(
            model,
            name,
            *color,
            moment,
            usize::from(part.width).saturating_sub(4),
        );
        let block = Block::bordered()
            .border_style(Style::new().fg(theme.border))
            .title(title);
        let inner = block.inner(*part);
        f.render_widget(block, *part);
        still(f, inner, model, moment, &strip.attack);
    }
    let step = strip.attack.step;
    let block = Block::bordered()
        .border_style(Style::new().fg(theme.border))
        .title(Span::styled(
            format!(" gap to {}, m ", strip.attacker),
            Style::new().fg(theme.title),
        ));
    let inner = block.inner(below);
    f.render_widget(block, below);
    let curves: Vec<GapCurve<'_>> = drives
        .iter()
        .map(|(name, color, dash, moment)| GapCurve {
            name,
            color: *color,
            dash: *dash,
            opened: moment.opened,
        })
        .collect();
    gaps(f, inner, model, &curves, (strip.attacker, step));
}

/// Whose drive it is, how it ends, and the gap at the moment.
fn title(
    model: &Model,
    name: &str,
    color: Color,
    moment: &Moment<'_>,
    room: usize,
) -> Line<'static> {
    let verdict = moment
        .opened
        .collision
        .as_ref()
        .map(|j| j.verdict.dangerous);
    let (words, ending) = match verdict {
        Some(true) => (" · X collision", model.theme.danger),
        Some(false) => (" · no contact", model.theme.safe),
        None => ("", model.theme.dim),
    };
    let name = match moment.driven {
        Some(DrivenBy::GoodDriver(delay)) => format!("{name}, reaction {delay:.1} s"),
        Some(DrivenBy::Planner) => name.to_string(),
        None if moment.opened.planned.is_some() => format!("{name}, planned ego"),
        None => format!("{name}, recorded ego"),
    };
    let series = moment.opened.series.as_ref();
    let nearest = series.and_then(|series| series.most_dangerous_at("distance", moment.step));
    let gap = nearest.map_or(String::new(), |(id, gap)| format!(" · {gap:.1} m to {id}"));
    let when = format!(" · {}", moment.when());
    let bold = Style::new().fg(color).add_modifier(Modifier::BOLD);
    let mut line = Line::from(Span::styled(format!(" {}", fit(&name, room)), bold));
    let rest = [
        (words.to_string(), ending),
        (gap, model.theme.text),
        (when, model.theme.dim),
    ];
    for (words, color) in rest {
        if line.width() + words.width() < room {
            line.push_span(Span::styled(words, Style::new().fg(color)));
        }
    }
    line.push_span(Span::raw(" "));
    line
}

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
use crate::features::plot::draw::fitting;
use crate::features::plot::draw::gaps::{self, GapCurve};
use crate::features::plot::draw::marks::Event;
use crate::model::{Model, Moment};
use crate::widgets::words::fit;

/// Fewest columns and rows of the strip.
const LEAST: (u16, u16) = (56, 24);
/// Rows of the gaps at least, and their share of all in percent.
const GAPS: (u16, u16) = (9, 30);

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
    let gaps_rows = (area.height * GAPS.1 / 100).max(GAPS.0);
    let [maps, below] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(gaps_rows)]).areas(area);
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
    let mut title = vec![vec![Span::raw(format!("gap to {}", strip.attacker))]];
    title.extend(drives.iter().map(|(name, color, dash, _)| {
        let words = format!("{} {name}", dash.sign());
        vec![Span::styled(words, Style::new().fg(*color))]
    }));
    let mut title = fitting(title, usize::from(below.width).saturating_sub(4));
    title.spans.insert(0, " ".into());
    title.push_span(" ");
    let block = Block::bordered()
        .border_style(Style::new().fg(theme.border))
        .title(title.style(Style::new().fg(theme.title)));
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
    let time = strip.attack.step as f64 * strip.attack.opened.scenario.dt();
    let (sign, word) = match strip.attack.opened.contact() {
        Some(contact) => ('X', contact.name()),
        None => ('▼', "most severe"),
    };
    let moment = Event {
        time,
        sign,
        label: format!("{word} {time:.1} s"),
        style: Style::new().fg(theme.danger).add_modifier(Modifier::BOLD),
    };
    gaps::draw(f, inner, model, &curves, strip.attacker, moment);
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

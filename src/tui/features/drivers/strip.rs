//! An encounter in maps, one below the other: of a variant the original, the ego, and the driver that is shown, above the
//! gaps to the other over time.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Borders, Clear};
use unicode_width::UnicodeWidthStr;

use crate::features::map::draw::still;
use crate::features::map::state::DrivenBy;
use crate::features::plot::draw::axes::Dash;
use crate::features::plot::draw::fitting;
use crate::features::plot::draw::gaps::{self, GapCurve};
use crate::features::plot::draw::marks::Event;
use crate::model::{Model, Moment, Strip};
use crate::widgets::row;
use crate::widgets::words::fit;

/// Fewest columns and rows of the strip.
const LEAST: (u16, u16) = (48, 24);
/// Rows of the gaps at least, and their share of all in percent.
const GAPS: (u16, u16) = (9, 30);

/// Whether there is room.
pub fn fits(area: Rect) -> bool {
    area.width >= LEAST.0 && area.height >= LEAST.1
}

/// The smallest screen with a strip, `92×26`.
pub fn least_screen() -> String {
    let left = |columns: u16| columns - row::width(Rect::new(0, 0, columns, 1));
    let columns = (LEAST.0..).find(|columns| left(*columns) >= LEAST.0);
    format!("{}×{}", columns.unwrap_or(u16::MAX), LEAST.1 + 2)
}

/// Rows that the gaps leave for text below them at least.
const TEXT: u16 = 12;

/// Draws the gaps alone in the upper part of an area, where they have room; gives what is left.
pub fn draw_gaps_above(f: &mut Frame<'_>, area: Rect, model: &Model, strip: &Strip<'_>) -> Rect {
    if area.height < GAPS.0 + TEXT {
        return area;
    }
    let [above, below] =
        Layout::vertical([Constraint::Length(GAPS.0), Constraint::Min(0)]).areas(area);
    f.render_widget(Clear, above);
    f.render_widget(Block::new().style(model.theme.base()), above);
    draw_gaps(f, above, model, strip, &drives(model, strip));
    below
}

/// A drive with its name and how its line looks.
type Drive<'a> = (&'static str, Color, Dash, Moment<'a>);

fn drives<'a>(model: &Model, strip: &Strip<'a>) -> Vec<Drive<'a>> {
    let theme = &model.theme;
    let mut drives = Vec::new();
    let original = strip.original;
    drives.extend(original.map(|drive| ("original", theme.text, Dash::Dotted, drive)));
    drives.push((strip.ego.whose(), theme.danger, Dash::Solid, strip.ego));
    drives.extend(strip.driver.and_then(|drive| {
        let (_, name) = drive.driven?.driver()?;
        Some((name, theme.ego, Dash::Dashed, drive))
    }));
    drives
}

/// Draws it.
pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model, strip: &Strip<'_>) {
    let theme = &model.theme;
    f.render_widget(Clear, area);
    f.render_widget(Block::new().style(theme.base()), area);
    let gaps_rows = (area.height * GAPS.1 / 100).max(GAPS.0);
    let drives = drives(model, strip);
    // Maps of one size show the same part of the road.
    let count = drives.len() as u16;
    let each = area.height.saturating_sub(gaps_rows) / count;
    let [maps, below] =
        Layout::vertical([Constraint::Length(each * count), Constraint::Min(0)]).areas(area);
    let parts = Layout::vertical(vec![Constraint::Length(each); drives.len()]).split(maps);
    for ((name, color, _, moment), part) in drives.iter().zip(parts.iter()) {
        let title = title(
            model,
            name,
            *color,
            moment,
            usize::from(part.width).saturating_sub(4),
        );
        // The next title is the border below.
        let block = Block::bordered()
            .borders(Borders::ALL - Borders::BOTTOM)
            .border_style(Style::new().fg(theme.border))
            .title(title);
        let inner = block.inner(*part);
        f.render_widget(block, *part);
        still(f, inner, model, moment, strip);
    }
    draw_gaps(f, below, model, strip, &drives);
}

/// The gaps of the drives to the other over time.
fn draw_gaps(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    strip: &Strip<'_>,
    drives: &[Drive<'_>],
) {
    let theme = &model.theme;
    let ego = &strip.ego;
    let time = ego.step as f64 * ego.opened.scenario.dt();
    let contact = ego.opened.contact();
    let (sign, word) = match contact.filter(|contact| contact.step == ego.step) {
        Some(contact) => ('X', contact.name()),
        None => ('▼', "most severe"),
    };
    let moment = Event {
        time,
        sign,
        label: format!("{word} {time:.1} s"),
        style: Style::new().fg(theme.danger).add_modifier(Modifier::BOLD),
    };
    let mut gap = vec![vec![Span::raw(format!("gap to {}", strip.other))]];
    if gaps::is_low(Block::bordered().inner(area)) {
        let words = format!("{sign} {}", moment.label);
        gap.push(vec![Span::styled(words, moment.style)]);
    }
    let named = |signs: bool| {
        let mut parts = gap.clone();
        parts.extend(drives.iter().map(|(name, color, dash, _)| {
            let sign = if signs { dash.sign() } else { "" };
            let words = format!("{sign} {name}");
            vec![Span::styled(
                words.trim_start().to_string(),
                Style::new().fg(*color),
            )]
        }));
        parts
    };
    // All are named or none: where there is little room, their names stand at the ends of their lines alone.
    let room = usize::from(area.width).saturating_sub(4);
    let titles = [true, false].map(|signs| fitting(named(signs), usize::MAX));
    let title = titles.into_iter().find(|title| title.width() <= room);
    let mut title = title.unwrap_or_else(|| fitting(gap, room));
    title.spans.insert(0, " ".into());
    title.push_span(" ");
    let block = Block::bordered()
        .border_style(Style::new().fg(theme.border))
        .title(title.style(Style::new().fg(theme.title)));
    let inner = block.inner(area);
    f.render_widget(block, area);
    let curves: Vec<GapCurve<'_>> = drives
        .iter()
        .map(|(name, color, dash, moment)| GapCurve {
            name,
            color: *color,
            dash: *dash,
            opened: moment.opened,
        })
        .collect();
    gaps::draw(f, inner, model, &curves, strip.other, moment);
}

/// Whose drive it is, how it ends, and the gap at the moment.
fn title(
    model: &Model,
    name: &str,
    color: Color,
    moment: &Moment<'_>,
    room: usize,
) -> Line<'static> {
    let words = format!(" · {}", moment.ending());
    let ending = if words.contains('X') {
        model.theme.danger
    } else {
        model.theme.text
    };
    let series = moment.opened.series.as_ref();
    let nearest = series.and_then(|series| series.most_dangerous_at("distance", moment.step));
    let gap = nearest.map_or(String::new(), |(id, gap)| format!(" · {gap:.1} m to {id}"));
    let more = match moment.driven {
        Some(DrivenBy::Certificate(delay)) => format!(", reaction {delay:.1} s"),
        Some(DrivenBy::Ego) if moment.whose() != "attack" => " ego".into(),
        Some(DrivenBy::Ego | DrivenBy::Driver(..)) => String::new(),
        None if moment.opened.planned.is_some() => ", planned ego".into(),
        None => ", recorded ego".into(),
    };
    let whole = moment.driven.and_then(DrivenBy::driver);
    let mut name = whole.map_or(name, |(whole, _)| whole).to_string();
    // The gap says more.
    if name.width() + more.width() + words.width() + gap.width() + 1 < room {
        name.push_str(&more);
    }
    let when = format!(" · {}", moment.when());
    let bold = Style::new().fg(color).add_modifier(Modifier::BOLD);
    let mut line = Line::from(Span::styled(format!(" {}", fit(&name, room)), bold));
    let rest = [
        (words, ending),
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

//! Draws the coverage map: the table, and below it the selected cell with its worst windows.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use crate::action::Action;
use crate::features::coverage::{ALL, CellChoice, CellDetail, CoverageScreen, WorstWindow};
use crate::model::{ListIndex, Model};
use crate::widgets::window;
use crate::widgets::words::{fit, fit_middle, pad, thousands};
use nearmiss_base::system::{pad_start, shown_path};
use nearmiss_scene::corpus::{CellCounts, CorpusIndex, Manoeuvre, RoadType, SEVERITIES, WindowEgo};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::SEVERITY_NAMES;

/// Columns of a manoeuvre's name with the sign before it.
const NAME: usize = 16;
/// Columns of a cell at most, and those from which it has bars by severity.
const WIDEST: usize = 20;
const WITH_BARS: usize = 14;
/// Lines of the table: its head, the manoeuvres and their sum.
const TABLE: u16 = 13;
/// Signs of the number of windows, few to many.
const SHADES: [char; 4] = ['░', '▒', '▓', '█'];
/// Bars of the windows of a severity, few to many.
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
/// Said of a cell without windows.
const EMPTY: &str = "·";

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model, state: &CoverageScreen) {
    let body = window::full_screen(frame, screen, model);
    let room = usize::from(body.width).saturating_sub(4);
    let inner = window::window_at(frame, body, model, &title(model, state, room));
    let (Some(index), Some(detail)) = (model.list.index().ready(), &state.detail) else {
        let words = Paragraph::new(visible(&without(model)).into_owned()).wrap(Wrap { trim: true });
        frame.render_widget(words.style(Style::new().fg(model.theme.dim)), inner);
        return;
    };
    // In a low terminal the windows take the place of the table while they have the keys.
    let both = inner.height >= TABLE + 5;
    let table = match (both, state.inside) {
        (false, Some(_)) => 0,
        _ => TABLE,
    };
    let [above, below] =
        Layout::vertical([Constraint::Length(table), Constraint::Min(0)]).areas(inner);
    if table > 0 {
        draw_table(frame, above, model, state, index);
    }
    draw_cell(frame, below, model, state, index, detail);
}

fn title(model: &Model, state: &CoverageScreen, room: usize) -> String {
    let severity = match state.severity {
        None => "all severities".to_string(),
        Some(score) => format!("severity {score} {}", severity_name(score)),
    };
    let folder = model.index.folder.as_deref().map(shown_path);
    let folder = visible(&folder.unwrap_or_default()).into_owned();
    let around = "coverage ·  · ".len();
    let used = around + severity.len();
    match (folder.is_empty(), room.saturating_sub(used)) {
        (true, _) => "coverage".into(),
        (false, left) => format!("coverage · {severity} · {}", fit_middle(&folder, left)),
    }
}

fn severity_name(severity: u8) -> &'static str {
    SEVERITY_NAMES[usize::from(severity)]
}

/// Why there is no table.
fn without(model: &Model) -> String {
    let (choose, tasks) = (
        model.look.key(Action::ChooseIndex),
        model.look.key(Action::TaskList),
    );
    match model.list.index() {
        ListIndex::Reading | ListIndex::Ready(_) => {
            let (read, all) = model.index.read;
            let percent = (100 * read).checked_div(all).unwrap_or(0);
            format!(
                "reading the index: {percent} %, {} of {} windows; {tasks} shows the task, which can be cancelled there",
                thousands(read),
                thousands(all)
            )
        }
        ListIndex::Failed => {
            let error = model.index.error.clone().unwrap_or_default();
            format!("{error}; {choose} chooses another index")
        }
        ListIndex::None => format!(
            "no index: {choose} chooses one, `nearmiss corpus index PATH… -o FOLDER` makes one (nearmiss help corpora)"
        ),
    }
}

/// A number in few columns.
fn short(number: u64) -> String {
    match number {
        0..=999 => number.to_string(),
        1_000..=999_499 => format!("{}k", (number + 500) / 1_000),
        _ => format!("{}M", (number + 500_000) / 1_000_000),
    }
}

/// One of `signs` for a number, evenly on a logarithmic scale up to the largest one.
fn sign(number: u64, largest: u64, signs: &[char]) -> char {
    let share = ((number + 1) as f64).ln() / ((largest.max(number) + 1) as f64).ln();
    let place = (share * signs.len() as f64).ceil() as usize;
    signs[place.clamp(1, signs.len()) - 1]
}

fn draw_table(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    state: &CoverageScreen,
    index: &CorpusIndex,
) {
    let theme = &model.theme;
    let columns = ALL.1 + 1;
    let width = (usize::from(area.width).saturating_sub(NAME) / columns).clamp(1, WIDEST);
    let dim = Style::new().fg(theme.dim);
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let mut head = vec![Span::raw(" ".repeat(NAME))];
    for column in 0..columns {
        let name = RoadType::ALL.get(column).map_or("all", |road| road.name());
        let chosen = column == state.column;
        let mark = if chosen { "▾" } else { "" };
        let name = format!(
            "{mark}{}",
            fit(name, width - 1 - mark.chars().count().min(width - 1))
        );
        let style = if chosen { bold } else { dim };
        head.push(Span::styled(pad_start(&name, width), style));
    }
    let mut lines = vec![Line::from(head)];
    let at = |row: usize, column: usize| {
        let (manoeuvre, road) = (
            Manoeuvre::ALL.get(row).copied(),
            RoadType::ALL.get(column).copied(),
        );
        index.counts(manoeuvre, road)
    };
    let choice = state.choice();
    let cells = (0..ALL.0).flat_map(|row| (0..ALL.1).map(move |column| (row, column)));
    let cells: Vec<CellCounts> = cells.map(|(row, column)| at(row, column)).collect();
    let largest = cells
        .iter()
        .map(|counts| choice.sums(counts).0)
        .max()
        .unwrap_or(0);
    for row in 0..=ALL.0 {
        let chosen = row == state.row;
        let name = Manoeuvre::ALL.get(row).map_or("all", |one| one.name());
        let mark = if chosen { "▸ " } else { "  " };
        let style = if chosen || row == ALL.0 {
            bold
        } else {
            Style::new()
        };
        let mut spans = vec![Span::styled(
            format!("{mark}{}", pad(name, NAME - 2)),
            style,
        )];
        for column in 0..columns {
            let total = row == ALL.0 || column == ALL.1;
            let text = cell_text(&at(row, column), choice, (!total).then_some(largest), width);
            let style = match (chosen && column == state.column, text.trim() == EMPTY) {
                (true, _) if state.inside.is_none() => theme.selected(),
                (true, _) => bold.add_modifier(Modifier::UNDERLINED),
                (false, true) => dim,
                (false, false) if total => bold,
                (false, false) => Style::new().fg(theme.accent),
            };
            spans.push(Span::styled(text, style));
        }
        lines.push(Line::from(spans).style(theme.base()));
    }
    frame.render_widget(Paragraph::new(lines), area);
}

/// A cell: its shade, its number, a sign where it was asked about, and in wide ones a bar for each severity. Totals have
/// no shade.
fn cell_text(
    counts: &CellCounts,
    choice: CellChoice,
    largest: Option<u64>,
    width: usize,
) -> String {
    let (windows, asked) = choice.sums(counts);
    let asked = if asked > 0 { "*" } else { " " };
    let text = match (windows, largest) {
        (0, _) => format!("{EMPTY} "),
        (_, None) => format!("{}{asked}", short(windows)),
        (_, Some(largest)) => {
            let shade = sign(windows, largest, &SHADES);
            format!("{shade}{}{asked}", short(windows))
        }
    };
    if width < WITH_BARS {
        return pad_start(&text, width);
    }
    let most = counts.windows.iter().copied().max().unwrap_or(0);
    let bars: String = match windows {
        0 => " ".repeat(SEVERITIES),
        _ => {
            let bar = |windows: &u64| match windows {
                0 => ' ',
                n => sign(*n, most, &BARS),
            };
            counts.windows.iter().map(bar).collect()
        }
    };
    let left = width - SEVERITIES - 1;
    format!("{}{bars} ", pad_start(&text, left))
}

fn draw_cell(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    state: &CoverageScreen,
    index: &CorpusIndex,
    detail: &CellDetail,
) {
    let theme = &model.theme;
    let width = usize::from(area.width);
    let (choice, dim) = (state.choice(), Style::new().fg(theme.dim));
    let manoeuvre = choice.manoeuvre.map_or("all manoeuvres", Manoeuvre::name);
    let road = choice.road.map_or("all roads", RoadType::name);
    let count = |number: u64, what: &str| match number {
        1 => format!("1 {what}"),
        n => format!("{} {what}s", thousands(n)),
    };
    let mut said = vec![
        format!("{manoeuvre}, {road}: {}", count(detail.windows, "window")),
        format!(
            "{} ({} listed)",
            count(detail.scenarios as u64, "scenario"),
            thousands(detail.listed as u64)
        ),
    ];
    if detail.asked > 0 {
        said.push(format!("* {} asked about", thousands(detail.asked)));
    }
    let mut lines = vec![Line::styled(
        fit(&said.join(" · "), width),
        Style::new().add_modifier(Modifier::BOLD),
    )];
    let height = usize::from(area.height);
    let share = model.list.index_share().summary();
    if !share.is_empty() && height >= 3 {
        let words = format!("of the list: {share}");
        lines.push(Line::styled(fit(&words, width), dim));
    }
    if height > lines.len() + 2 {
        let legend = format!("{EMPTY} none   ░▒▓█ few to many windows   * some asked about");
        let bars = match width {
            180.. => "   ▁▄█ by severity, 0 contact to 5 none",
            _ => "",
        };
        lines.push(Line::styled(fit(&format!("{legend}{bars}"), width), dim));
    }
    let rows = height.saturating_sub(lines.len());
    let selected = state.inside.unwrap_or(0);
    let top = (selected + 1).saturating_sub(rows);
    for (place, worst) in detail.worst.iter().enumerate().skip(top).take(rows) {
        let chosen = state.inside == Some(place);
        let words = window_words(index, worst, width.saturating_sub(2));
        let line = Line::from(format!("{}{words}", if chosen { "▸ " } else { "  " }));
        lines.push(if chosen {
            theme.select(line)
        } else {
            line.style(theme.base())
        });
    }
    frame.render_widget(Paragraph::new(lines), area);
}

/// A window in a line: severity, scenario, who, when.
fn window_words(index: &CorpusIndex, worst: &WorstWindow, width: usize) -> String {
    let window = &worst.window;
    let example = window.example;
    let ego = match example.ego {
        WindowEgo::Recorded => "ego".to_string(),
        WindowEgo::Obstacle(id) => format!("{id} as ego"),
    };
    let more = match window.windows {
        1 => String::new(),
        n => format!(" +{}", thousands(n - 1)),
    };
    let severity = format!("{} {}", window.severity, severity_name(window.severity));
    let (first, last) = example.steps;
    let facts = format!("{ego}, {} · steps {first}-{last}{more}", example.obstacle);
    let severity = pad(&severity, 13);
    let room = width.saturating_sub(severity.len() + facts.chars().count() + 1);
    let name = pad(&index.scenarios()[worst.scenario].name, room.min(60));
    format!("{severity}{name} {facts}")
}

//! The matrix of prompt configurations: counts, shares and intervals, sorted by any column.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use unicode_width::UnicodeWidthStr;

use crate::features::results::draw::foot;
use crate::model::{Model, RESULTS_COLUMNS, ResultsDrawn, ResultsView};
use crate::theme::Theme;
use crate::widgets::window;
use crate::widgets::words::{fit_end, pad, short_techniques};
use nearmiss_base::system::pad_start;
use nearmiss_scene::description::visible;
use nearmiss_study::evaluation::{Outcome, PromptConfig, Results, report};

/// Heads of the columns of numbers; `=` stands before what is right, `≠` before what is wrong.
pub const HEADS: [&str; RESULTS_COLUMNS] = [
    "n",
    "=tp",
    "≠fp",
    "≠fn",
    "=tn",
    "no truth",
    "no verdict",
    "failed",
    "precision",
    "recall",
    "F1",
    "right",
];

/// Columns in the order in which they get room: what is right of all asked and its interval first.
const RANKS: [Shown; RESULTS_COLUMNS + 4] = [
    Shown::Number(0),
    Shown::Number(11),
    Shown::Number(1),
    Shown::Number(2),
    Shown::Number(3),
    Shown::Number(4),
    Shown::Interval,
    Shown::Number(10),
    Shown::Number(8),
    Shown::Number(9),
    Shown::Number(7),
    Shown::Number(6),
    Shown::Number(5),
    Shown::Naming(0),
    Shown::Naming(1),
    Shown::Naming(2),
];

/// A column beside the names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shown {
    /// A number that can be selected.
    Number(usize),
    /// The interval of what is right of all asked.
    Interval,
    /// Recall or precision of naming, or the share of wrong claims, see [`CLAIM_HEADS`].
    Naming(usize),
}

/// The columns that need a truth: while it is worked out they have no numbers.
const OF_TRUTH: [bool; RESULTS_COLUMNS] = [
    false, true, true, true, true, true, false, false, true, true, true, true,
];

/// Columns of the terminal for how was asked, at most.
pub const NAMES: usize = 64;

/// Heads of the columns of named obstacles and of claims: of dangerous windows the share of which one is named, of all
/// names the share that is right, and of the claims that are right or wrong the share that is wrong.
const CLAIM_HEADS: [&str; 3] = ["named", "names right", "claims wrong"];

/// Columns of an interval.
const INTERVAL: usize = 12;

/// Columns that names keep before further numbers get room.
const LEAST_NAME: usize = 44;

/// How it was asked: task, frame and techniques, whole or shortened.
pub fn asked(way: &PromptConfig, short: bool) -> [String; 3] {
    let frame = way.frame.map_or("–", |frame| match frame.name() {
        whole if !short => whole,
        "cartesian" => "cart",
        "picture" => "pic",
        "ego+picture" => "ego+pic",
        "cartesian+picture" => "cart+pic",
        "metrics+picture" => "metr+pic",
        "trajectory+picture" => "traj+pic",
        name => name,
    });
    let techniques = way.techniques.map_or("–".into(), |t| t.to_string());
    let techniques = if short {
        short_techniques(&techniques)
    } else {
        techniques
    };
    let task = match way.task.name() {
        "collision" if short => "coll.",
        name => name,
    };
    [task.into(), frame.into(), techniques]
}

/// How every row was asked, in columns no wider than they have to be.
fn all_asked(rows: &[Results], short: bool) -> Vec<String> {
    let rows = rows.iter();
    let all: Vec<[String; 3]> = rows.map(|row| asked(&row.configuration, short)).collect();
    let widest = |part: usize| all.iter().map(|parts| parts[part].width()).max();
    let widths = [0, 1, 2].map(|part| widest(part).unwrap_or(0));
    let joined = |parts: &[String; 3]| {
        let parts = parts.iter().zip(widths);
        let parts: Vec<String> = parts.map(|(part, width)| pad(part, width)).collect();
        parts.join(" ")
    };
    all.iter().map(joined).collect()
}

/// The version of the template, where it is not the one that this program ships.
pub fn version(way: &PromptConfig) -> Option<String> {
    let own = way.template.as_ref().filter(|own| !own.is_shipped());
    own.map(|own| visible(&own.to_string()).into_owned())
}

/// The model of a way, with the values of the axes of its batch.
pub fn model_name(way: &PromptConfig) -> String {
    visible(&report::model_name(way)).into_owned()
}

/// The numbers of a row.
fn cells(row: &Results, judging: bool) -> Vec<String> {
    let counts = Outcome::ALL.map(|outcome| row.count(outcome).to_string());
    let c = row.confusion();
    let shares = [c.precision(), c.recall(), c.f1(), row.right_of_all()]
        .map(|share| share.map_or("–".into(), |v| format!("{v:.2}")));
    let all = std::iter::once(row.answers.len().to_string())
        .chain(counts)
        .chain(shares);
    all.zip(OF_TRUTH)
        .map(|(cell, of_truth)| {
            if judging && of_truth {
                "…".into()
            } else {
                cell
            }
        })
        .collect()
}

/// Recall and precision of naming, and the share of wrong claims, which needs no truth.
fn named(row: &Results, judging: bool) -> [String; 3] {
    let naming = row.naming();
    let shares = [
        (naming.recall(), judging),
        (naming.precision(), judging),
        (row.wrong_claims(), false),
    ];
    shares.map(|share| match share {
        (_, true) => "…".into(),
        (None, false) => "–".into(),
        (Some(share), false) => format!("{share:.2}"),
    })
}

fn interval(row: &Results, judging: bool) -> String {
    let ends = row
        .right_interval
        .map(|i| format!("{:.2} to {:.2}", i.low, i.high));
    let none = if judging { "…" } else { "–" };
    pad(&ends.unwrap_or_else(|| none.into()), INTERVAL)
}

/// The columns that fit, each with its width, and the width of names.
struct Plan {
    names: usize,
    columns: Vec<(Shown, usize)>,
    /// Heads of the numbers that found no room.
    hidden: Vec<&'static str>,
}

impl Plan {
    /// Chooses columns by rank; the selected one is always among them.
    fn new(model: &Model, asked: &[String], table: &[Vec<String>], room: usize) -> Self {
        let results = &model.results;
        let names = results.rows.iter().zip(asked);
        let longest = names
            .map(|(row, asked)| name_width(&row.configuration, asked))
            .max()
            .unwrap_or(0)
            .min(NAMES);
        let selected = Shown::Number(results.column);
        let others = RANKS.into_iter().filter(|shown| *shown != selected);
        let mut left = room.saturating_sub(2 + longest.min(LEAST_NAME));
        let mut columns = Vec::new();
        let mut is_full = false;
        for shown in std::iter::once(selected).chain(others) {
            let width = width(shown, table);
            is_full |= width > left;
            if !is_full {
                left -= width;
                columns.push((shown, width));
            }
        }
        let place = |shown: &Shown| match shown {
            Shown::Number(column) => (0, *column),
            Shown::Interval => (1, 0),
            Shown::Naming(which) => (1, 1 + which),
        };
        columns.sort_by_key(|(shown, _)| place(shown));
        let has = |column: usize| columns.iter().any(|(s, _)| *s == Shown::Number(column));
        let hidden = (0..HEADS.len())
            .filter(|column| !has(*column))
            .map(|column| HEADS[column])
            .collect();
        let used: usize = columns.iter().map(|(_, width)| width).sum();
        Self {
            names: room.saturating_sub(2 + used).min(longest),
            columns,
            hidden,
        }
    }
}

impl Plan {
    /// Whether it has room for every name.
    fn is_whole(&self, results: &ResultsView, asked: &[String]) -> bool {
        let mut names = results.rows.iter().zip(asked);
        self.columns.len() == RANKS.len()
            && names.all(|(row, asked)| name_width(&row.configuration, asked) <= self.names)
    }
}

/// Columns that a column takes: the brackets of the selected number, or the sign of the order and a gap.
fn width(shown: Shown, table: &[Vec<String>]) -> usize {
    match shown {
        Shown::Number(column) => {
            let longest = table.iter().map(|row| row[column].width()).max();
            longest.unwrap_or(0).max(HEADS[column].width()) + 2
        }
        Shown::Interval => INTERVAL + 2,
        Shown::Naming(which) => CLAIM_HEADS[which].len() + 2,
    }
}

/// Draws the matrix; gives where its rows and numbers stand.
pub fn draw(frame: &mut Frame<'_>, area: Rect, model: &Model, title: &str) -> ResultsDrawn {
    let (theme, results) = (&model.theme, &model.results);
    let inner = window::window_at(frame, area, model, title);
    let judging = results.judging.is_some();
    let table: Vec<Vec<String>> = results.rows.iter().map(|row| cells(row, judging)).collect();
    let room = usize::from(inner.width);
    let plans = [false, true].map(|short| {
        let asked = all_asked(&results.rows, short);
        (Plan::new(model, &asked, &table, room), asked)
    });
    let [(whole, words), shortened] = plans;
    let (plan, asked) = if whole.is_whole(results, &words) {
        (whole, words)
    } else {
        shortened
    };
    let window = inner;
    let inner = foot(frame, window, model, &plan.hidden);
    let dim = Style::new().fg(theme.dim);
    let rows = usize::from(inner.height).saturating_sub(1);
    let top = (results.selected + 1).saturating_sub(rows);
    let below = results.rows.len().saturating_sub(top + rows);
    window::below(frame, window, model, below);
    let mut lines = vec![Line::styled(
        head(model, &plan),
        dim.add_modifier(Modifier::BOLD),
    )];
    let shown = results.rows.iter().zip(&table).enumerate();
    for (place, (row, cells)) in shown.skip(top).take(rows) {
        let chosen = place == results.selected;
        let mut spans = vec![Span::raw(if chosen { "▸ " } else { "  " })];
        spans.extend(name(theme, &row.configuration, &asked[place], plan.names));
        for &(shown, width) in &plan.columns {
            spans.push(match shown {
                Shown::Number(column) => {
                    let picked = chosen && results.column == column;
                    number(theme, column, &cells[column], width, picked)
                }
                Shown::Interval => Span::styled(format!("  {}", interval(row, judging)), dim),
                Shown::Naming(which) => {
                    let share = &named(row, judging)[which];
                    Span::styled(pad_start(share, width), dim)
                }
            });
        }
        let line = Line::from(spans);
        lines.push(if chosen {
            theme.select(line)
        } else {
            line.style(theme.base())
        });
    }
    frame.render_widget(Paragraph::new(lines), inner);
    let list = Rect {
        y: inner.y + 1.min(inner.height),
        height: inner.height.saturating_sub(1),
        ..inner
    };
    ResultsDrawn {
        list,
        top,
        cells: places(&plan, inner.x),
        ..ResultsDrawn::default()
    }
}

/// The heads of the columns, with the sign of the order at the one that sorts.
fn head(model: &Model, plan: &Plan) -> String {
    let mut head = format!("  {}", pad("asked", plan.names));
    for &(shown, width) in &plan.columns {
        head.push_str(&match shown {
            Shown::Number(column) => {
                let sign = match model.results.order {
                    Some((by, true)) if by == column => "▲",
                    Some((by, false)) if by == column => "▼",
                    _ => "",
                };
                let words = format!("{sign}{} ", HEADS[column]);
                let gap = width.saturating_sub(words.width());
                format!("{}{words}", " ".repeat(gap))
            }
            Shown::Interval => format!("  {}", pad("right, 95 %", INTERVAL)),
            Shown::Naming(which) => format!("  {}", CLAIM_HEADS[which]),
        });
    }
    head
}

/// A number at the right of its column; the selected one is in brackets.
fn number(theme: &Theme, column: usize, cell: &str, width: usize, picked: bool) -> Span<'static> {
    let words = if picked {
        format!("[{cell}]")
    } else {
        format!("{cell} ")
    };
    let style = match cell {
        _ if picked => Style::new().add_modifier(Modifier::BOLD),
        "0" | "…" => Style::new().fg(theme.dim),
        _ => color_of(theme, column).map_or(Style::new(), |c| Style::new().fg(c)),
    };
    Span::styled(pad_start(&words, width), style)
}

/// First columns and widths of the numbers, by their places; those without room have no width.
fn places(plan: &Plan, left: u16) -> Vec<(u16, u16)> {
    let columns = |n: usize| u16::try_from(n).unwrap_or(u16::MAX);
    let mut cells = vec![(0, 0); HEADS.len()];
    let mut x = left.saturating_add(columns(2 + plan.names));
    for &(shown, width) in &plan.columns {
        if let Shown::Number(column) = shown {
            cells[column] = (x, columns(width));
        }
        x = x.saturating_add(columns(width));
    }
    cells
}

/// Columns that a way of asking takes, with a gap behind it.
fn name_width(way: &PromptConfig, asked: &str) -> usize {
    let version = version(way).map_or(0, |version| version.width() + 1);
    asked.width() + 1 + model_name(way).width() + version + 1
}

/// How was asked, whom, and with which version of the prompt; of the model the end stays where there is little room.
fn name(theme: &Theme, way: &PromptConfig, how: &str, width: usize) -> Vec<Span<'static>> {
    let left = width.saturating_sub(how.width() + 2);
    let whole = version(way).map_or(String::new(), |version| format!(" {version}"));
    // Where there is no room for its name, the hash tells versions apart.
    let name = model_name(way);
    let version = match (whole.split_once('@'), name.width()) {
        (Some((_, hash)), model) if model + whole.width() > left => format!(" @{hash}"),
        _ => whole,
    };
    let model = fit_end(&name, left.saturating_sub(version.width()));
    let gap = left.saturating_sub(model.width() + version.width()) + 1;
    vec![
        Span::raw(format!("{how} ")),
        Span::styled(model, Style::new().fg(theme.accent)),
        Span::styled(version, Style::new().fg(theme.warning)),
        Span::raw(" ".repeat(gap)),
    ]
}

fn color_of(theme: &Theme, column: usize) -> Option<Color> {
    match Outcome::ALL.get(column.checked_sub(1)?)? {
        Outcome::TruePositive | Outcome::TrueNegative => Some(theme.agree),
        Outcome::FalsePositive | Outcome::FalseNegative => Some(theme.disagree),
        Outcome::Unparsed | Outcome::Failed => Some(theme.warning),
        Outcome::Open => None,
    }
}

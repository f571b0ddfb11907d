//! Columns of the list after the names: which of them fit, and their contents.

use ratatui::style::{Color, Modifier, Style};
use ratatui::text::Span;

use crate::loaded::{Opened, Tally};
use crate::model::{HEADLINE, List, Model, Order, Row, nearest};
use crate::widgets::words::{fit, hundredths};
use nearmiss_scene::metrics::{CriticalMoment, Grade, Headline, Measure, measure};

/// A column.
#[derive(Debug, Clone, Copy)]
pub enum Column {
    /// The most dangerous value of a measure.
    Value(&'static Measure),
    /// How many obstacles.
    Obstacles,
    /// Seconds.
    Duration,
    /// Three letters.
    Country,
    /// Verdicts of stored answers to all tasks: agreement and count; the narrow form shows agreement only.
    Answers { wide: bool },
    /// By what the moment that matters is ordered among those as severe, after a word for it.
    Finer,
    /// How severe the moment that matters is, and a mark of contact.
    Severity,
}

impl Column {
    /// Columns of the screen, the one before it included.
    pub fn width(self) -> usize {
        match self {
            Self::Finer => 16,
            Self::Answers { wide: true } => 8,
            Self::Value(_) | Self::Duration => 6,
            Self::Obstacles | Self::Country | Self::Severity => 4,
            Self::Answers { wide: false } => 2,
        }
    }

    /// Its heading.
    pub fn head(self) -> String {
        match self {
            Self::Value(measure) => match (measure.id.len(), measure.unit) {
                (0..=3, "s" | "m") => format!("{} {}", measure.id, measure.unit),
                _ if measure.id == "distance" => "dist".into(),
                _ => fit(measure.id, 5),
            },
            Self::Obstacles => "obs".into(),
            Self::Duration => "time".into(),
            Self::Country => "cty".into(),
            Self::Finer => "why".into(),
            Self::Answers { wide } => if wide { "all ans" } else { "≠" }.into(),
            Self::Severity => "sev".into(),
        }
    }

    /// Whether what stands in it ends at its right.
    pub fn is_number(self) -> bool {
        matches!(
            self,
            Self::Value(_) | Self::Obstacles | Self::Duration | Self::Finer
        )
    }
}

/// The columns that fit, from left to right; where there is no row for `heads`, those that need one are left out.
/// `names` are the columns of the longest name with the word behind it.
pub fn fitting(list: &List, names: usize, width: usize, heads: bool) -> Vec<Column> {
    let sorted = match list.order {
        Order::Measure(measure) => Some(Column::Value(measure)),
        Order::Obstacles => Some(Column::Obstacles),
        Order::Duration => Some(Column::Duration),
        Order::Severity => Some(Column::Finer).filter(|column| {
            heads && 2 + MIN_NAME_COLUMNS + column.width() + Column::Severity.width() <= width
        }),
        Order::Found | Order::Name | Order::Verdicts => None,
    };
    // Names come first: agreement of answers is shown if it fits beside them.
    let sorting: usize = sorted.iter().map(|c| c.width()).sum();
    let named = 2 + list.longest.min(MIN_NAME_COLUMNS) + Column::Severity.width() + sorting;
    let narrow = Column::Answers { wide: false };
    let answers = (list.answered && named + narrow.width() <= width).then_some(narrow);
    let used: usize = sorted.iter().chain(&answers).map(|c| c.width()).sum();
    // The sign before the name, and the severity behind everything.
    let needed = 2 + names.min(NAME) + Column::Severity.width();
    let mut room = width.saturating_sub(used + needed);
    let mut take = |columns: usize| {
        let fits = room >= columns;
        room -= if fits { columns } else { 0 };
        fits
    };
    let wide = answers.is_some() && take(6);
    let mut take = |columns: usize| heads && take(columns);
    let shows = |id: &str| matches!(sorted, Some(Column::Value(m)) if m.id == id);
    let ttc = measure("ttc").filter(|m| !shows(m.id) && take(Column::Value(m).width()));
    let obstacles = !matches!(sorted, Some(Column::Obstacles)) && take(4);
    let duration = !matches!(sorted, Some(Column::Duration)) && take(6);
    let distance = measure("distance").filter(|m| !shows(m.id) && take(6));
    let country = duration && take(4);
    let columns = [
        country.then_some(Column::Country),
        duration.then_some(Column::Duration),
        obstacles.then_some(Column::Obstacles),
        distance.map(Column::Value),
        ttc.map(Column::Value),
        sorted,
        answers.map(|_| Column::Answers { wide }),
        Some(Column::Severity),
    ];
    columns.into_iter().flatten().collect()
}

/// Columns that names need before anything but the severity stands beside them, if they are so long.
const MIN_NAME_COLUMNS: usize = 24;

/// Columns that are left to names at least, if they are so long.
const NAME: usize = 40;

/// What stands in a column, and its style. With an obstacle or a planned drive as the ego, `taken` is what is open: the
/// list agrees with it, and what is only known of the recorded ego is left out.
pub fn cell(model: &Model, row: &Row, column: Column, taken: Option<&Opened>) -> Span<'static> {
    let none = Headline::default();
    let seconds = taken.map(Opened::seconds);
    let taken = taken.map(|opened| opened.headline.as_ref().unwrap_or(&none));
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let facts = row.facts();
    let unread = || Span::styled(if row.facts.is_none() { "…" } else { "–" }, dim);
    let plain = |words: Option<String>| words.map_or_else(unread, |w| Span::styled(w, dim));
    match column {
        Column::Value(measure) if taken.is_some() && !HEADLINE.contains(&measure.id) => {
            Span::styled("·", dim)
        }
        Column::Value(measure) => {
            let accent = Style::new().fg(theme.accent);
            let value = match taken {
                Some(headline) => Some(nearest(headline, measure).map(|n| n.value)),
                None => row.value_of(measure),
            };
            match value {
                None => Span::styled("…", dim),
                Some(None) => Span::styled("–", dim),
                Some(Some(value)) if value.abs() >= 100.0 || measure.is_ordinal() => {
                    Span::styled(format!("{value:.0}"), accent)
                }
                Some(Some(value)) => Span::styled(hundredths(value), accent),
            }
        }
        Column::Obstacles => plain(facts.map(|f| f.obstacles.to_string())),
        Column::Duration => plain(seconds.or(row.seconds()).map(|s| format!("{s:.1}"))),
        Column::Country => plain(Some(row.country().to_string())),
        Column::Finer => {
            let headline = taken.or_else(|| row.headline());
            let measured = headline
                .and_then(Headline::worst)
                .map(CriticalMoment::measured);
            plain(measured.flatten().map(|(word, value, unit)| {
                // Of a graze about to happen that says no more.
                if unit == "m/s²" && value > 100.0 {
                    return format!("{word} >100 {unit}");
                }
                let digits = usize::from(value.abs() < 100.0) + usize::from(value.abs() < 10.0);
                format!("{word} {value:.digits$} {unit}")
            }))
        }
        // Stored answers are about the recorded ego and the original.
        Column::Answers { .. } if taken.is_some() => Span::raw(""),
        Column::Answers { wide } => {
            let tally = facts.map_or(Tally::default(), |f| f.tally());
            let (words, color) = verdict_cell(tally, wide);
            let color = match color {
                Some(true) => theme.agree,
                Some(false) => theme.disagree,
                None => theme.dim,
            };
            Span::styled(words, Style::new().fg(color).add_modifier(Modifier::BOLD))
        }
        Column::Severity => {
            let (words, color) = match (taken, &row.facts) {
                (Some(headline), _) => severity(model, Some(headline)),
                (None, None) => ("·".into(), theme.dim),
                (None, Some(Err(_))) => ("!".into(), theme.danger),
                (None, Some(Ok(_))) => severity(model, row.headline()),
            };
            Span::styled(words, Style::new().fg(color).add_modifier(Modifier::BOLD))
        }
    }
}

/// `=3` where all of three answers agree with the built-in judge, `≠1/3` where one of three differs; whether they
/// agree.
fn verdict_cell(tally: Tally, wide: bool) -> (String, Option<bool>) {
    match (tally.differ, tally.count(), wide) {
        (_, 0, _) => (String::new(), None),
        (0, count, true) => (format!("={}", at_most_99(count)), Some(true)),
        (0, _, false) => ("=".into(), Some(true)),
        (differ, count, true) => {
            let words = format!("≠{}/{}", at_most_99(differ), at_most_99(count));
            (words, Some(false))
        }
        (_, _, false) => ("≠".into(), Some(false)),
    }
}

fn at_most_99(count: u32) -> u32 {
    count.min(99)
}

/// The severity of the moment that matters, and an X for a contact; – without an ego or an obstacle.
fn severity(model: &Model, headline: Option<&Headline>) -> (String, Color) {
    let theme = &model.theme;
    let Some(worst) = headline.and_then(Headline::worst) else {
        return ("–".into(), theme.dim);
    };
    match worst.grade {
        Grade::Contact => ("0X".into(), theme.danger),
        grade => (
            grade.number().to_string(),
            theme.risk(grade.number().into()),
        ),
    }
}

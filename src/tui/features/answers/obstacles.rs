//! What each answer says of each obstacle beside what is exact: its risk score, and whether it is critical.

use std::collections::BTreeSet;
use std::ops::Range;

use nearmiss_scene::verdict::{CriticalObstacle, ObstacleRisk, Task, Verdict};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};

use crate::model::{Column, Disagreement, Model};
use crate::theme::Theme;
use crate::widgets::words::pad;

use super::verdict::table::LABEL;

/// What a verdict says of an obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Assessment {
    /// The risk score that it states, 0 to 5.
    pub score: Option<u8>,
    /// Whether it lists the obstacle as critical; `None` where it lists none.
    pub critical: Option<bool>,
}

impl Assessment {
    /// `None` where the verdict does not name the obstacle.
    #[must_use]
    pub fn of(verdict: &Verdict, id: i64) -> Option<Self> {
        let listed = verdict.obstacles.iter().find(|o| o.id == id);
        let listed_critical = |all: &Vec<_>| all.iter().any(|one: &CriticalObstacle| one.id == id);
        let critical = verdict.critical.as_ref().map(listed_critical);
        let score = listed.map(ObstacleRisk::stated_score);
        (score.is_some() || critical == Some(true)).then_some(Self { score, critical })
    }

    /// Whether both state the same thing differently.
    fn differs(self, exact: Self) -> bool {
        let score = self.score.zip(exact.score);
        let critical = self.critical.zip(exact.critical);
        score.is_some_and(|(a, b)| a != b) || critical.is_some_and(|(a, b)| a != b)
    }

    /// Whether both state something that can be compared.
    fn compares(self, exact: Self) -> bool {
        self.score.zip(exact.score).is_some() || self.critical.zip(exact.critical).is_some()
    }

    /// Its score, with an exclamation mark where it is critical.
    fn words(self) -> String {
        let score = self
            .score
            .map_or("–".to_string(), |score| score.to_string());
        let sign = if self.critical == Some(true) { "!" } else { "" };
        format!("{score}{sign}")
    }
}

/// The score that a verdict states of the obstacle that matters most to it, and the exact one.
#[must_use]
pub fn foremost_scores(verdict: &Verdict, truth: &Verdict) -> Option<(u8, u8)> {
    let (id, score) = verdict.foremost()?;
    score.zip(Assessment::of(truth, id)?.score)
}

/// Whether the obstacle that matters most to a verdict is one of those of the truth; `None` where one of them says no.
#[must_use]
pub fn names_right(verdict: &Verdict, truth: &Verdict) -> Option<bool> {
    let (id, _) = verdict.foremost()?;
    let is_foremost = truth.foremost().map(|(id, _)| id) == Some(id);
    (truth.dangerous && verdict.dangerous).then(|| is_foremost || truth.danger().contains(&id))
}

/// The verdict that an answer is held against: the exact one of the same window.
pub fn exact<'a>(model: &'a Model, column: &'a Column) -> Option<&'a Verdict> {
    let reference = model.answers.reference.as_ref().map(|r| &r.verdict);
    let truth = column.truth_or(reference)?;
    // That of the safety task is about a window.
    (column.steps.is_some() || truth.task != Task::Safety).then_some(truth)
}

/// The obstacles that a verdict lists with a score or as critical.
pub fn ids(verdict: &Verdict) -> impl Iterator<Item = i64> {
    let critical = verdict.critical.iter().flatten().map(|c| c.id);
    verdict.obstacles.iter().map(|o| o.id).chain(critical)
}

/// The most obstacles of the built-in judge that no answer names.
const MOST_UNNAMED: usize = 3;

/// The obstacles that answers or the built-in judge name, the most dangerous first.
#[must_use]
pub fn named(model: &Model) -> Vec<i64> {
    let columns = model.answers.columns.iter();
    let verdicts: Vec<&Verdict> = columns.filter_map(|c| c.answer()?.verdict()).collect();
    if verdicts.is_empty() {
        return Vec::new();
    }
    let mut all: BTreeSet<i64> = verdicts.iter().flat_map(|v| ids(v)).collect();
    let reference = model.answers.reference.as_ref().map(|r| &r.verdict);
    if let Some(reference) = reference {
        let mut worst: Vec<&ObstacleRisk> = reference.obstacles.iter().collect();
        worst.sort_by_key(|o| o.risk_score);
        all.extend(worst.iter().take(MOST_UNNAMED).map(|o| o.id));
    }
    let least = |id: i64| {
        let of = |v: &&Verdict| Assessment::of(v, id).and_then(|a| a.score);
        verdicts.iter().filter_map(of).min()
    };
    let exact = |id: i64| reference.and_then(|v| Assessment::of(v, id)?.score);
    let mut sorted: Vec<i64> = all.into_iter().collect();
    sorted.sort_by_cached_key(|&id| {
        (
            exact(id).unwrap_or(u8::MAX),
            least(id).unwrap_or(u8::MAX),
            id,
        )
    });
    sorted
}

/// The colour of an answer, in the table and in the plot.
#[must_use]
pub fn color(theme: &Theme, column: usize) -> Color {
    let all = [
        theme.accent,
        theme.sign,
        theme.truck,
        theme.cycle,
        theme.pedestrian,
    ];
    all[column % all.len()]
}

/// The letter of an answer in the plot, before its name.
#[must_use]
pub fn letter(column: usize) -> Option<char> {
    ('a'..='z').nth(column)
}

/// A model's id without the provider.
#[must_use]
pub fn bare(id: &str) -> &str {
    id.split_once('/').map_or(id, |(_, model)| model)
}

/// The table's lines of these obstacles, for the answers in sight with the columns that each and the built-in judge take.
pub fn lines(
    model: &Model,
    named: &[i64],
    seen: Range<usize>,
    widths: &[usize],
) -> Vec<Line<'static>> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    if named.is_empty() {
        return Vec::new();
    }
    let heading = "risk score per obstacle (! critical, ≠ exact)";
    let mut lines = vec![Line::default(), Line::styled(heading, dim)];
    for &id in named {
        let is_picked = model.picked == Some(id);
        let mut style = if is_picked {
            Style::new().fg(theme.picked)
        } else {
            dim
        };
        if model.answers.cursor == Some(id) {
            style = style.bg(theme.selection).add_modifier(Modifier::BOLD);
        }
        let mut line = Line::from(Span::styled(pad(&id.to_string(), LABEL), style));
        for (i, width) in seen.clone().zip(widths) {
            let (words, style) = cell(model, &model.answers.columns[i], id);
            let cell = format!("{} ", pad(&words, width.saturating_sub(1)));
            line.push_span(Span::styled(cell, style));
        }
        let reference = model.answers.reference.as_ref();
        let exact = reference.and_then(|r| Assessment::of(&r.verdict, id));
        let words = exact.map_or("–".into(), Assessment::words);
        line.push_span(Span::styled(words, theme.base()));
        lines.push(line);
    }
    lines
}

/// What an answer says of an obstacle, and whether that is exact.
fn cell(model: &Model, column: &Column, id: i64) -> (String, Style) {
    let theme = &model.theme;
    let verdict = column.answer().and_then(|answer| answer.verdict());
    let Some(said) = verdict.and_then(|verdict| Assessment::of(verdict, id)) else {
        return ("–".into(), Style::new().fg(theme.dim));
    };
    let exact = exact(model, column).and_then(|verdict| Assessment::of(verdict, id));
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    match exact {
        Some(exact) if said.differs(exact) => {
            let words = format!("{} ≠ {}", said.words(), exact.words());
            (words, bold(theme.disagree))
        }
        Some(exact) if said.compares(exact) => (format!("{} =", said.words()), bold(theme.agree)),
        _ => (said.words(), theme.base()),
    }
}

impl Model {
    /// The obstacle that the keys of the verdict pane stand on.
    #[must_use]
    pub fn cursor_obstacle(&self) -> Option<i64> {
        let columns = self.answers.columns.iter();
        let mut verdicts = columns.filter_map(|c| c.answer()?.verdict()).peekable();
        verdicts.peek()?;
        let mut all = verdicts.chain(self.answers.reference.as_ref().map(|r| &r.verdict));
        let cursor = self.answers.cursor;
        cursor.filter(|cursor| all.any(|verdict| ids(verdict).any(|id| id == *cursor)))
    }

    /// What answers say otherwise than it is: yes for no, another risk score, another list of critical obstacles; by step.
    #[must_use]
    pub fn differences(&self) -> Vec<Disagreement> {
        let mut all = self.disagreements();
        let named = named(self);
        let (_, end) = self.clock.range();
        for (place, column) in self.answers.columns.iter().enumerate() {
            let verdict = column.answer().and_then(|answer| answer.verdict());
            let Some((verdict, truth)) = verdict.zip(exact(self, column)) else {
                continue;
            };
            let differs = |id: &i64| {
                let both = Assessment::of(verdict, *id).zip(Assessment::of(truth, *id));
                both.is_some_and(|(said, exact)| said.differs(exact))
            };
            let step = column.steps.map_or(end, |(_, last)| last);
            all.extend(
                named
                    .iter()
                    .copied()
                    .filter(differs)
                    .map(|id| Disagreement {
                        step,
                        column: place,
                        obstacle: Some(id),
                    }),
            );
        }
        all.sort_by_key(|d| (d.step, d.column));
        all
    }

    /// In words what an answer and the exact verdict say of an obstacle.
    #[must_use]
    pub fn difference_words(&self, at: Disagreement) -> Option<String> {
        let id = at.obstacle?;
        let column = self.answers.columns.get(at.column)?;
        let said = Assessment::of(column.answer()?.verdict()?, id)?;
        let exact = Assessment::of(exact(self, column)?, id)?;
        let words = |a: Assessment| {
            let score = a.score.map(|score| format!("risk {score}"));
            let critical = a
                .critical
                .map(|is| if is { "critical" } else { "not critical" });
            let parts = [score.as_deref(), critical];
            parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
        };
        Some(format!(
            "{} says {id}: {}; exact: {}",
            bare(&column.model),
            words(said),
            words(exact)
        ))
    }

    /// The risk score that an answer states of the picked obstacle; where none is picked, of the foremost.
    #[must_use]
    pub fn stated_risk(&self, column: &Column) -> Option<u8> {
        let verdict = column.answer()?.verdict()?;
        match self.picked {
            Some(id) => Assessment::of(verdict, id)?.score,
            None => verdict.foremost().and_then(|(_, score)| score),
        }
    }
}

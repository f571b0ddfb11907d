//! Draws the table of two versions: a row a scenario, and the totals below.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use crate::action::Action;
use crate::model::{Model, VersionKind};
use crate::theme::Theme;
use crate::widgets::window;
use crate::widgets::words::{fit, pad, thousands};
use nearmiss_base::system::pad_start;
use nearmiss_scene::description::visible;
use nearmiss_study::evaluation::{AnswerStatus, Outcome, Scored};
use nearmiss_workflow::{ComparedAnswers, SideTotals, VersionChange, VersionTotals};

/// The names of the sides.
pub const LETTERS: [char; 2] = ['A', 'B'];

/// Columns of the parts of a row behind the scenario's name.
const TRUTH: usize = 6;
const SAYS: usize = 7;
const CHANGE: usize = 9;
const TOKENS: usize = 6;
const COST: usize = 8;

/// Columns of a scenario's name at most: the answers stay near it on a wide screen.
const NAMES: usize = 56;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    let body = window::whole(frame, screen, model);
    let inner = window::window_at(frame, body, model, &title(model));
    let head = head(model, usize::from(inner.width));
    let foot = Paragraph::new(foot(model)).wrap(Wrap { trim: true });
    let lines = |count: usize| Constraint::Length(u16::try_from(count).unwrap_or(u16::MAX));
    let below = foot.line_count(inner.width).min(5);
    let [above, table, bottom] =
        Layout::vertical([lines(head.len() + 1), Constraint::Min(3), lines(below)]).areas(inner);
    frame.render_widget(Paragraph::new(head), above);
    frame.render_widget(foot, bottom);
    rows(frame, table, model);
}

fn title(model: &Model) -> String {
    let marked = match model.marks.count(&model.list) {
        0 => "listed",
        _ => "marked",
    };
    let count = match model.versions.found.is_some() {
        true => format!("{} {marked}", model.versions.answers().len()),
        false => marked.to_string(),
    };
    let task = format!(
        "{} · {} · {}",
        model.task.name(),
        model.frame.name(),
        model.techniques
    );
    format!(
        "prompt versions · {} · {task} · {count}",
        visible(&model.model)
    )
}

/// Columns from which on rows tell tokens and costs.
const WIDE: usize = 100;

/// The two versions, each with what is stored and what the rest would cost.
fn head(model: &Model, width: usize) -> Vec<Line<'static>> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let Some(sides) = &model.versions.sides else {
        return vec![Line::styled("one version only", dim)];
    };
    let found = model.versions.found.as_ref();
    let totals = found.map(|found| found.totals());
    let line = |side: usize| {
        let version = &sides[side];
        let mut words = format!("{} ({})", version.name(), version.origin());
        let mut price = None;
        if let (Some(totals), Some(found)) = (&totals, found) {
            let missing = found.missing(side).len();
            words.push_str(&format!(" · {} stored", totals.sides[side].answers));
            if missing > 0 && matches!(version.kind, VersionKind::Stored(_)) {
                words.push_str(&format!(" · {missing} cannot be asked"));
            } else if missing > 0 {
                words.push_str(&format!(" · {missing} to ask"));
                price = Some(found.estimates[side].price());
            }
        }
        let room = width.saturating_sub(2);
        let mut lines = vec![Line::from(vec![
            Span::styled(
                format!("{} ", LETTERS[side]),
                Style::new().fg(theme.accent).add_modifier(Modifier::BOLD),
            ),
            Span::raw(fit(&visible(&words), room)),
        ])];
        // A price is whole, below.
        let price = price.unwrap_or_default();
        for words in textwrap::wrap(&visible(&price), room.max(16)) {
            lines.push(Line::styled(format!("  {words}"), dim));
        }
        lines
    };
    let mut lines = [line(0), line(1)].concat();
    if let Some(found) = found {
        let mut truth = format!("truth: {}", found.truth);
        if found.locked > 0 {
            truth.push_str(&format!(" · {} in locked test splits", found.locked));
        }
        if found.unlabelled > 0 {
            truth.push_str(&format!(
                " · {} without a known truth left out",
                found.unlabelled
            ));
        }
        lines.push(Line::styled(fit(&visible(&truth), width), dim));
    }
    lines
}

/// What is going on, or the sums over all rows.
fn foot(model: &Model) -> Vec<Line<'static>> {
    let (theme, versions) = (&model.theme, &model.versions);
    let mut lines = Vec::new();
    let asking = versions.asking.iter().filter_map(|id| {
        let mut jobs = model.jobs.all.iter();
        jobs.find(|job| job.id == *id)
    });
    let (done, of) = asking.fold((0, 0), |(done, of), job| (done + job.done, of + job.of));
    let news = Style::new().fg(theme.warning).add_modifier(Modifier::BOLD);
    if !versions.asking.is_empty() {
        let key = model.look.key(Action::TaskList);
        let words = format!("asking {done}/{of} · {key} shows the tasks");
        lines.push(Line::styled(words, news));
    }
    // Without a table, this stands in its place.
    if versions.job.is_some() && versions.found.is_some() {
        let (done, of) = versions.looked;
        let words = format!("looking up stored answers {done}/{of}");
        lines.push(Line::styled(words, news));
    }
    if let Some(found) = &versions.found {
        let totals = found.totals();
        lines.push(changes(&totals, theme));
        for (letter, side) in LETTERS.into_iter().zip(&totals.sides) {
            lines.push(costs(letter, side, theme));
        }
    }
    lines
}

fn changes(totals: &VersionTotals, theme: &Theme) -> Line<'static> {
    let p = totals.test.map_or("–".into(), |test| match test.p < 0.001 {
        true => "<0.001".to_string(),
        false => format!("{:.3}", test.p),
    });
    let part = |change, count: usize| {
        let (word, style) = changed(change, theme);
        Span::styled(format!(" · {count} {word}"), style)
    };
    Line::from(vec![
        Span::styled(
            format!("{} compared · {} changed", totals.pairs, totals.changed),
            Style::new().add_modifier(Modifier::BOLD),
        ),
        part(VersionChange::Better, totals.better),
        part(VersionChange::Worse, totals.worse),
        Span::styled(format!(" · permutation p {p}"), Style::new().fg(theme.dim)),
    ])
}

/// What a side comes to.
fn costs(letter: char, side: &SideTotals, theme: &Theme) -> Line<'static> {
    let unknown = match side.unpriced {
        0 => String::new(),
        n => format!(" + {n} of unknown cost"),
    };
    if side.answers == 0 {
        return Line::styled(
            format!("{letter}: no answers yet"),
            Style::new().fg(theme.dim),
        );
    }
    let words = format!(
        "{letter}: {} of {} right · {} tokens · ${:.4}{unknown}",
        side.right,
        side.answers,
        thousands(side.tokens),
        side.usd
    );
    Line::styled(words, Style::new().fg(theme.dim))
}

/// A number of tokens in few columns.
fn short(tokens: u64) -> String {
    match tokens {
        0 => "–".into(),
        1..=999 => tokens.to_string(),
        1_000..=999_499 => format!("{:.1}k", tokens as f64 / 1e3),
        _ => format!("{:.1}M", tokens as f64 / 1e6),
    }
}

fn rows(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let (theme, versions) = (&model.theme, &model.versions);
    let answers = versions.answers();
    let width = usize::from(area.width);
    if answers.is_empty() {
        let words = Paragraph::new(visible(&empty(model)).into_owned()).wrap(Wrap { trim: true });
        frame.render_widget(words.style(Style::new().fg(theme.dim)), area);
        return;
    }
    let wide = width >= WIDE;
    let consumed = if wide { 2 * TOKENS + 2 * COST } else { 0 };
    let behind = TRUTH + 2 * SAYS + CHANGE + consumed;
    let names = width.saturating_sub(behind + 2).min(NAMES);
    let height = usize::from(area.height).saturating_sub(1);
    versions.rows.set(height);
    let top = (versions.selected + 1).saturating_sub(height);
    let mut lines = vec![heads(names, wide, theme)];
    for (place, row) in answers.iter().enumerate().skip(top).take(height) {
        let chosen = place == versions.selected;
        let line = line(row, (names, wide), chosen, theme);
        lines.push(match chosen {
            true => theme.select(line),
            false => line.style(theme.base()),
        });
    }
    frame.render_widget(Paragraph::new(lines), area);
}

/// Why there is no row.
fn empty(model: &Model) -> String {
    let versions = &model.versions;
    let (done, of) = versions.looked;
    match (&versions.error, versions.job) {
        (Some(error), _) => error.clone(),
        (None, Some(_)) => format!("looking up stored answers… {done} of {of}"),
        (None, None) if versions.sides.is_none() => {
            let key = model.look.key(Action::Edit);
            format!("only one version of this prompt is known: {key} edits it, then compare again")
        }
        (None, None) => "no scenario with a known truth".into(),
    }
}

fn heads(names: usize, wide: bool, theme: &Theme) -> Line<'static> {
    let mut words = format!("  {}", pad("scenario", names));
    for (word, width) in [
        ("truth", TRUTH),
        ("A", SAYS),
        ("B", SAYS),
        ("change", CHANGE),
    ] {
        words.push_str(&pad(word, width));
    }
    let consumed = [
        ("tok A", TOKENS),
        ("tok B", TOKENS),
        ("cost A", COST),
        ("cost B", COST),
    ];
    for (word, width) in consumed.into_iter().filter(|_| wide) {
        words.push_str(&pad_start(word, width));
    }
    Line::styled(
        words,
        Style::new().fg(theme.dim).add_modifier(Modifier::BOLD),
    )
}

/// A scenario's row; the columns of names, and whether tokens and costs follow.
fn line(
    row: &ComparedAnswers,
    (names, wide): (usize, bool),
    chosen: bool,
    theme: &Theme,
) -> Line<'static> {
    let name = fit(&visible(&row.answers[0].scenario), names.saturating_sub(1));
    let truth = row.truth().map_or("–", |label| match label.collides() {
        true => "yes",
        false => "no",
    });
    let (word, style) = changed(row.change(), theme);
    let mut spans = vec![
        Span::raw(if chosen { "▸ " } else { "  " }),
        Span::raw(pad(&name, names)),
        Span::raw(pad(truth, TRUTH)),
    ];
    for one in &row.answers {
        let (words, style) = said(one, theme);
        spans.push(Span::styled(pad(&words, SAYS), style));
    }
    spans.push(Span::styled(pad(&word, CHANGE), style));
    if !wide {
        return Line::from(spans);
    }
    let consumed = row.answers.each_ref().map(|one| one.consumed);
    for one in &consumed {
        let tokens = one.input_tokens.unwrap_or(0) + one.output_tokens.unwrap_or(0);
        let words = short(tokens);
        spans.push(Span::raw(format!("{words:>TOKENS$}")));
    }
    for one in &consumed {
        let words = one.cost_usd.map_or("–".into(), |usd| format!("${usd:.4}"));
        spans.push(Span::raw(format!("{words:>COST$}")));
    }
    Line::from(spans)
}

/// What an answer says, with a sign for whether it is right.
fn said(one: &Scored, theme: &Theme) -> (String, Style) {
    let word = match (&one.status, one.positive()) {
        (_, Some(true)) => "yes",
        (_, Some(false)) => "no",
        (AnswerStatus::Unparsed(_), _) => "unread",
        (AnswerStatus::Failed(_), _) if one.run.is_none() => "n/a",
        (AnswerStatus::Failed(_), _) => "failed",
        (AnswerStatus::Unasked(_) | AnswerStatus::Verdict(_), _) => {
            return ("–".into(), Style::new().fg(theme.dim));
        }
    };
    match Outcome::of_scored(one).and_then(Outcome::is_right) {
        Some(true) => (format!("{word} ="), Style::new().fg(theme.accent)),
        Some(false) => (format!("{word} ≠"), Style::new().fg(theme.warning)),
        None => (word.into(), Style::new()),
    }
}

/// A change in a word with its sign.
fn changed(change: VersionChange, theme: &Theme) -> (String, Style) {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    match change {
        VersionChange::Better => ("▲ better".into(), bold.fg(theme.accent)),
        VersionChange::Worse => ("▼ worse".into(), bold.fg(theme.warning)),
        VersionChange::Other => ("~ other".into(), bold),
        VersionChange::Same => ("= same".into(), Style::new().fg(theme.dim)),
        VersionChange::Missing => ("–".into(), Style::new().fg(theme.dim)),
    }
}

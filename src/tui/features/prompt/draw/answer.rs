//! The shown answer beside the one before it of the same model: what it says otherwise, then its text with the words that
//! changed.

use std::collections::BTreeSet;

use nearmiss_scene::description::visible;
use nearmiss_scene::verdict::Verdict;
use nearmiss_study::evaluation::claims::{CheckedClaim, Judgement};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use similar::ChangeTag;

use crate::action::Action;
use crate::features::answers::obstacles::{Assessment, ids};
use crate::model::{Column, Model, Progress, ShownAnswer, diff_of, parts};
use crate::widgets::markdown;

/// The pane's text.
pub fn text(model: &Model) -> Text<'static> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let ShownAnswer::Column(place) = model.answers.shown else {
        let key = model.look.key(Action::Run);
        return Text::styled(format!("no answer of a model is shown; {key} asks"), dim);
    };
    let Some(column) = model.answers.columns.get(place) else {
        return Text::default();
    };
    let before = before(model, place);
    let mut text = Text::from(head(model, column));
    if let Progress::Unasked(why) | Progress::Broken(why) | Progress::Retrying(why) =
        &column.progress
    {
        let warning = Style::new().fg(theme.warning);
        text.push_line(Line::styled(visible(why).into_owned(), warning));
    }
    let Some(answer) = column.answer() else {
        let so_far = format!("{}{}", column.reasoning, column.text);
        text.extend(
            so_far
                .lines()
                .map(|line| Line::from(visible(line).into_owned())),
        );
        return text;
    };
    let whole = |column: &Column| format!("{}\n{}", column.reasoning, column.text);
    let Some(earlier) = before else {
        text.push_line(Line::styled("no earlier answer of this model", dim));
        text.push_line("");
        let words = whole(column);
        text.extend(
            words
                .trim()
                .lines()
                .map(|line| Line::from(visible(line).into_owned())),
        );
        return text;
    };
    let verdicts = earlier
        .1
        .answer()
        .and_then(|a| a.verdict())
        .zip(answer.verdict());
    let mut said = verdicts.map_or(Vec::new(), |(old, new)| changes(old, new));
    said.extend(flipped(model, earlier.0, place));
    if said.is_empty() {
        text.push_line(Line::styled("verdict, scores and claims as before", dim));
    }
    let bold = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    text.extend(said.into_iter().map(|words| Line::styled(words, bold)));
    let words = format!("before: {}", earlier.1.how);
    text.push_line(Line::styled(visible(&words).into_owned(), dim));
    text.push_line("");
    text.extend(words_changed(model, &whole(earlier.1), &whole(column)));
    text
}

/// Whose answer it is, how it was asked, and how far it is.
fn head(model: &Model, column: &Column) -> Line<'static> {
    let state = match &column.progress {
        Progress::Waiting(_) => "waiting…",
        Progress::Retrying(_) => "retrying…",
        Progress::Arriving(_) => "streaming…",
        Progress::Unasked(_) => "not sent",
        Progress::Broken(_) => "no answer",
        Progress::Done(answer) => answer.verdict().map_or("no verdict", Verdict::word),
    };
    let words = format!("{}: {state}", column.model);
    let title = Style::new()
        .fg(model.theme.title)
        .add_modifier(Modifier::BOLD);
    let mut line = Line::styled(visible(&words).into_owned(), title);
    let how = format!(" · {}", visible(&column.how));
    line.push_span(Span::styled(how, Style::new().fg(model.theme.dim)));
    line
}

/// The newest other answer of the same model, one with the same frame and techniques first, and its place.
fn before(model: &Model, place: usize) -> Option<(usize, &Column)> {
    let columns = &model.answers.columns;
    let shown = &columns[place];
    let others = columns.iter().enumerate().filter(|(i, column)| {
        *i != place && column.model == shown.model && column.answer().is_some()
    });
    let (frame, techniques, _) = parts(&shown.how);
    others.max_by_key(|(i, column)| {
        let (of, with, _) = parts(&column.how);
        let run = column.answer().and_then(|a| a.run);
        ((of, with) == (frame, techniques), run, *i)
    })
}

/// What the new verdict says otherwise than the old one, a line each.
fn changes(old: &Verdict, new: &Verdict) -> Vec<String> {
    let mut found = Vec::new();
    if old.dangerous != new.dangerous {
        found.push(format!("verdict: {} → {}", old.word(), new.word()));
    }
    let all: BTreeSet<i64> = ids(old).chain(ids(new)).collect();
    for id in all {
        let [old_risk, new_risk] = [old, new].map(|verdict| {
            let score = Assessment::of(verdict, id).and_then(|a| a.score);
            score.map_or("–".to_string(), |score| score.to_string())
        });
        if old_risk != new_risk {
            found.push(format!("risk of {id}: {old_risk} → {new_risk}"));
        }
        // Critical obstacles without this one say that it is not critical, also where it has no entry.
        let [was, is] = [old, new].map(|verdict| {
            let critical = verdict.critical.as_ref()?;
            Some(critical.iter().any(|one| one.id == id))
        });
        if let (Some(a), Some(b)) = (was, is)
            && a != b
        {
            let words = |is| if is { "critical" } else { "not critical" };
            found.push(format!("{id}: {} → {}", words(a), words(b)));
        }
    }
    if let (Some(a), Some(b)) = (old.probability, new.probability)
        && (a - b).abs() >= 0.005
    {
        found.push(format!("P(yes): {a:.2} → {b:.2}"));
    }
    found
}

/// How many claims are false, before and now, where that changed.
fn flipped(model: &Model, old: usize, new: usize) -> Option<String> {
    let count = |place| {
        let document = model.document(ShownAnswer::Column(place))?;
        let known = model.claims.is_known(document.key);
        let is_false = |claim: &&CheckedClaim| claim.judgement == Judgement::Wrong;
        let claims = model.claims.get(document.key);
        known.then(|| (claims.iter().filter(is_false).count(), claims.len()))
    };
    let (a, b) = count(old).zip(count(new))?;
    (a != b).then(|| format!("claims: {} of {} false → {} of {}", a.0, a.1, b.0, b.1))
}

/// The new text, with words that are new underlined; then the lines that went, crossed out.
fn words_changed(model: &Model, old: &str, new: &str) -> Vec<Line<'static>> {
    let theme = &model.theme;
    let diff = diff_of(old.trim(), new.trim());
    let (mut lines, mut gone) = (Vec::new(), Vec::new());
    for op in diff.ops() {
        for change in diff.iter_inline_changes(op) {
            let parts: Vec<(bool, String)> = change
                .iter_strings_lossy()
                .map(|(changed, part)| (changed, part.trim_end_matches(['\n', '\r']).into()))
                .collect();
            let whole: String = parts.iter().map(|(_, part)| part.as_str()).collect();
            let whole = visible(&whole).into_owned();
            let plain = || {
                let pieces = markdown::line(&whole, theme).into_iter();
                pieces.map(|piece| piece.span).collect::<Vec<_>>()
            };
            let by_words = parts.iter().any(|(changed, _)| *changed);
            let marked = |mark: Style| {
                let spans = parts.iter().map(|(changed, part)| {
                    let style = if *changed || !by_words {
                        mark
                    } else {
                        theme.base()
                    };
                    Span::styled(visible(part).into_owned(), style)
                });
                spans.collect::<Vec<_>>()
            };
            match change.tag() {
                ChangeTag::Equal => lines.push(Line::from(plain())),
                ChangeTag::Insert => {
                    let new = Modifier::UNDERLINED | Modifier::BOLD;
                    let style = Style::new().fg(theme.safe).add_modifier(new);
                    lines.push(Line::from(marked(style)));
                }
                ChangeTag::Delete => {
                    let style = Style::new().fg(theme.dim);
                    gone.push(Line::from(marked(
                        style.add_modifier(Modifier::CROSSED_OUT),
                    )));
                }
            }
        }
    }
    if !gone.is_empty() {
        lines.push(Line::default());
        let title = Style::new().fg(theme.title);
        lines.push(Line::styled("── no longer said ──", title));
        lines.append(&mut gone);
    }
    lines
}

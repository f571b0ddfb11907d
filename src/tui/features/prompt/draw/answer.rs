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
use crate::model::{Column, Model, Progress, ShownAnswer, TextChanges, parts};
use crate::theme::Theme;
use crate::widgets::markdown;

/// The pane's text; `kept` is what changed when it was drawn last.
pub fn text(model: &Model, kept: &mut TextChanges) -> Text<'static> {
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
    let whole = |place| {
        model
            .document(ShownAnswer::Column(place))
            .unwrap_or_default()
    };
    let plain = |line: &str| {
        let pieces = markdown::line(line, theme).into_iter();
        Line::from(pieces.map(|piece| piece.span).collect::<Vec<_>>())
    };
    let mut text = Text::from(head(model, column));
    if let Progress::Unasked(why) | Progress::Broken(why) | Progress::Retrying(why) =
        &column.progress
    {
        let warning = Style::new().fg(theme.warning);
        text.push_line(Line::styled(visible(why).into_owned(), warning));
    }
    let Some(answer) = column.answer() else {
        text.extend(whole(place).text.lines().map(plain));
        return text;
    };
    let Some(earlier) = before else {
        text.push_line(Line::styled("no earlier answer of this model", dim));
        text.push_line("");
        text.extend(whole(place).text.trim().lines().map(plain));
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
    let changes = kept.lines(&whole(earlier.0).text, &whole(place).text);
    let (mut gone, mut there) = (Vec::new(), Vec::new());
    for (tag, parts) in changes {
        match tag {
            ChangeTag::Equal => {
                let line: String = parts.iter().map(|(_, part)| part.as_str()).collect();
                there.push(plain(&line));
            }
            ChangeTag::Insert => {
                let new = Modifier::UNDERLINED | Modifier::BOLD;
                let style = Style::new().fg(theme.safe).add_modifier(new);
                there.push(marked(parts, style, theme));
            }
            // A line to which only words were added is still said.
            ChangeTag::Delete if !parts.iter().any(|(changed, _)| *changed) => {}
            ChangeTag::Delete => {
                let style = dim.add_modifier(Modifier::CROSSED_OUT);
                gone.push(marked(parts, style, theme));
            }
        }
    }
    text.extend(there);
    if !gone.is_empty() {
        text.push_line("");
        let title = Style::new().fg(theme.title);
        text.push_line(Line::styled("── no longer said ──", title));
        text.extend(gone);
    }
    text
}

/// A line with its changed words marked.
fn marked(parts: &[(bool, String)], mark: Style, theme: &Theme) -> Line<'static> {
    let spans = parts.iter().map(|(changed, part)| {
        let style = if *changed { mark } else { theme.base() };
        Span::styled(part.clone(), style)
    });
    Line::from(spans.collect::<Vec<_>>())
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

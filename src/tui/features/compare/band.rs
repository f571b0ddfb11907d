//! Bands around the answers: claims of the focused column below; over them why one is wrong, and rating totals.

use std::ops::Range;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Block, BorderType, Clear, Paragraph, Wrap};

use crate::action::Action;
use crate::features::compare::draw;
use crate::model::{Document, Model, REASONS};
use crate::widgets::words::pad;
use crate::widgets::{claimed, unbroken};
use nearmiss_study::evaluation::claims::{Judgement, TOLERANCES};
use nearmiss_study::evaluation::{Standings, StandingsBy};

/// The claims of the column that has the keys, the wrong ones first, and the picked one whole.
pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let focus = model.compare.focus;
    let Some(&shown) = model.compare.shown.get(focus) else {
        return;
    };
    let Some(document) = model.document(shown) else {
        return;
    };
    let hides = model.compare.hides();
    let claims = if hides {
        &[]
    } else {
        model.claims.get(document.key)
    };
    let picked = model.claims.picked_of(document.key).filter(|_| !hides);
    let title = if hides {
        " checks hidden until rated ".to_string()
    } else if claims.is_empty() && model.claims.unread(document.key).is_empty() {
        " no claims found ".to_string()
    } else {
        format!(
            " {} · {} ",
            claimed::summary(claims, model.claims.unread(document.key).len()),
            draw::name(model, shown)
        )
    };
    let block = Block::bordered()
        .border_style(Style::new().fg(theme.border))
        .title(Line::styled(title, Style::new().fg(theme.title)));
    let inner = block.inner(area);
    f.render_widget(block, area);
    let rows = usize::from(inner.height);
    let width = usize::from(inner.width);
    let listed = if hides {
        Vec::new()
    } else {
        listed(model, &document)
    };
    // Where all have room whole, none is cut; else all but the picked one are.
    let mut items: Vec<(bool, Vec<Line<'static>>)> = listed
        .iter()
        .map(|(place, line)| (place.is_some() && *place == picked, wrapped(line, width)))
        .collect();
    let count = items.len();
    let at = items.iter().position(|(is_picked, _)| *is_picked);
    let (mut first, mut seen) = (0, count);
    if items.iter().map(|(_, lines)| lines.len()).sum::<usize>() > rows {
        for ((_, line), (is_picked, lines)) in listed.into_iter().zip(&mut items) {
            if !*is_picked {
                *lines = vec![claimed::cut(line, width)];
            }
        }
        let others = rows.saturating_sub(at.map_or(1, |at| items[at].1.len()));
        seen = count.min(others + 1);
        first = at
            .map_or(0, |at| at.saturating_sub(others.div_ceil(2)))
            .min(count - seen);
    }
    let mut text = Text::default();
    let mark = |line: Line<'static>, is_picked: bool| {
        if is_picked {
            let missing = width.saturating_sub(line.width());
            let mut line = line;
            line.push_span(" ".repeat(missing));
            model.theme.select(line)
        } else {
            line
        }
    };
    for (is_picked, lines) in items.into_iter().skip(first).take(seen) {
        text.extend(lines.into_iter().map(|line| mark(line, is_picked)));
    }
    let used = text.lines.len();
    if seen < count {
        let (from, to) = (first + 1, first + seen);
        in_border(f, area, model, &format!(" {from}–{to} of {count} "));
    }
    f.render_widget(Paragraph::new(text), inner);
    if used < rows && !claims.is_empty() {
        let below = Rect {
            y: inner.y + u16::try_from(used).unwrap_or(0),
            height: u16::try_from(rows - used).unwrap_or(0),
            ..inner
        };
        let words = Paragraph::new(format!("right: within {TOLERANCES}")).wrap(Wrap { trim: true });
        if words.line_count(below.width) <= usize::from(below.height) {
            f.render_widget(words.style(dim), below);
        }
    }
}

/// The lines of the list with the places of their claims: what is wrong, what cannot be told, sentences that were not
/// understood, and what is right.
fn listed(model: &Model, document: &Document) -> Vec<(Option<usize>, Line<'static>)> {
    let theme = &model.theme;
    let claims = model.claims.get(document.key);
    let line = |&(place, times): &(usize, usize)| {
        let mut line = claimed::line(&claims[place], theme);
        if times > 1
            && let Some(words) = line.spans.last_mut()
        {
            words.content = format!("{} ×{times}", words.content).into();
        }
        (Some(place), line)
    };
    let unread = |sentence: &Range<usize>| {
        let raw = document.text.get(sentence.clone()).unwrap_or_default();
        let plain = raw.trim().trim_start_matches(['-', '*', '#', ' ']);
        let words = format!("not understood: {}", plain.replace("**", ""));
        let dim = Style::new().fg(theme.dim);
        let spans = ["… ", words.as_str()].map(|part| Span::styled(part.to_string(), dim));
        (None, Line::from(spans.to_vec()))
    };
    let all = model.claims.listed(document.key);
    let is_right = |(place, _): &(usize, usize)| claims[*place].judgement == Judgement::Right;
    let (before, right) = all.split_at(all.iter().position(is_right).unwrap_or(all.len()));
    let unread = model.claims.unread(document.key).iter().map(unread);
    let before = before.iter().map(line).chain(unread);
    before.chain(right.iter().map(line)).collect()
}

/// A line of the list on as many lines as it takes, further ones below its words.
fn wrapped(line: &Line<'static>, width: usize) -> Vec<Line<'static>> {
    let [sign, words] = line.spans.as_slice() else {
        return Vec::new();
    };
    let columns = sign.width();
    let parts = unbroken::wrap(&words.content, width.saturating_sub(columns).max(16));
    let lines = parts.iter().enumerate().map(|(at, part)| {
        let sign = match at {
            0 => sign.clone(),
            _ => Span::raw(" ".repeat(columns)),
        };
        Line::from(vec![sign, Span::styled(part.to_string(), words.style)])
    });
    lines.collect()
}

/// Words at the right of the lower border.
fn in_border(f: &mut Frame<'_>, area: Rect, model: &Model, words: &str) {
    let words = Span::styled(words.to_string(), Style::new().fg(model.theme.dim));
    let width = u16::try_from(words.width()).unwrap_or(u16::MAX);
    let place = Rect {
        x: area.right().saturating_sub(width + 1).max(area.x),
        y: area.bottom().saturating_sub(1),
        width: width.min(area.width),
        height: 1,
    };
    f.render_widget(words, place);
}

/// Why the answer is wrong: a short list, and words of one's own.
pub fn marking(f: &mut Frame<'_>, screen: Rect, model: &Model) {
    let Some(marking) = &model.compare.marking else {
        return;
    };
    let theme = &model.theme;
    let mut lines: Vec<Line<'_>> = REASONS
        .iter()
        .enumerate()
        .map(|(i, reason)| {
            let (sign, style) = if i == marking.selected {
                (
                    "> ",
                    theme
                        .base()
                        .add_modifier(Modifier::BOLD | Modifier::REVERSED),
                )
            } else {
                ("  ", theme.base())
            };
            Line::styled(format!("{sign}{reason}"), style)
        })
        .collect();
    let typed = nearmiss_scene::description::visible(&marking.text).into_owned();
    lines.push(Line::from(vec![
        Span::styled("note: ", Style::new().fg(theme.dim)),
        Span::styled(format!("{typed}▏"), theme.base()),
    ]));
    let title = format!(
        " answer {} is wrong because · Enter save · Esc cancel ",
        model.compare.focus + 1
    );
    window(
        f,
        screen,
        model,
        &title,
        (62, lines.len()),
        Text::from(lines),
    );
}

/// Columns of the window of ratings.
const RATINGS: u16 = 86;

/// Rating totals.
pub fn ratings(f: &mut Frame<'_>, screen: Rect, model: &Model) {
    let Some(ratings) = &model.compare.ratings else {
        return;
    };
    let theme = &model.theme;
    let mut text = Text::default();
    if ratings.is_empty() {
        let [first, fourth, tie, wrong] = [
            Action::BestFirst,
            Action::BestFourth,
            Action::RateTie,
            Action::RateAllWrong,
        ]
        .map(|action| model.look.key(action));
        text.push_line(format!(
            "no ratings yet: {first} to {fourth}, {tie} and {wrong} rate"
        ));
    }
    for (by, name) in [
        (StandingsBy::Model, "model"),
        (StandingsBy::Prompt, "prompt"),
    ] {
        if ratings.is_empty() {
            continue;
        }
        let standings = Standings::from_ratings(ratings, by);
        let head = format!(
            "{} games won tied lost wrong  strength (95 %)",
            pad(name, 30)
        );
        let title = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
        text.push_line(Line::styled(head, title));
        for row in &standings.rows {
            let strength = match (row.strength, row.low, row.high) {
                (Some(s), Some(low), Some(high)) => format!("{s:+.2} ({low:+.2} to {high:+.2})"),
                _ => "–".into(),
            };
            text.push_line(format!(
                "{} {:>5} {:>3} {:>4} {:>4} {:>5}  {strength}",
                pad(&row.name, 30),
                row.games,
                row.wins,
                row.ties,
                row.losses,
                row.wrong
            ));
        }
        if let Some(why) = &standings.without {
            text.push_line(Line::styled(
                format!("no strengths: {why}"),
                Style::new().fg(theme.warning),
            ));
        }
        text.push_line("");
    }
    let blind = ratings.iter().filter(|r| r.blind).count();
    let title = format!(
        " {} {}, {blind} of them blind · {} closes ",
        ratings.len(),
        if ratings.len() == 1 {
            "rating"
        } else {
            "ratings"
        },
        model.look.key(Action::Cancel)
    );
    let inside = RATINGS.min(screen.width).saturating_sub(2);
    let rows = Paragraph::new(text.clone())
        .wrap(Wrap { trim: false })
        .line_count(inside);
    window(f, screen, model, &title, (RATINGS, rows), text);
}

fn window(
    f: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    title: &str,
    (width, rows): (u16, usize),
    text: Text<'_>,
) {
    let width = width.min(screen.width);
    let height = u16::try_from(rows + 2)
        .unwrap_or(u16::MAX)
        .min(screen.height);
    let area = Rect {
        x: screen.x + (screen.width - width) / 2,
        y: screen.y + (screen.height - height) / 3,
        width,
        height,
    };
    let block = Block::bordered()
        .border_type(BorderType::Thick)
        .border_style(Style::new().fg(model.theme.border_focused))
        .title(title)
        .style(model.theme.base());
    f.render_widget(Clear, area);
    f.render_widget(
        Paragraph::new(text).wrap(Wrap { trim: false }).block(block),
        area,
    );
}

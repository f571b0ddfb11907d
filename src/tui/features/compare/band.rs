//! Bands around the answers: claims of the focused column below; over them why one is wrong, and rating totals.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Block, BorderType, Clear, Paragraph, Wrap};

use crate::action::Action;
use crate::features::compare::draw;
use crate::model::{Model, REASONS};
use crate::theme::Theme;
use crate::widgets::claimed;
use crate::widgets::words::{fit, pad};
use nearmiss_study::evaluation::claims::{CheckedClaim, Judgement, TOLERANCES};
use nearmiss_study::evaluation::{Standings, StandingsBy};

/// The claims of the column that has the keys, the picked one in sight; else the wrong ones first.
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
    let mut order: Vec<usize> = (0..claims.len()).collect();
    if picked.is_none() {
        order.sort_by_key(|i| match claims[*i].judgement {
            Judgement::Wrong => 0,
            Judgement::Unknown(_) => 1,
            Judgement::Right => 2,
        });
    }
    let rows = usize::from(inner.height);
    // Where all have room whole, none is cut.
    let width = usize::from(inner.width);
    let whole: Vec<Vec<Line<'static>>> = order
        .iter()
        .map(|place| wrapped(&claims[*place], width, theme))
        .collect();
    let fits = whole.iter().map(Vec::len).sum::<usize>() <= rows;
    let first = picked
        .map_or(0, |p| p.saturating_sub(rows / 2))
        .min(order.len().saturating_sub(rows));
    let mut text = Text::default();
    let mark = |line: Line<'static>, place| {
        if picked == Some(place) {
            line.style(Style::new().add_modifier(Modifier::REVERSED))
        } else {
            line
        }
    };
    for (lines, &place) in whole.into_iter().zip(&order).filter(|_| fits) {
        text.extend(lines.into_iter().map(|line| mark(line, place)));
    }
    for &place in order.iter().skip(first).take(rows).filter(|_| !fits) {
        let mut line = claimed::line(&claims[place], theme);
        if line.width() > usize::from(inner.width) {
            // The symbol keeps its colour; truncation is marked.
            let sign = line.spans.first().map_or(0, Span::width);
            if let Some(words) = line.spans.get_mut(1) {
                let room = usize::from(inner.width).saturating_sub(sign);
                words.content = fit(&words.content, room).into();
            }
        }
        text.push_line(mark(line, place));
    }
    let listed = text.lines.len();
    if !fits && order.len() > rows {
        let (from, to) = (first + 1, (first + rows).min(order.len()));
        in_border(f, area, model, &format!(" {from}–{to} of {} ", order.len()));
    }
    f.render_widget(Paragraph::new(text), inner);
    if listed < rows && !claims.is_empty() {
        let below = Rect {
            y: inner.y + u16::try_from(listed).unwrap_or(0),
            height: u16::try_from(rows - listed).unwrap_or(0),
            ..inner
        };
        let words = Paragraph::new(format!("right: within {TOLERANCES}")).wrap(Wrap { trim: true });
        f.render_widget(words.style(dim), below);
    }
}

/// A claim on as many lines as it takes, further ones below its words.
fn wrapped(claim: &CheckedClaim, width: usize, theme: &Theme) -> Vec<Line<'static>> {
    let line = claimed::line(claim, theme);
    let mut spans = line.spans.into_iter();
    let (Some(sign), Some(words)) = (spans.next(), spans.next()) else {
        return Vec::new();
    };
    let columns = sign.width();
    let parts = textwrap::wrap(&words.content, width.saturating_sub(columns).max(16));
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

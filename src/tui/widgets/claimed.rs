//! Text with claims underlined, each with a symbol for whether it holds.

use std::ops::Range;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Paragraph, Wrap};

use crate::model::counted;
use crate::theme::Theme;
use crate::widgets::long_text::MarkedClaims;
use crate::widgets::markdown::Piece;
use crate::widgets::unbroken;
use crate::widgets::words::fit;
use nearmiss_study::evaluation::claims::{CheckedClaim, Judgement};

/// The sign of a claim and its style.
fn sign(judgement: Judgement, theme: &Theme) -> (&'static str, Style) {
    match judgement {
        Judgement::Right => ("=", Style::new().fg(theme.agree)),
        Judgement::Wrong => {
            let style = Style::new().fg(theme.disagree).add_modifier(Modifier::BOLD);
            ("≠", style)
        }
        Judgement::Unknown(_) => ("?", Style::new().fg(theme.warning)),
    }
}

/// A line with its claims marked; `start` is where it begins in the text.
#[must_use]
pub fn marked(
    line: Vec<Piece>,
    claims: &[(usize, &CheckedClaim)],
    start: usize,
    marks: &MarkedClaims<'_>,
    theme: &Theme,
) -> Line<'static> {
    let place = |piece: &Piece| {
        let from = start + piece.at?;
        Some((from, from + piece.span.content.len()))
    };
    // Markup may hide the end of a claim: its sign stands behind the last part that is shown.
    let shown_end = |claim: &Range<usize>| {
        let ends = line.iter().filter_map(place);
        let inside = ends.filter(|(from, end)| claim.start < *end && *from < claim.end);
        inside.map(|(_, end)| end.min(claim.end)).max()
    };
    let ends: Vec<Option<usize>> = claims
        .iter()
        .map(|(_, checked)| shown_end(&checked.claim.span))
        .collect();
    let mut spans = Vec::new();
    for piece in &line {
        let Some((at, end)) = place(piece) else {
            spans.push(piece.span.clone());
            continue;
        };
        let text = piece.span.content.as_ref();
        let part = |a: usize, b: usize| text.get(a - at..b - at).unwrap_or_default().to_string();
        let mut from = at;
        for ((number, checked), shown_end) in claims.iter().zip(&ends) {
            let claim = &checked.claim.span;
            let (first, last) = (claim.start.max(from), claim.end.min(end));
            if first >= last {
                continue;
            }
            // Both ends are ends of characters, as the claim was found in this text.
            let (sign, style) = sign(checked.judgement, theme);
            let mut style = style.add_modifier(Modifier::UNDERLINED);
            if marks.picked == Some(*number) {
                style = style.add_modifier(Modifier::REVERSED);
            }
            let plain = piece.span.style;
            spans.extend(underlined(&part(from, first), from, plain, marks.unread));
            spans.push(Span::styled(part(first, last), style));
            if Some(last) == *shown_end {
                spans.push(Span::styled(
                    sign,
                    style.remove_modifier(Modifier::UNDERLINED),
                ));
            }
            from = last;
        }
        spans.extend(underlined(
            &part(from, end),
            from,
            piece.span.style,
            marks.unread,
        ));
    }
    spans.retain(|span| !span.content.is_empty());
    unbroken::line(Line::from(spans))
}

/// Draws lines that [`marked`] made, from a row on.
pub fn render(f: &mut Frame<'_>, area: Rect, lines: Vec<Line<'_>>, above: usize) {
    let words = Paragraph::new(Text::from(lines)).wrap(Wrap { trim: false });
    let above = u16::try_from(above).unwrap_or(u16::MAX);
    f.render_widget(words.scroll((above, 0)), area);
}

/// A part of the text from a byte on, underlined where it was not understood.
fn underlined(part: &str, at: usize, style: Style, unread: &[Range<usize>]) -> Vec<Span<'static>> {
    let end = at + part.len();
    let mut spans = Vec::new();
    let mut from = at;
    for sentence in unread.iter().filter(|s| s.start < end && at < s.end) {
        let (first, last) = (sentence.start.max(from), sentence.end.min(end));
        if first >= last {
            continue;
        }
        let words = |a: usize, b: usize| part.get(a - at..b - at).unwrap_or_default().to_string();
        spans.push(Span::styled(words(from, first), style));
        let marked = style.add_modifier(Modifier::UNDERLINED | Modifier::DIM);
        spans.push(Span::styled(words(first, last), marked));
        from = last;
    }
    spans.push(Span::styled(
        part.get(from - at..).unwrap_or_default().to_string(),
        style,
    ));
    spans
}

/// A claim beside the truth.
#[must_use]
pub fn line(checked: &CheckedClaim, theme: &Theme) -> Line<'static> {
    signed(checked, checked.line(), theme)
}

/// The same in few columns.
#[must_use]
pub fn short_line(checked: &CheckedClaim, theme: &Theme) -> Line<'static> {
    signed(checked, checked.short_line(), theme)
}

fn signed(checked: &CheckedClaim, words: String, theme: &Theme) -> Line<'static> {
    let (sign, style) = sign(checked.judgement, theme);
    Line::from(vec![
        Span::styled(format!("{sign} "), style),
        Span::styled(words, theme.base()),
    ])
}

/// A line of a claim in so many columns; truncation is marked.
#[must_use]
pub fn cut(mut line: Line<'static>, width: usize) -> Line<'static> {
    let sign = line.spans.first().map_or(0, Span::width);
    if let Some(words) = line.spans.get_mut(1) {
        words.content = fit(&words.content, width.saturating_sub(sign)).into();
    }
    line
}

/// How many claims there are, how many hold, and how many sentences were not understood.
#[must_use]
pub fn summary(claims: &[CheckedClaim], unread: usize) -> String {
    let word = if claims.len() == 1 { "claim" } else { "claims" };
    match (claims.len(), unread) {
        (count, 0) => format!("{count} {word}: {}", counts(claims)),
        (0, _) => format!("no claim checked, {unread} not understood"),
        (count, _) => {
            let known = parts(claims, [" ≠ wrong", " = right", " ? open"]).join(", ");
            format!("{count} checked: {known}; {unread} not understood")
        }
    }
}

/// How many claims do not hold, how many do, and how many cannot be told.
fn counts(claims: &[CheckedClaim]) -> String {
    let (right, ..) = counted(claims);
    if !claims.is_empty() && right == claims.len() {
        return "all = right".into();
    }
    parts(claims, [" ≠ wrong", " = right", " ? open"]).join(", ")
}

/// The same in few columns: `1≠ 2= 2?`.
#[must_use]
pub fn short_counts(claims: &[CheckedClaim]) -> String {
    parts(claims, ["≠", "=", "?"]).join(" ")
}

/// The counts that are not 0, each before its word: of wrong claims, right ones and open ones.
fn parts(claims: &[CheckedClaim], words: [&str; 3]) -> Vec<String> {
    let (right, wrong, open) = counted(claims);
    let all = [wrong, right, open].into_iter().zip(words);
    let known = all.filter(|(count, _)| *count > 0);
    known
        .map(|(count, word)| format!("{count}{word}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::widgets::long_text::Reading;
    use nearmiss_study::evaluation::claims::{
        Claim, ClaimBasis, ClaimedValue, Extent, Quantity, Side,
    };

    #[test]
    fn claims_are_marked_where_they_stand() {
        let document = "# ü head\n7 is behind the ego\n\nand 7 is left";
        let claim = |words: &str, judgement| {
            let from = document.find(words).unwrap_or_default();
            CheckedClaim {
                claim: Claim {
                    span: from..from + words.len(),
                    obstacle: 7,
                    named: true,
                    quantity: Quantity::Side,
                    stated: ClaimedValue::Side(Side {
                        front: Some(false),
                        left: None,
                    }),
                    step: None,
                    is_of_ego: false,
                    is_past: false,
                    is_described: false,
                    is_apart: false,
                    extent: Extent::default(),
                },
                step: 3,
                truth: None,
                is: "front".into(),
                basis: ClaimBasis::Exact,
                judgement,
                contradicts: None,
            }
        };
        let claims = [
            claim("behind", Judgement::Wrong),
            claim("left", Judgement::Right),
        ];
        let theme = Theme::default_theme();
        let marks = MarkedClaims {
            claims: &claims,
            key: 1,
            picked: Some(1),
            unread: &[],
        };
        let mut reading = Reading::answer();
        reading.follow(document, &marks, 40, &theme);
        let row = |claim: &CheckedClaim, reading: &mut Reading| {
            reading.row_of(claim.claim.span.end, &marks, &theme)
        };
        assert_eq!(
            claims.each_ref().map(|c| row(c, &mut reading)),
            [Some(1), Some(3)]
        );
        let (lines, _) = reading.seen(0, 9, &marks, &theme);
        let shown: Vec<String> = lines.iter().map(ToString::to_string).collect();
        assert_eq!(
            shown,
            ["ü head", "7 is behind≠ the ego", "", "and 7 is left="]
        );
        let picked = lines[3].spans.iter().find(|s| s.content == "left");
        assert!(picked.is_some_and(|s| s.style.add_modifier.contains(Modifier::REVERSED)));
        assert_eq!(summary(&claims, 0), "2 claims: 1 ≠ wrong, 1 = right");
        assert_eq!(
            summary(&claims, 3),
            "2 checked: 1 ≠ wrong, 1 = right; 3 not understood"
        );
        assert_eq!(summary(&[], 1), "no claim checked, 1 not understood");
        assert_eq!(short_counts(&claims), "1≠ 1=");
        assert_eq!(
            line(&claims[0], &theme).to_string(),
            "≠ 7: claimed behind, actual front (direction, step 3)"
        );
        // Where a line is broken, the row is that of the claim.
        reading.follow(document, &marks, 9, &theme);
        assert_eq!(row(&claims[0], &mut reading), Some(2));
        assert_eq!(
            short_line(&claims[0], &theme).to_string(),
            "≠ 7: behind, actual front"
        );
        // What is right says why where its words are others.
        let beside = CheckedClaim {
            is: "contact".into(),
            judgement: Judgement::Right,
            ..claims[0].clone()
        };
        assert_eq!(
            line(&beside, &theme).to_string(),
            "= 7: claimed behind, actual contact, its centre behind (direction, step 3)"
        );
        let told = CheckedClaim {
            basis: ClaimBasis::Paper,
            ..beside
        };
        assert_eq!(
            line(&told, &theme).to_string(),
            "= 7: claimed behind, actual contact, behind in the paper's convention (direction, step 3)"
        );
    }
}

//! Text with the claims in it marked: underlined, with a sign that says whether they hold.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};

use super::highlight::answer;
use crate::evaluation::claims::{Checked, Judgement};
use crate::tui::model::counted;
use crate::tui::theme::Theme;

/// The sign of a claim and its style.
fn sign(judgement: Judgement, theme: &Theme) -> (&'static str, Style) {
    match judgement {
        Judgement::Right => ("=", Style::new().fg(theme.safe)),
        Judgement::Wrong => {
            let style = Style::new().fg(theme.danger).add_modifier(Modifier::BOLD);
            ("≠", style)
        }
        Judgement::Unknown(_) => ("?", Style::new().fg(theme.warning)),
    }
}

/// A text that is safe to show, highlighted as Markdown and JSON, its claims marked; and the lines in which they begin.
#[must_use]
pub fn text(
    document: &str,
    claims: &[Checked],
    picked: Option<usize>,
    theme: &Theme,
) -> (Text<'static>, Vec<usize>) {
    let mut lines = Vec::new();
    let mut rows = vec![0; claims.len()];
    let mut start = 0;
    let plain = answer(document, theme);
    for (row, (line, source)) in plain
        .lines
        .into_iter()
        .zip(document.split('\n'))
        .enumerate()
    {
        let end = start + source.len();
        let here: Vec<(usize, &Checked)> = claims
            .iter()
            .enumerate()
            .filter(|(_, c)| c.claim.span.start >= start && c.claim.span.end <= end)
            .collect();
        for (place, _) in &here {
            rows[*place] = row;
        }
        lines.push(if here.is_empty() {
            line
        } else {
            marked(line, &here, start, picked, theme)
        });
        start = end + 1;
    }
    (
        Text {
            lines,
            ..plain_style(theme)
        },
        rows,
    )
}

fn plain_style(theme: &Theme) -> Text<'static> {
    Text::default().style(theme.base())
}

/// A line with its claims marked; `start` is where it begins in the text.
fn marked(
    line: Line<'static>,
    claims: &[(usize, &Checked)],
    start: usize,
    picked: Option<usize>,
    theme: &Theme,
) -> Line<'static> {
    let mut spans = Vec::new();
    let mut at = start;
    for span in line.spans {
        let text = span.content.as_ref();
        let end = at + text.len();
        let mut from = at;
        for (place, checked) in claims {
            let claim = &checked.claim.span;
            let (first, last) = (claim.start.max(from), claim.end.min(end));
            if first >= last {
                continue;
            }
            // Both ends are ends of characters, as the claim was found in this text.
            let (sign, style) = sign(checked.judgement, theme);
            let mut style = style.add_modifier(Modifier::UNDERLINED);
            if picked == Some(*place) {
                style = style.add_modifier(Modifier::REVERSED);
            }
            let piece =
                |a: usize, b: usize| text.get(a - at..b - at).unwrap_or_default().to_string();
            spans.push(Span::styled(piece(from, first), span.style));
            spans.push(Span::styled(piece(first, last), style));
            if last == claim.end {
                spans.push(Span::styled(
                    sign,
                    style.remove_modifier(Modifier::UNDERLINED),
                ));
            }
            from = last;
        }
        let rest = text.get(from - at..).unwrap_or_default().to_string();
        spans.push(Span::styled(rest, span.style));
        at = end;
    }
    spans.retain(|span| !span.content.is_empty());
    Line {
        spans,
        ..line_style(line.style)
    }
}

fn line_style(style: Style) -> Line<'static> {
    Line::default().style(style)
}

/// A claim beside the truth.
#[must_use]
pub fn line(checked: &Checked, theme: &Theme) -> Line<'static> {
    let (sign, style) = sign(checked.judgement, theme);
    Line::from(vec![
        Span::styled(format!("{sign} "), style),
        Span::styled(checked.line(), theme.base()),
    ])
}

/// How many claims there are, and how many hold.
#[must_use]
pub fn summary(claims: &[Checked]) -> String {
    let (right, wrong, unknown) = counted(claims);
    let word = if claims.len() == 1 { "claim" } else { "claims" };
    format!("{} {word}: {right} =, {wrong} ≠, {unknown} ?", claims.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::claims::{Basis, Claim, Quantity, Side, Stated};

    #[test]
    fn claims_are_marked_where_they_stand() {
        let document = "# ü head\n7 is behind the ego\n\nand 7 is left";
        let claim = |words: &str, judgement| {
            let from = document.find(words).unwrap_or_default();
            Checked {
                claim: Claim {
                    span: from..from + words.len(),
                    obstacle: 7,
                    named: true,
                    quantity: Quantity::Side,
                    stated: Stated::Side(Side {
                        front: Some(false),
                        left: None,
                    }),
                    step: None,
                },
                step: 3,
                truth: None,
                is: "front".into(),
                basis: Basis::Exact,
                judgement,
            }
        };
        let claims = [
            claim("behind", Judgement::Wrong),
            claim("left", Judgement::Right),
        ];
        let theme = Theme::default_theme();
        let (text, rows) = text(document, &claims, Some(1), &theme);
        assert_eq!(rows, [1, 3]);
        let shown: Vec<String> = text.lines.iter().map(ToString::to_string).collect();
        assert_eq!(
            shown,
            ["# ü head", "7 is behind≠ the ego", "", "and 7 is left="]
        );
        let picked = text.lines[3].spans.iter().find(|s| s.content == "left");
        assert!(picked.is_some_and(|s| s.style.add_modifier.contains(Modifier::REVERSED)));
        assert_eq!(summary(&claims), "2 claims: 1 =, 1 ≠, 0 ?");
        assert_eq!(
            line(&claims[0], &theme).to_string(),
            "≠ 7 says behind, is front (direction, step 3)"
        );
    }
}

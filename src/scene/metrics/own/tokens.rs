//! The words of a formula: numbers with their units, names, signs.

use std::ops::Range;

use super::unit::{Unit, is_of_name};

/// A word of a formula.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Token<'t> {
    /// A number, with a unit or bare.
    Number(f64, Option<Unit>),
    /// A name, of a measure, a state or a function.
    Name(&'t str),
    /// An operator, bracket or comma.
    Sign(&'static str),
    /// Behind the last one.
    End,
}

/// What is wrong with a formula, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormulaError {
    /// The bytes that are wrong.
    pub at: Range<usize>,
    /// What is wrong and what to do.
    pub words: String,
}

impl FormulaError {
    pub fn new(at: &Range<usize>, words: impl Into<String>) -> Self {
        Self {
            at: at.clone(),
            words: words.into(),
        }
    }
}

/// Longer signs first, so that `<=` is not read as `<`.
const SIGNS: [&str; 19] = [
    "&&", "||", "<=", ">=", "==", "!=", "<", ">", "!", "+", "-", "*", "/", "^", "?", ":", "(", ")",
    ",",
];

/// The words of a text with their places, [`Token::End`] last.
pub fn tokens(text: &str) -> Result<Vec<(Token<'_>, Range<usize>)>, FormulaError> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        let (token, length) = if first.is_whitespace() {
            at += first.len_utf8();
            continue;
        } else if first.is_ascii_digit() || first == '.' {
            number(rest).map_err(|(length, words)| FormulaError::new(&(at..at + length), words))?
        } else if first.is_ascii_alphabetic() || first == '_' {
            let length = rest.find(|c| !is_of_name(c)).unwrap_or(rest.len());
            (Token::Name(&rest[..length]), length)
        } else if let Some(sign) = SIGNS.iter().find(|sign| rest.starts_with(**sign)) {
            (Token::Sign(sign), sign.len())
        } else {
            let meant = match first {
                '=' => "; `==` compares",
                '&' => "; `&&` means and",
                '|' => "; `||` means or",
                _ => "; a formula has names, numbers, ( ) , + - * / ^ < <= > >= == != && || ! ? :",
            };
            let place = at..at + first.len_utf8();
            return Err(FormulaError::new(
                &place,
                format!("`{}` is not known{meant}", first.escape_debug()),
            ));
        };
        found.push((token, at..at + length));
        at += length;
    }
    found.push((Token::End, text.len()..text.len()));
    Ok(found)
}

/// The number that a text begins with, with the unit behind it, and its length; of what is no number, length and words.
fn number(text: &str) -> Result<(Token<'_>, usize), (usize, String)> {
    let digits = |from: usize| {
        let rest = &text[from..];
        from + rest
            .find(|c: char| !c.is_ascii_digit())
            .unwrap_or(rest.len())
    };
    let mut end = digits(0);
    if text[end..].starts_with('.') {
        end = digits(end + 1);
    }
    if text[end..].starts_with(['e', 'E']) {
        let sign = usize::from(text[end + 1..].starts_with(['+', '-']));
        let exponent = digits(end + 1 + sign);
        if exponent > end + 1 + sign {
            end = exponent;
        }
    }
    let value = text[..end]
        .parse::<f64>()
        .ok()
        .filter(|value| value.is_finite());
    let Some(value) = value else {
        return Err((
            end.max(1),
            "this is no number; write one such as 1.5 or 2e-3".into(),
        ));
    };
    let Some((unit, length)) = Unit::at_start_of(&text[end..]) else {
        return Ok((Token::Number(value, None), end));
    };
    Ok((Token::Number(value, Some(unit)), end + length))
}

//! Renders a template: its `system` and `user` blocks become the two messages, whose tokens are estimated.

use std::collections::BTreeMap;
use std::sync::Arc;

use minijinja::value::Serde;
use minijinja::{Environment, ErrorKind, Value};
use serde::Serialize;

use super::TemplateError;
use super::guard::{self, GuardError};
use super::template::{body_in_place, included};

/// The two messages of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Prompt {
    /// Who the model is and what it knows.
    pub system: String,
    /// What it is asked.
    pub user: String,
}

/// Why a template could not be rendered.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}: {message}", line.map(|l| format!(":{l}")).unwrap_or_default())]
pub struct RenderError {
    /// The template or fragment.
    pub file: String,
    /// Line in that file, from 1, where it is known.
    pub line: Option<usize>,
    /// What is wrong.
    pub message: String,
}

/// Whether a text can be understood as a template; its lines are those of the error.
pub(super) fn syntax(text: &str) -> Result<(), TemplateError> {
    let compiled = guard::on_own_stack(|| {
        let source = guard::guarded("", text)?;
        Environment::new().template_from_str(&source)?;
        Ok(())
    })
    .map_err(|error| no_thread("", &error))
    .and_then(|done| done.map_err(|fault| describe("", &fault)));
    compiled.map_err(|RenderError { line, message, .. }| TemplateError::Wrong {
        line: line.unwrap_or(1),
        message,
    })
}

fn no_thread(file: &str, error: &std::io::Error) -> RenderError {
    RenderError {
        file: file.to_string(),
        line: None,
        message: format!(
            "cannot start a thread: {}",
            nearmiss_base::system::error_text(error)
        ),
    }
}

/// Fills the template `source` (a whole file) with `values`; `fragments` can be included by name.
///
/// # Errors
/// Wrong syntax, an unknown variable, a missing block, more steps, text or nesting than the limits allow: with file
/// and line.
pub fn render(
    file: &str,
    source: &str,
    fragments: &BTreeMap<String, String>,
    values: impl Serialize,
) -> Result<Prompt, RenderError> {
    let values = Value::from(Serde(values));
    guard::on_own_stack(|| fill(file, source, fragments, values))
        .map_err(|error| no_thread(file, &error))?
}

fn fill(
    file: &str,
    source: &str,
    fragments: &BTreeMap<String, String>,
    values: Value,
) -> Result<Prompt, RenderError> {
    let budget = Arc::new(guard::Budget::with(&values));
    let mut environment = guard::environment(&budget);
    let fail = |error: minijinja::Error| describe(file, &GuardError::Engine(error));
    for name in included(source, fragments) {
        let text =
            guard::guarded(name, &fragments[name]).map_err(|fault| describe(name, &fault))?;
        environment.add_template_owned(name, text).map_err(fail)?;
    }
    let body = body_in_place(source);
    let body = guard::guarded(file, &body).map_err(|fault| describe(file, &fault))?;
    let template = environment
        .template_from_named_str(file, &body)
        .map_err(fail)?;
    let mut filled = template.render_captured(values).map_err(fail)?;
    let mut block = |name: &str| {
        let rendered = filled.with_state_mut(|state| state.render_block(name));
        rendered
            .map(|text| without_holes(&text))
            .map_err(|error| match error.kind() {
                ErrorKind::UnknownBlock => RenderError {
                    file: file.to_string(),
                    line: None,
                    message: format!("no `{{% block {name} %}}`"),
                },
                _ => fail(error),
            })
    };
    Ok(Prompt {
        system: block("system")?,
        user: block("user")?,
    })
}

/// One blank line where what was left out leaves several.
fn without_holes(text: &str) -> String {
    let mut whole = String::with_capacity(text.len());
    let mut blank = false;
    for line in text.trim().lines() {
        let empty = line.trim().is_empty();
        if !(empty && blank) {
            whole.push_str(line);
            whole.push('\n');
        }
        blank = empty;
    }
    whole.truncate(whole.trim_end().len());
    whole
}

fn describe(file: &str, fault: &GuardError) -> RenderError {
    let error = match fault {
        GuardError::Engine(error) => error,
        GuardError::At { line, message } => {
            return RenderError {
                file: file.to_string(),
                line: Some(*line),
                message: message.clone(),
            };
        }
    };
    let mut innermost = error;
    let mut source: Option<&dyn std::error::Error> = std::error::Error::source(error);
    while let Some(next) = source {
        if let Some(inner) = next.downcast_ref::<minijinja::Error>() {
            innermost = inner;
        }
        source = next.source();
    }
    RenderError {
        file: innermost.name().unwrap_or(file).to_string(),
        line: innermost.line(),
        message: engine_message(innermost),
    }
}

/// More of an engine's message is not shown: it may quote what the template made. Characters.
const MAX_MESSAGE_LENGTH: usize = 400;

fn engine_message(error: &minijinja::Error) -> String {
    let kind = error.kind();
    let whole = match error.detail() {
        _ if kind == ErrorKind::OutOfFuel => {
            let most = guard::MOST_STEPS;
            format!("{kind}: rendering exceeds the limit of {most} steps")
        }
        Some(detail) => format!("{kind}: {detail}"),
        None => kind.to_string(),
    };
    match whole.char_indices().nth(MAX_MESSAGE_LENGTH) {
        Some((end, _)) => format!("{}…", &whole[..end]),
        None => whole,
    }
}

/// Letters of one token: common words are whole tokens.
const WORD: usize = 12;

/// Digits of one token.
const DIGITS: usize = 3;

/// Signs of one token.
const SIGNS: usize = 3;

/// Roughly how many tokens a text is.
///
/// The text is cut as the tokenizers of OpenAI's models do it before they look words up: runs of letters, with the
/// blank before them, up to three digits, runs of other signs, other blanks. Numbers, of which descriptions are
/// full, are then counted as they are, where a token for every four characters would be half of the truth. Of
/// descriptions and prompts of this program in English the estimate is within 8 % of what `o200k_base` and
/// `cl100k_base` count; other texts and models differ more.
#[must_use]
pub fn estimate_tokens(text: &str) -> usize {
    let mut rest = text.chars().peekable();
    let mut tokens = 0;
    while let Some(c) = rest.next() {
        let kind = Kind::from_char(c);
        let mut length = 1;
        let mut lines = c == '\n';
        while let Some(next) = rest.next_if(|next| Kind::from_char(*next) == kind) {
            length += 1;
            lines |= next == '\n';
        }
        tokens += match kind {
            Kind::Letters => usize::div_ceil(length, WORD),
            Kind::Digits => usize::div_ceil(length, DIGITS),
            Kind::Signs => usize::div_ceil(length, SIGNS),
            Kind::Blank => {
                let joins = rest
                    .peek()
                    .is_some_and(|next| Kind::from_char(*next) != Kind::Digits);
                usize::from(lines || length > 1 || !joins)
            }
        };
    }
    tokens
}

#[derive(PartialEq, Eq, Clone, Copy)]
enum Kind {
    Letters,
    Digits,
    Signs,
    Blank,
}

impl Kind {
    fn from_char(c: char) -> Self {
        if c.is_alphabetic() {
            Self::Letters
        } else if c.is_numeric() {
            Self::Digits
        } else if c.is_whitespace() {
            Self::Blank
        } else {
            Self::Signs
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn fill(source: &str) -> Result<Prompt, RenderError> {
        let fragments = BTreeMap::from([("_f.md".to_string(), "fragment {{ x }}".to_string())]);
        render("t.md", source, &fragments, BTreeMap::from([("x", "<1>")]))
    }

    #[test]
    fn blocks_become_messages() {
        let prompt = fill("+++\n+++\n{% block system %}a {% include \"_f.md\" %}{% endblock %}\n{% block user %} {{ x }} {% endblock %}").unwrap();
        assert_eq!(
            (prompt.system.as_str(), prompt.user.as_str()),
            ("a fragment <1>", "<1>")
        );
    }

    #[test]
    fn errors_name_the_line_of_the_file() {
        let error = fill("+++\nname = 1\n+++\n{% block system %}{% endblock %}\n{{ nothing }}")
            .unwrap_err();
        assert_eq!(
            (error.file.as_str(), error.line),
            ("t.md", Some(5)),
            "{error}"
        );
        let error = fill("+++\n+++\n{% block system %}").unwrap_err();
        assert!(error.line.is_some(), "{error}");
        // Not where the parser fails, but where it was opened.
        let error =
            fill("+++\n+++\n{% block system %}{{ a }}{{ foo\n\n{% include 'x' %}\n{% endblock %}")
                .unwrap_err();
        assert_eq!(error.to_string(), "t.md:3: syntax error: `{{` without `}}`");
        let error = fill("+++\n+++\n{% block system %}a{% endblock %}").unwrap_err();
        assert!(error.message.contains("user"), "{error}");
    }

    #[test]
    fn a_template_without_end_is_stopped() {
        let endless = |body: &str| {
            fill(&format!(
                "+++\n+++\n{{% block system %}}{{% for a in range(9999) %}}{{% for b in range(9999) %}}{body}\
                 {{% endfor %}}{{% endfor %}}{{% endblock %}}{{% block user %}}{{% endblock %}}"
            ))
            .unwrap_err()
        };
        let error = endless("{{ a }}");
        assert!(error.message.contains("the limit"), "{error}");
        // Many steps that make nothing.
        let error = endless(&"{% if a %}{% endif %}".repeat(50));
        assert!(error.message.contains("fuel"), "{error}");
        assert!(error.message.contains("the limit"), "{error}");
        assert_eq!(error.line, Some(3));
    }

    #[test]
    fn a_fragment_that_is_not_named_cannot_be_included() {
        let error =
            fill("+++\n+++\n{% block system %}{% include \"_\" ~ \"f.md\" %}{% endblock %}")
                .unwrap_err();
        assert!(error.message.contains("_f.md"), "{error}");
    }

    /// Text and what `o200k_base` counts.
    const COUNTED: &[(&str, usize)] = &[
        ("", 0),
        ("Did the ego collide in this scene?", 8),
        (
            "80,8.00,car 301,102,-,-,Front,5.48,0.00,0.53,0.33,-0.47,0.00\n",
            41,
        ),
        (
            "  car 301: at (950.09, 613.46) m, heading 2.577 rad, velocity 28.50 m/s, acceleration 0.00 m/s², \
             on lanelet 102\n",
            48,
        ),
        (
            "A gap of 0 means that the bodies overlap in that direction; where they touch the direction reads Contact.",
            21,
        ),
    ];

    #[test]
    fn near_what_a_tokenizer_counts() {
        for (text, counted) in COUNTED {
            let off = estimate_tokens(text).abs_diff(*counted) as f64;
            assert!(
                off <= 1.0_f64.max(0.1 * *counted as f64),
                "{} instead of {counted}: {text}",
                estimate_tokens(text)
            );
        }
    }
}

//! Limits on what a template may use: source, nesting, steps, and the text and values made while rendering.
//!
//! The engine bounds steps and recursion, but a single step can make any amount of text, and nested values can overflow
//! the stack. So a template is checked before it is parsed ([`self`]), and rewritten so that every operation that
//! makes or walks a value is charged first ([`rewrite`]); the engine's own filters are replaced by ones that are
//! charged too ([`filters`]). Each rendering has one [`Budget`].

mod budget;
mod expressions;
mod filters;
mod rewrite;

use std::sync::Arc;

use minijinja::machinery::{Token, ast, parse, tokenize};
use minijinja::syntax::SyntaxConfig;
use minijinja::{AutoEscape, Environment, Error, UndefinedBehavior};

use rewrite::rewrite;

pub use budget::Budget;

/// A template that takes more steps than this to be filled would not end.
pub const MOST_STEPS: u64 = 1_000_000;

/// Larger sources are not parsed, bytes.
pub const MAX_SOURCE_BYTES: usize = 1 << 20;

/// What a filling may make besides a few copies of what it is given, bytes.
pub const MAX_MADE_BYTES: u64 = 16 << 20;

/// Lists in lists, at most so deep.
pub const DEEPEST: usize = 160;

/// Operators and filters one after the other in an expression, `elif` in a row.
pub const MAX_CHAIN_LENGTH: usize = 1_000;

/// The stack for parsing and filling: [`MAX_CHAIN_LENGTH`] and the engine's own limits on recursion fit many times.
const STACK: usize = 64 << 20;

/// Runs `work` on a stack that is large enough for whatever the limits allow.
///
/// # Errors
/// The system gives no thread.
pub fn on_own_stack<T: Send>(work: impl FnOnce() -> T + Send) -> std::io::Result<T> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new()
            .name("template".into())
            .stack_size(STACK)
            .spawn_scoped(scope, work)?;
        // A panic continues on the calling thread.
        Ok(thread
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}

/// Why a template is not rendered.
#[derive(Debug)]
pub enum GuardError {
    /// It exceeds a limit before it is parsed, or does not close what it opens.
    At {
        /// Line in the source, from 1.
        line: usize,
        /// Which limit, or what is not closed.
        message: String,
    },
    /// The engine refuses it.
    Engine(Error),
}

impl From<Error> for GuardError {
    fn from(error: Error) -> Self {
        Self::Engine(error)
    }
}

/// Parses a template and gives it back with every operation paid for.
///
/// # Errors
/// It is too large or too deep, or its syntax is wrong, with the line.
pub fn guarded(name: &str, source: &str) -> Result<String, GuardError> {
    check(source)?;
    let tree: ast::Stmt<'_> = parse(source, name, SyntaxConfig::default())
        .map_err(|error| unclosed(source, error.line()).unwrap_or(error.into()))?;
    Ok(rewrite(source, &tree))
}

/// The `{{` or `{%` that is open at a line where the parser failed, if it is not closed before the next one: the parser
/// only stumbles over what follows, which may be far below.
fn unclosed(source: &str, failed: Option<usize>) -> Option<GuardError> {
    let failed = failed?;
    let mut open = None;
    for (token, span) in tokenize(source, false, SyntaxConfig::default()).map_while(Result::ok) {
        let line = usize::from(span.start_line);
        match token {
            Token::VariableStart | Token::BlockStart if line <= failed => {
                let signs = match token {
                    Token::VariableStart => ("{{", "}}"),
                    _ => ("{%", "%}"),
                };
                open = Some((line, usize::try_from(span.end_offset).ok()?, signs));
            }
            Token::VariableEnd | Token::BlockEnd if line < failed => open = None,
            _ if line >= failed => break,
            _ => {}
        }
    }
    let (line, begin, (opening, closing)) = open?;
    let rest = source.get(begin..)?;
    let end = rest.find(closing);
    let inside = &rest[..end.unwrap_or(rest.len())];
    let opened_again = ["{{", "{%", "{#"].iter().any(|sign| inside.contains(sign));
    (end.is_none() || opened_again).then(|| GuardError::At {
        line,
        message: format!("syntax error: `{opening}` without `{closing}`"),
    })
}

/// An environment for rewritten templates whose filters, tests and functions pay out of `budget`.
pub fn environment<'source>(budget: &Arc<Budget>) -> Environment<'source> {
    let mut environment = Environment::new();
    // The rewriting keeps every character of the text.
    let syntax = SyntaxConfig::builder().keep_trailing_newline(true).build();
    if let Ok(syntax) = syntax {
        environment.set_syntax(syntax);
    }
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    // Prompts are Markdown, never HTML.
    environment.set_auto_escape_callback(|_| AutoEscape::None);
    environment.set_fuel(Some(MOST_STEPS));
    filters::replace(&mut environment, budget);
    filters::add(&mut environment, budget);
    let paying = budget.clone();
    environment.set_formatter(move |out, state, value| {
        let times = if matches!(state.auto_escape(), AutoEscape::None) {
            1
        } else {
            filters::ESCAPED
        };
        paying.printed(value, times)?;
        minijinja::escape_formatter(out, state, value)
    });
    environment
}

/// Whether a source is small enough, and its chains short enough.
///
/// # Errors
/// It is not: with the line. What the lexer refuses is left to the parser.
fn check(source: &str) -> Result<(), GuardError> {
    let limit = |line, message: String| Err(GuardError::At { line, message });
    if source.len() > MAX_SOURCE_BYTES {
        let most = MAX_SOURCE_BYTES >> 10;
        return limit(1, format!("larger than the limit of {most} KiB"));
    }
    let mut chains = Chains::default();
    let mut elifs = 0_usize;
    let mut opens = false;
    for token in tokenize(source, false, SyntaxConfig::default()) {
        let Ok((token, span)) = token else {
            return Ok(());
        };
        elifs += usize::from(opens && matches!(token, Token::Ident("elif")));
        opens = matches!(token, Token::BlockStart);
        chains.meet(&token);
        let what = if chains.longest > MAX_CHAIN_LENGTH {
            "an expression exceeds the limit of 1000 parts; split it with `set`"
        } else if elifs > MAX_CHAIN_LENGTH {
            "more than the limit of 1000 `elif`"
        } else {
            continue;
        };
        return limit(usize::from(span.start_line), what.to_string());
    }
    Ok(())
}

/// How many tokens follow each other without a comma, in every bracket that is open and over all of them.
#[derive(Default)]
struct Chains {
    open: Vec<usize>,
    now: usize,
    before: usize,
    longest: usize,
}

impl Chains {
    fn meet(&mut self, token: &Token<'_>) {
        match token {
            Token::TemplateData(_) | Token::VariableStart | Token::BlockStart => {
                *self = Self {
                    longest: self.longest,
                    ..Self::default()
                };
            }
            Token::BracketOpen | Token::ParenOpen | Token::BraceOpen => {
                self.before += self.now + 1;
                self.open.push(self.now + 1);
                self.now = 0;
            }
            Token::BracketClose | Token::ParenClose | Token::BraceClose => {
                self.now = self.open.pop().unwrap_or_default();
                self.before = self.before.saturating_sub(self.now);
            }
            Token::Comma => self.now = 0,
            _ => self.now += 1,
        }
        self.longest = self.longest.max(self.before + self.now);
    }
}

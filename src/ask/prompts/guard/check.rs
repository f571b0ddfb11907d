//! Checks before parsing: the parser follows operator chains and `elif` on its own stack.

use minijinja::machinery::{Token, tokenize};
use minijinja::syntax::SyntaxConfig;

use super::{GuardError, LARGEST_SOURCE, LONGEST_CHAIN};

/// Whether a source is small enough, and its chains short enough.
///
/// # Errors
/// It is not: with the line. What the lexer refuses is left to the parser.
pub fn check(source: &str) -> Result<(), GuardError> {
    let limit = |line, message: String| Err(GuardError::Limit { line, message });
    if source.len() > LARGEST_SOURCE {
        let most = LARGEST_SOURCE >> 10;
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
        let what = if chains.longest > LONGEST_CHAIN {
            "an expression exceeds the limit of 1000 parts; split it with `set`"
        } else if elifs > LONGEST_CHAIN {
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

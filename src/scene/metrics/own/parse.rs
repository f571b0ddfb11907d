//! Reads a formula, by the precedence of its operators; units are worked out on the way, so that they agree or the place
//! where they do not is known.

use std::ops::Range;

use super::formula::{Condition, Facts, Formula, Number, Operand};
use super::tokens::{FormulaError, Token, tokens};
use super::unit::Unit;

/// Longest formula, bytes.
const LONGEST: usize = 500;

/// Most parts of a formula, those of the measures in it counted too.
const LARGEST: usize = 1000;

/// No formula is nested deeper.
const DEEPEST: usize = 24;

/// Highest power.
const HIGHEST: f64 = 9.0;

/// Functions of formulas.
pub const FUNCTIONS: [&str; 6] = ["min", "max", "abs", "sqrt", "exp", "log"];

/// Says what a name stands for.
pub type Names<'n> = dyn FnMut(&str) -> Result<Operand, String> + 'n;

/// Reads a formula whose names mean what `names` says.
///
/// # Errors
/// It is no formula, or its units do not agree: where, and what to do.
pub fn parse(text: &str, names: &mut Names<'_>) -> Result<Formula, FormulaError> {
    if text.len() > LONGEST {
        let words = format!("more than {LONGEST} bytes; give a part of it a measure of its own");
        return Err(FormulaError::new(&(LONGEST..LONGEST), words));
    }
    let mut parser = Parser {
        text,
        tokens: tokens(text)?,
        place: 0,
        depth: 0,
        facts: Facts {
            reads_ahead: false,
            of_places: true,
            size: 0,
        },
        names,
    };
    let whole = parser.expression(0)?;
    if parser.peek() != Token::End {
        return Err(parser.wrong("expected an operator such as + or <, or the end"));
    }
    let (root, unit) = parser.number(whole)?;
    Ok(Formula {
        text: text.split_whitespace().collect::<Vec<_>>().join(" "),
        root,
        unit,
        facts: parser.facts,
    })
}

struct Parser<'t, 'n> {
    text: &'t str,
    tokens: Vec<(Token<'t>, Range<usize>)>,
    place: usize,
    /// Expressions that are open.
    depth: usize,
    facts: Facts,
    names: &'n mut Names<'n>,
}

/// A part of a formula and where it stands.
struct Part {
    what: What,
    at: Range<usize>,
}

enum What {
    /// A number and its unit; bare numbers have none, and take that of the other side.
    Number(Number, Option<Unit>),
    Condition(Condition),
}

/// The sides of an operator.
type Numbers = Box<(Number, Number)>;

/// How strongly an operator binds what is on its left: the higher, the stronger.
fn strength(sign: &str) -> Option<u8> {
    Some(match sign {
        "?" => 1,
        "||" => 2,
        "&&" => 3,
        "<" | "<=" | ">" | ">=" | "==" | "!=" => 4,
        "+" | "-" => 5,
        "*" | "/" => 6,
        "^" => OF_POWERS,
        _ => return None,
    })
}

/// Binds stronger than a sign in front: -x^2 is -(x^2).
const OF_POWERS: u8 = 8;
const OF_SIGNS: u8 = 7;

impl Parser<'_, '_> {
    fn peek(&self) -> Token<'_> {
        self.tokens[self.place].0
    }

    fn at(&self) -> Range<usize> {
        self.tokens[self.place].1.clone()
    }

    /// Goes on to the next word; the end stays.
    fn advance(&mut self) {
        self.place = (self.place + 1).min(self.tokens.len() - 1);
    }

    /// Takes a sign if it is the next word.
    fn takes(&mut self, sign: &str) -> bool {
        let is_it = matches!(self.peek(), Token::Sign(found) if found == sign);
        if is_it {
            self.advance();
        }
        is_it
    }

    fn expect(&mut self, sign: &str) -> Result<(), FormulaError> {
        if self.takes(sign) {
            return Ok(());
        }
        Err(self.wrong(&format!("expected `{sign}`")))
    }

    /// An error at the next word.
    fn wrong(&self, expected: &str) -> FormulaError {
        let found = match self.peek() {
            Token::End => String::new(),
            _ => format!(", not `{}`", &self.text[self.at()]),
        };
        FormulaError::new(&self.at(), format!("{expected}{found}"))
    }

    fn grow(&mut self, at: &Range<usize>, size: usize) -> Result<(), FormulaError> {
        self.facts.size = self.facts.size.saturating_add(size);
        if self.facts.size <= LARGEST {
            return Ok(());
        }
        let words = format!(
            "more than {LARGEST} parts, those of the measures in it counted each time; simplify it"
        );
        Err(FormulaError::new(at, words))
    }

    fn expression(&mut self, least: u8) -> Result<Part, FormulaError> {
        // Measures that use each other nest, too, and no stack holds them all.
        self.depth += 1;
        if self.depth > DEEPEST {
            let words = format!("more than {DEEPEST} brackets and operators deep; simplify it");
            return Err(FormulaError::new(&self.at(), words));
        }
        let mut left = self.first()?;
        while let Token::Sign(sign) = self.tokens[self.place].0 {
            let Some(strength) = strength(sign).filter(|strength| *strength >= least) else {
                break;
            };
            let at = self.at();
            self.grow(&at, 1)?;
            self.advance();
            left = match sign {
                "?" => self.choice(left)?,
                "^" => self.raised(left)?,
                _ => {
                    let right = self.expression(strength + 1)?;
                    self.joined(sign, left, right)?
                }
            };
        }
        self.depth -= 1;
        Ok(left)
    }

    /// What stands in front of an operator.
    fn first(&mut self) -> Result<Part, FormulaError> {
        let at = self.at();
        self.grow(&at, 1)?;
        match self.tokens[self.place].0 {
            Token::Number(value, unit) => {
                self.advance();
                Ok(Part {
                    what: What::Number(Number::Literal(value), unit),
                    at,
                })
            }
            Token::Name(name) => {
                self.advance();
                if FUNCTIONS.contains(&name) {
                    return self.function(name, at);
                }
                let operand = (self.names)(name).map_err(|words| FormulaError::new(&at, words))?;
                let facts = operand.facts();
                self.facts.reads_ahead |= facts.reads_ahead;
                self.facts.of_places &= facts.of_places;
                self.grow(&at, facts.size)?;
                let unit = operand.unit();
                Ok(Part {
                    what: What::Number(Number::Of(operand), unit),
                    at,
                })
            }
            Token::Sign("(") => {
                self.advance();
                let inner = self.expression(0)?;
                let end = self.at().end;
                self.expect(")")?;
                Ok(Part {
                    at: at.start..end,
                    ..inner
                })
            }
            Token::Sign(sign @ ("-" | "+")) => {
                self.advance();
                let part = self.expression(OF_SIGNS)?;
                let whole = at.start..part.at.end;
                let (number, unit) = self.number(part)?;
                let signed = if sign == "-" {
                    Number::One(std::ops::Neg::neg, Box::new(number))
                } else {
                    number
                };
                Ok(Part {
                    what: What::Number(signed, unit),
                    at: whole,
                })
            }
            Token::Sign("!") => {
                self.advance();
                let part = self.expression(OF_SIGNS)?;
                let whole = at.start..part.at.end;
                let condition = self.condition(part)?;
                Ok(Part {
                    what: What::Condition(Condition::Not(Box::new(condition))),
                    at: whole,
                })
            }
            _ => Err(self.wrong("expected a number, a measure, a state or a function")),
        }
    }

    /// The part as a number with its unit.
    fn number(&self, part: Part) -> Result<(Number, Option<Unit>), FormulaError> {
        match part.what {
            What::Number(number, unit) => Ok((number, unit)),
            What::Condition(_) => Err(FormulaError::new(
                &part.at,
                "this holds or not and is no number; make one of it by `… ? 1 : 0`, or join comparisons with &&",
            )),
        }
    }

    /// The part as a condition.
    fn condition(&self, part: Part) -> Result<Condition, FormulaError> {
        match part.what {
            What::Condition(condition) => Ok(condition),
            What::Number(..) => Err(FormulaError::new(
                &part.at,
                format!(
                    "this is a number; compare it, such as `{} > 0`",
                    &self.text[part.at.clone()]
                ),
            )),
        }
    }

    /// Two numbers of one unit, and the unit; a bare one takes that of the other.
    fn alike(
        &self,
        left: Part,
        right: Part,
        what: &str,
    ) -> Result<(Numbers, Option<Unit>), FormulaError> {
        let words = [&left, &right].map(|part| self.text[part.at.clone()].to_string());
        let whole = left.at.start..right.at.end;
        let (left, of_left) = self.number(left)?;
        let (right, of_right) = self.number(right)?;
        if let (Some(a), Some(b)) = (of_left, of_right)
            && a != b
        {
            let [left, right] = words;
            let said = format!(
                "{what} needs one unit, but `{left}` has {} and `{right}` {}; multiply or divide to bring them to one",
                a.words(),
                b.words()
            );
            return Err(FormulaError::new(&whole, said));
        }
        Ok((Box::new((left, right)), of_left.or(of_right)))
    }

    fn joined(&self, sign: &str, left: Part, right: Part) -> Result<Part, FormulaError> {
        let at = left.at.start..right.at.end;
        let what = match sign {
            "&&" | "||" => {
                let both = Box::new((self.condition(left)?, self.condition(right)?));
                What::Condition(if sign == "&&" {
                    Condition::Both(both)
                } else {
                    Condition::Either(both)
                })
            }
            "+" | "-" => {
                let what = if sign == "+" { "a sum" } else { "a difference" };
                let (both, unit) = self.alike(left, right, what)?;
                let of = if sign == "+" {
                    std::ops::Add::add
                } else {
                    std::ops::Sub::sub
                };
                What::Number(Number::Two(of, both), unit)
            }
            "*" | "/" => {
                let ((left, a), (right, b)) = (self.number(left)?, self.number(right)?);
                let unit = match (a, b) {
                    (None, None) => None,
                    _ => {
                        let power = if sign == "*" { 1 } else { -1 };
                        Some(
                            a.unwrap_or_default()
                                .times(b.unwrap_or_default().power(power)),
                        )
                    }
                };
                let of = if sign == "*" {
                    std::ops::Mul::mul
                } else {
                    std::ops::Div::div
                };
                What::Number(Number::Two(of, Box::new((left, right))), unit)
            }
            _ => {
                let (both, _) = self.alike(left, right, "a comparison")?;
                let holds: fn(&f64, &f64) -> bool = match sign {
                    "<" => f64::lt,
                    "<=" => f64::le,
                    ">" => f64::gt,
                    ">=" => f64::ge,
                    "==" => f64::eq,
                    _ => f64::ne,
                };
                What::Condition(Condition::Compared(holds, both))
            }
        };
        Ok(Part { what, at })
    }

    /// What is behind `?`.
    fn choice(&mut self, condition: Part) -> Result<Part, FormulaError> {
        let start = condition.at.start;
        let condition = self.condition(condition)?;
        let then = self.expression(0)?;
        self.expect(":")?;
        let otherwise = self.expression(0)?;
        let at = start..otherwise.at.end;
        let (both, unit) = self.alike(then, otherwise, "a choice")?;
        let (then, otherwise) = *both;
        Ok(Part {
            what: What::Number(Number::Choice(Box::new((condition, then, otherwise))), unit),
            at,
        })
    }

    /// What is behind `^`.
    fn raised(&mut self, base: Part) -> Result<Part, FormulaError> {
        let is_below_one = self.takes("-");
        let at = self.at();
        let whole = |power: &f64| power.fract() == 0.0 && *power <= HIGHEST;
        let power = match self.peek() {
            Token::Number(power, None) => Some(power).filter(whole),
            _ => None,
        };
        let Some(power) = power else {
            let words = self.wrong("a power must be a whole number up to 9").words;
            return Err(FormulaError::new(
                &at,
                format!("{words}; sqrt() gives the root"),
            ));
        };
        self.advance();
        let power = if is_below_one {
            -(power as i32)
        } else {
            power as i32
        };
        let whole = base.at.start..at.end;
        let (number, unit) = self.number(base)?;
        Ok(Part {
            what: What::Number(
                Number::Power(Box::new(number), power),
                unit.map(|unit| unit.power(power)),
            ),
            at: whole,
        })
    }

    /// The arguments of a function and what it makes of them.
    fn function(&mut self, name: &str, at: Range<usize>) -> Result<Part, FormulaError> {
        self.expect("(")?;
        let mut result = self.expression(0)?;
        let mut count = 1;
        while matches!(name, "min" | "max") && self.takes(",") {
            let next = self.expression(0)?;
            let whole = result.at.start..next.at.end;
            let (both, unit) = self.alike(result, next, name)?;
            let of = if name == "min" { f64::min } else { f64::max };
            result = Part {
                what: What::Number(Number::Two(of, both), unit),
                at: whole,
            };
            count += 1;
        }
        if matches!(name, "min" | "max") && count == 1 {
            return Err(self.wrong(&format!("{name} takes two numbers or more: expected `,`")));
        }
        let whole = at.start..self.at().end;
        self.expect(")")?;
        let inner = result.at.clone();
        let (number, unit) = self.number(result)?;
        let (of, unit): (fn(f64) -> f64, _) = match (name, unit) {
            ("min" | "max", _) => {
                return Ok(Part {
                    what: What::Number(number, unit),
                    at: whole,
                });
            }
            ("abs", _) => (f64::abs, unit),
            ("sqrt", None) => (f64::sqrt, None),
            ("sqrt", Some(squared)) => {
                let words = || {
                    format!(
                        "{} has no square root; multiply or divide first",
                        squared.words()
                    )
                };
                (
                    f64::sqrt,
                    Some(
                        squared
                            .root()
                            .ok_or_else(|| FormulaError::new(&inner, words()))?,
                    ),
                )
            }
            (_, Some(unit)) if !unit.is_none() => {
                let words = format!(
                    "{name} takes a number without unit, not one in {unit}; divide by a reference, such as 1 {unit}"
                );
                return Err(FormulaError::new(&inner, words));
            }
            ("exp", _) => (f64::exp, unit),
            _ => (f64::ln, unit),
        };
        Ok(Part {
            what: What::Number(Number::One(of, Box::new(number)), unit),
            at: whole,
        })
    }
}

//! Bounds on how much larger than its arguments a filter's result can be.

use std::fmt::Write;

use minijinja::value::ValueKind;
use minijinja::{Error, Value};

use super::budget::Budget;

/// How much longer text becomes when it is escaped: `&quot;` and `\u{1f}` for one character.
pub const ESCAPED: u64 = 8;

/// Size of a filter's result, by the size of its arguments.
#[derive(Clone, Copy)]
pub enum Growth {
    /// As much at most.
    Same,
    /// So many times as much, in size or in work.
    Times(u64),
    /// An item for each character of a text.
    Characters,
    /// The first number in the arguments says how many spaces stand before each line.
    Indent,
    /// Numbers in the text or the arguments say how wide it becomes.
    Format,
    /// The third argument for each time that the second is in the first.
    Replace,
    /// The second argument between all items.
    Join,
    /// The numbers in the arguments say how many items are added.
    Count,
    /// A part for each separator.
    Parts,
    /// All items added up, one to the other.
    Sum,
}

impl Growth {
    /// Pays for what a filter will make of these arguments, before it does.
    pub fn pay(self, budget: &Budget, arguments: &[Value]) -> Result<(), Error> {
        let times = match self {
            Self::Times(times) => times,
            _ => 1,
        };
        budget.pay(128)?;
        for argument in arguments {
            budget.weigh(argument, times)?;
        }
        let Some(first) = arguments.first() else {
            return Ok(());
        };
        let text = first.as_str();
        match self {
            Self::Same | Self::Times(_) => Ok(()),
            Self::Characters => budget.pay(48 * text.map_or(0, str::len) as u64),
            Self::Indent => {
                let lines = text.map_or(1, |text| 2 + text.matches('\n').count());
                budget.pay(numbers(arguments).saturating_mul(lines as u64))
            }
            Self::Format => {
                let written = text.map_or(0, digits);
                let conversions = text.map_or(0, |text| text.matches('%').count()) as u64;
                // A star takes its width from the arguments.
                let given = numbers(arguments).saturating_mul(stars(text));
                // Numbers can have as many digits as that without any width.
                let plain = conversions.saturating_mul(400);
                budget.pay(written.saturating_add(given).saturating_add(plain))?;
                arguments.iter().skip(1).try_for_each(|argument| {
                    budget
                        .text_of(|out| write!(out, "{argument:?}"), 2)
                        .map(|_| ())
                })
            }
            Self::Replace => {
                let [_, from, to, ..] = arguments else {
                    return Ok(());
                };
                let shown = |value: &Value| budget.text_of(|out| write!(out, "{value}"), 1);
                let (text, from, to) = (shown(first)?, shown(from)?, shown(to)?);
                let found = text.matches(from.as_str()).count() as u64;
                budget.pay(found.saturating_mul(to.len() as u64 * ESCAPED))
            }
            Self::Join => {
                let count = first.len().unwrap_or(0) as u64;
                let between = arguments.iter().skip(1);
                let between: u64 = between.map(longest).sum();
                budget.pay(count.saturating_mul(between))?;
                budget.text_of(|out| write!(out, "{first}"), 1).map(|_| ())
            }
            Self::Count => {
                budget.pay(48 * text.map_or(0, str::len) as u64)?;
                budget.pay(numbers(arguments).saturating_mul(64))?;
                // The filler is in each of them.
                let filler: u64 = arguments.iter().skip(1).map(longest).sum();
                budget.pay(numbers(arguments).saturating_mul(filler))
            }
            Self::Parts => {
                let Some(text) = text else { return Ok(()) };
                let parts = match arguments.get(1).and_then(Value::as_str) {
                    Some("") => text.len(),
                    Some(separator) => text.matches(separator).count(),
                    None => text.matches(char::is_whitespace).count(),
                };
                budget.pay(64 * parts as u64)
            }
            Self::Sum => {
                budget.pay(48 * text.map_or(0, str::len) as u64)?;
                let (mut sized, mut copied) = (0_u64, 0_u64);
                for item in first.try_iter()? {
                    // Every addition copies what was added up before.
                    if item.kind() != ValueKind::Number {
                        sized = sized.saturating_add(longest(&item));
                        copied = copied.saturating_add(sized);
                    }
                }
                budget.pay(copied)
            }
        }
    }
}

/// Whole numbers in the arguments after the first, also named ones.
fn numbers(arguments: &[Value]) -> u64 {
    let of = |value: &Value| -> u64 {
        let number = i128::try_from(value.clone())
            .ok()
            .filter(|_| value.is_number());
        number.map_or(0, |n| u64::try_from(n.unsigned_abs()).unwrap_or(u64::MAX))
    };
    let mut all = 0_u64;
    for argument in arguments.iter().skip(1) {
        all = all.saturating_add(of(argument));
        if argument.kind() == ValueKind::Map {
            let keys = argument.try_iter().into_iter().flatten();
            let named = keys.filter_map(|key| argument.get_item(&key).ok());
            all = named.fold(all, |all, value| all.saturating_add(of(&value)));
        }
    }
    all
}

/// The numbers that are written in a text, added up.
fn digits(text: &str) -> u64 {
    let numbers = text.split(|c: char| !c.is_ascii_digit());
    numbers.filter(|n| !n.is_empty()).fold(0, |all, number| {
        all.saturating_add(number.parse().unwrap_or(u64::MAX))
    })
}

fn stars(text: Option<&str>) -> u64 {
    text.map_or(0, |text| text.matches('*').count()) as u64
}

/// How long a value is at least when it is written out: text, or the texts and numbers in it.
fn longest(value: &Value) -> u64 {
    match value.kind() {
        ValueKind::String => value.as_str().map_or(0, str::len) as u64,
        ValueKind::Seq | ValueKind::Iterable => {
            let items = value.try_iter().into_iter().flatten();
            items.map(|item| 24 + longest(&item)).sum()
        }
        ValueKind::Map => {
            let keys = value.try_iter().into_iter().flatten();
            keys.map(|key| 64 + longest(&key) + value.get_item(&key).map_or(0, |v| longest(&v)))
                .sum()
        }
        _ => 24,
    }
}

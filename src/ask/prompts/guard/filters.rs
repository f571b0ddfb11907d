//! The engine's filters, tests, functions and operators, each charged to the budget before it allocates.
//!
//! Filters called by the rewritten source that charge for an operation, under names no template would use.

use std::fmt::Write;
use std::sync::Arc;

use minijinja::value::{Rest, Tuple, ValueKind, ValueOrKwargs};
use minijinja::{Environment, Error, ErrorKind, State, Value, filters as f, functions, tests as t};

use super::budget::{Budget, refused};

/// How often a value is looked at where it is put in order: more than the logarithm of any length.
const SORTED: Growth = Growth::Times(16);

/// How much longer text becomes in the other case: `ŉ` becomes `ʼN`, `ﬃ` becomes `FFI`.
const CASED: Growth = Growth::Times(3);

/// Name, what it does, and what it makes.
fn all() -> Vec<(&'static str, Value, Growth)> {
    use Growth::{Characters, Count, Format, Indent, Join, Parts, Replace, Same, Sum, Times};
    let of = Value::from_function::<fn(&Value) -> Result<usize, Error>, _, _>;
    vec![
        ("safe", Value::from_function(f::safe), Same),
        ("escape", Value::from_function(f::escape), Times(ESCAPED)),
        ("e", Value::from_function(f::escape), Times(ESCAPED)),
        ("lower", Value::from_function(f::lower), CASED),
        ("upper", Value::from_function(f::upper), CASED),
        ("title", Value::from_function(f::title), CASED),
        ("capitalize", Value::from_function(f::capitalize), CASED),
        ("replace", Value::from_function(f::replace), Replace),
        ("length", of(f::length), Same),
        ("count", of(f::length), Same),
        ("dictsort", Value::from_function(f::dictsort), SORTED),
        ("items", Value::from_function(f::items), Same),
        ("reverse", Value::from_function(f::reverse), Same),
        ("trim", Value::from_function(f::trim), Same),
        ("join", Value::from_function(f::join), Join),
        ("split", Value::from_function(f::split), Parts),
        ("lines", Value::from_function(f::lines), Parts),
        ("default", Value::from_function(f::default), Same),
        ("d", Value::from_function(f::default), Same),
        ("round", Value::from_function(f::round), Same),
        ("abs", Value::from_function(f::abs), Same),
        ("int", Value::from_function(f::int), Same),
        ("float", Value::from_function(f::float), Same),
        ("attr", Value::from_function(f::attr), Same),
        ("first", Value::from_function(f::first), Same),
        ("last", Value::from_function(f::last), Same),
        ("min", Value::from_function(f::min), Characters),
        ("max", Value::from_function(f::max), Characters),
        ("sort", Value::from_function(f::sort), SORTED),
        ("list", Value::from_function(f::list), Characters),
        ("string", Value::from_function(f::string), Same),
        ("bool", Value::from_function(f::bool), Same),
        ("batch", Value::from_function(f::batch), Count),
        ("slice", Value::from_function(f::slice), Count),
        ("sum", Value::from_function(f::sum), Sum),
        ("indent", Value::from_function(f::indent), Indent),
        ("select", Value::from_function(f::select), Characters),
        ("reject", Value::from_function(f::reject), Characters),
        (
            "selectattr",
            Value::from_function(f::selectattr),
            Characters,
        ),
        (
            "rejectattr",
            Value::from_function(f::rejectattr),
            Characters,
        ),
        ("map", Value::from_function(f::map), Characters),
        ("groupby", Value::from_function(f::groupby), SORTED),
        ("unique", Value::from_function(f::unique), SORTED),
        ("chain", Value::from_function(f::chain), Characters),
        ("zip", Value::from_function(f::zip), Characters),
        ("format", Value::from_function(f::format), Format),
    ]
}

/// Replaces everything that a template can call.
pub fn replace(environment: &mut Environment<'_>, budget: &Arc<Budget>) {
    for (name, does, growth) in all() {
        environment.add_filter(name, paying(budget, name, does, growth));
    }
    let printing = budget.clone();
    environment.add_filter("pprint", move |value: &Value| dumped(&printing, &[value]));
    // An unknown filter is an error; so is one that a later version of the engine brings and nothing here pays for.
    for name in ["tojson", "urlencode"] {
        environment.remove_filter(name);
    }
    for (name, does) in tests() {
        environment.add_test(name, paying(budget, name, does, Growth::Same));
    }
    let of = |does| paying(budget, "", does, Growth::Same);
    environment.add_function("range", of(Value::from_function(functions::range)));
    environment.add_function("dict", of(Value::from_function(functions::dict)));
    let namespace = Value::from_function(functions::namespace);
    let making = budget.clone();
    environment.add_function(
        "namespace",
        move |state: &mut State<'_, '_>, arguments: Rest<ValueOrKwargs>| {
            let arguments = arguments.into_values();
            Growth::Same.pay(&making, &arguments)?;
            arguments.iter().try_for_each(keepable)?;
            namespace.call(state, &arguments)
        },
    );
    let printing = budget.clone();
    environment.add_function(
        "debug",
        move |state: &State<'_, '_>, arguments: Rest<Value>| {
            if !arguments.is_empty() {
                return dumped(&printing, &arguments.iter().collect::<Vec<_>>());
            }
            let mut said = String::new();
            for name in state.known_variables() {
                if let Some(value) = state.lookup(&name) {
                    said.push_str(&name);
                    said.push_str(" = ");
                    said.push_str(&dumped(&printing, &[&value])?);
                    said.push('\n');
                }
            }
            Ok::<_, Error>(said)
        },
    );
}

/// A function that is charged, then runs unchanged, and returns nothing lazy.
fn paying(
    budget: &Arc<Budget>,
    name: &'static str,
    does: Value,
    growth: Growth,
) -> impl Fn(&mut State<'_, '_>, Rest<ValueOrKwargs>) -> Result<Value, Error> + Send + Sync + 'static
{
    let budget = budget.clone();
    move |state, arguments| {
        let arguments = arguments.into_values();
        growth.pay(&budget, &arguments)?;
        let made = does.call(state, &arguments)?;
        if name == "chain" {
            return chained(&budget, made);
        }
        budget.settled(made)
    }
}

/// What `chain` makes, copied: chains of chains would be worked out in a depth of their own.
fn chained(budget: &Budget, made: Value) -> Result<Value, Error> {
    budget.weigh(&made, 1)?;
    Ok(match made.kind() {
        ValueKind::Map => {
            let mut pairs = std::collections::BTreeMap::new();
            for key in made.try_iter()? {
                let value = made.get_item(&key)?;
                pairs.insert(key, value);
            }
            Value::from(pairs)
        }
        _ => Value::from(made.try_iter()?.collect::<Vec<_>>()),
    })
}

/// Values as a programmer reads them.
fn dumped(budget: &Budget, values: &[&Value]) -> Result<String, Error> {
    for value in values {
        budget.weigh(value, 1)?;
    }
    budget.metered_text(
        |out| {
            for (place, value) in values.iter().enumerate() {
                out.write_str(if place > 0 { "\n" } else { "" })?;
                write!(out, "{value:#?}")?;
            }
            Ok(())
        },
        1,
    )
}

/// Tests that look at more than the kind of a value.
fn tests() -> Vec<(&'static str, Value)> {
    let equal = || Value::from_function(t::is_eq);
    let other = || Value::from_function(t::is_ne);
    let less = || Value::from_function(t::is_lt);
    let most = || Value::from_function(t::is_le);
    let more = || Value::from_function(t::is_gt);
    let least = || Value::from_function(t::is_ge);
    vec![
        ("eq", equal()),
        ("equalto", equal()),
        ("==", equal()),
        ("ne", other()),
        ("!=", other()),
        ("lt", less()),
        ("lessthan", less()),
        ("<", less()),
        ("le", most()),
        ("<=", most()),
        ("gt", more()),
        ("greaterthan", more()),
        (">", more()),
        ("ge", least()),
        (">=", least()),
        ("in", Value::from_function(t::is_in)),
        ("sameas", Value::from_function(t::is_sameas)),
        ("startingwith", Value::from_function(t::is_startingwith)),
        ("endingwith", Value::from_function(t::is_endingwith)),
        ("lower", Value::from_function(t::is_lower)),
        ("upper", Value::from_function(t::is_upper)),
    ]
}

/// Pays for a value, so many times, and gives it on.
pub const PAID: &str = "__paid";

/// Pays for a value that is put into a namespace.
pub const KEPT: &str = "__kept";

/// Pays for so many bytes of the template's own text.
pub const RAW: &str = "__raw";

/// Pays for a value as text, so many times.
pub const TEXT: &str = "__text";

/// Makes a lazy value a list.
pub const SETTLED: &str = "__settled";

/// Multiplies.
pub const TIMES: &str = "__times";

/// Adds them all.
pub fn add(environment: &mut Environment<'_>, budget: &Arc<Budget>) {
    let paying = budget.clone();
    environment.add_filter(PAID, move |value: &Value, times: Option<u64>| {
        paying.weigh(value, times.unwrap_or(1))?;
        Ok::<_, Error>(value.clone())
    });
    let paying = budget.clone();
    environment.add_filter(RAW, move |bytes: u64| {
        // With what printing them takes besides.
        paying.pay(bytes.saturating_add(16)).map(|()| "")
    });
    let paying = budget.clone();
    environment.add_filter(KEPT, move |value: &Value| {
        paying.weigh(value, 1)?;
        keepable(value)?;
        Ok::<_, Error>(value.clone())
    });
    let paying = budget.clone();
    environment.add_filter(TEXT, move |value: &Value, times: Option<u64>| {
        let times = times.unwrap_or(1);
        paying.weigh(value, times)?;
        match value.as_object() {
            None => Ok(value.clone()),
            Some(_) => paying
                .metered_text(|out| write!(out, "{value}"), times)
                .map(Value::from),
        }
    });
    let paying = budget.clone();
    environment.add_filter(SETTLED, move |value: Value| paying.settled(value));
    let paying = budget.clone();
    environment.add_filter(TIMES, move |left: &Value, right: &Value| {
        times(&paying, left, right)
    });
}

/// A namespace in a namespace could hold itself, which could be neither printed nor freed.
pub fn keepable(value: &Value) -> Result<(), Error> {
    let Some(object) = value.as_object() else {
        return Ok(());
    };
    if object.type_name().ends_with("::Namespace") {
        return Err(refused("a namespace cannot contain a namespace"));
    }
    match value.kind() {
        ValueKind::Seq | ValueKind::Iterable => {
            value.try_iter()?.try_for_each(|item| keepable(&item))
        }
        ValueKind::Map => value
            .try_iter()?
            .try_for_each(|key| keepable(&value.get_item(&key)?)),
        _ => Ok(()),
    }
}

/// What `*` does: numbers are multiplied, text and lists repeated.
fn times(budget: &Budget, left: &Value, right: &Value) -> Result<Value, Error> {
    if left.is_undefined() || right.is_undefined() {
        return Err(Error::from(ErrorKind::UndefinedError));
    }
    let repeated = |value: &Value| {
        matches!(
            value.kind(),
            ValueKind::String | ValueKind::Seq | ValueKind::Iterable
        )
    };
    let (what, count) = match (repeated(left), repeated(right)) {
        (true, _) => (left, right),
        (false, true) => (right, left),
        (false, false) => return product(left, right),
    };
    let count = count
        .as_usize()
        .ok_or_else(|| refused("text and lists can only be multiplied by non-negative integers"))?;
    budget.weigh(what, (count as u64).saturating_add(1))?;
    if let Some(text) = what.as_str() {
        return Ok(Value::from(text.repeat(count)));
    }
    let items: Vec<Value> = what.try_iter()?.collect();
    let all = items.len().saturating_mul(count);
    budget.pay((all as u64).saturating_mul(24))?;
    let all: Vec<Value> = items.iter().cycle().take(all).cloned().collect();
    Ok(if what.is_tuple() {
        Value::from(Tuple::from(all))
    } else {
        Value::from(all)
    })
}

fn product(left: &Value, right: &Value) -> Result<Value, Error> {
    let number = |value: &Value| matches!(value.kind(), ValueKind::Number | ValueKind::Bool);
    if !number(left) || !number(right) {
        let (left, right) = (left.kind(), right.kind());
        return Err(refused(format!(
            "tried to use * operator on unsupported types {left} and {right}"
        )));
    }
    let whole = |value: &Value| value.is_integer() || value.kind() == ValueKind::Bool;
    if whole(left) && whole(right) {
        let (left, right) = (
            i128::try_from(left.clone())?,
            i128::try_from(right.clone())?,
        );
        let product = left
            .checked_mul(right)
            .ok_or_else(|| refused(format!("unable to calculate {left} * {right}")))?;
        return Ok(i64::try_from(product).map_or_else(|_| Value::from(product), Value::from));
    }
    let float = |value: &Value| {
        if whole(value) {
            i128::try_from(value.clone()).map(|whole| whole as f64)
        } else {
            f64::try_from(value.clone())
        }
    };
    Ok(Value::from(float(left)? * float(right)?))
}

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
                        .metered_text(|out| write!(out, "{argument:?}"), 2)
                        .map(|_| ())
                })
            }
            Self::Replace => {
                let [_, from, to, ..] = arguments else {
                    return Ok(());
                };
                let shown = |value: &Value| budget.metered_text(|out| write!(out, "{value}"), 1);
                let (text, from, to) = (shown(first)?, shown(from)?, shown(to)?);
                let found = text.matches(from.as_str()).count() as u64;
                budget.pay(found.saturating_mul(to.len() as u64 * ESCAPED))
            }
            Self::Join => {
                let count = first.len().unwrap_or(0) as u64;
                let between = arguments.iter().skip(1);
                let between: u64 = between.map(longest).sum();
                budget.pay(count.saturating_mul(between))?;
                budget
                    .metered_text(|out| write!(out, "{first}"), 1)
                    .map(|_| ())
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

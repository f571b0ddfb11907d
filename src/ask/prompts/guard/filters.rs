//! The engine's filters, tests and functions, each charged to the budget before it allocates.

use std::fmt::Write;
use std::sync::Arc;

use minijinja::value::{Rest, ValueKind, ValueOrKwargs};
use minijinja::{Environment, Error, State, Value, filters as f, functions, tests as t};

use super::budget::Budget;
use super::growth::{ESCAPED, Growth};
use super::operators::keepable;

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
    budget.text_of(
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

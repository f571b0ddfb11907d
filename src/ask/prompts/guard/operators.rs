//! Filters called by the rewritten source that charge for an operation, under names no template would use.

use std::fmt::Write;
use std::sync::Arc;

use minijinja::value::{Tuple, ValueKind};
use minijinja::{Environment, Error, ErrorKind, Value};

use super::budget::{Budget, refused};

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
                .text_of(|out| write!(out, "{value}"), times)
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

//! The budget of one rendering, and the cost of values.

use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering};

use minijinja::value::ValueKind;
use minijinja::{Error, ErrorKind, Value};

use super::{DEEPEST, MAX_MADE_BYTES};

/// Bytes that text and values may still take. Nothing is given back when a value is dropped, so that what is left also
/// bounds the time of all operations together.
#[derive(Debug)]
pub struct Budget {
    left: AtomicU64,
    whole: u64,
}

/// What a value in a list or map takes, bytes.
const NODE: u64 = 64;

/// What a number takes, bytes.
const NUMBER: u64 = 32;

/// How often the values that a template is given may be copied besides.
const COPIES: u64 = 8;

impl Budget {
    /// For a filling with these values.
    #[must_use]
    pub fn with(values: &Value) -> Self {
        let given = Self::with_limit(u64::MAX);
        // Values of the program are never too deep; if they were, the filling would say so.
        let _ = given.weigh(values, 1);
        let cost = u64::MAX - given.left.load(Ordering::Relaxed);
        Self::with_limit(MAX_MADE_BYTES.saturating_add(cost.saturating_mul(COPIES)))
    }

    fn with_limit(whole: u64) -> Self {
        Self {
            left: AtomicU64::new(whole),
            whole,
        }
    }

    /// Pays for so many bytes.
    pub fn pay(&self, bytes: u64) -> Result<(), Error> {
        let took = self
            .left
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| {
                left.checked_sub(bytes)
            });
        match took {
            Ok(_) => Ok(()),
            Err(_) => Err(self.exceeded()),
        }
    }

    fn exceeded(&self) -> Error {
        // What comes after fails as well, also where the error is swallowed.
        self.left.store(0, Ordering::Relaxed);
        let most = self.whole.div_ceil(1 << 20);
        refused(format!(
            "rendering exceeds the limit of {most} MiB of text and values; repeat or nest less"
        ))
    }

    /// Pays for a walk over a value and a copy of it, so many times.
    pub fn weigh(&self, value: &Value, times: u64) -> Result<(), Error> {
        self.walk(value, times, 0)
    }

    fn walk(&self, value: &Value, times: u64, depth: usize) -> Result<(), Error> {
        if depth > DEEPEST {
            return Err(refused(format!(
                "a value is nested deeper than the limit of {DEEPEST} levels"
            )));
        }
        let pay = |bytes: u64| self.pay(bytes.saturating_mul(times));
        match value.kind() {
            ValueKind::String | ValueKind::Bytes => {
                let length = value.as_bytes().map_or(0, <[u8]>::len);
                let length = value.as_str().map_or(length, str::len);
                pay(NUMBER + length as u64)
            }
            ValueKind::Seq | ValueKind::Iterable => {
                pay(NODE)?;
                for item in value.try_iter()? {
                    pay(NUMBER)?;
                    self.walk(&item, times, depth + 1)?;
                }
                Ok(())
            }
            ValueKind::Map => {
                pay(NODE)?;
                for key in value.try_iter()? {
                    pay(NODE)?;
                    self.walk(&key, times, depth + 1)?;
                    self.walk(&value.get_item(&key)?, times, depth + 1)?;
                }
                Ok(())
            }
            ValueKind::Number => pay(NUMBER),
            _ => pay(NODE),
        }
    }

    /// Pays for a value that is printed: text by its length, anything else by what is written of it.
    pub fn printed(&self, value: &Value, times: u64) -> Result<(), Error> {
        self.weigh(value, times)?;
        if value.as_str().is_none() && value.as_object().is_some() {
            self.metered_text(|out| write!(out, "{value}"), times)?;
        }
        Ok(())
    }

    /// The text that `write` writes, paid for while it is written.
    pub fn metered_text(
        &self,
        write: impl FnOnce(&mut MeteredText<'_>) -> std::fmt::Result,
        times: u64,
    ) -> Result<String, Error> {
        let mut out = MeteredText {
            budget: self,
            times,
            text: String::new(),
        };
        match write(&mut out) {
            Ok(()) => Ok(out.text),
            Err(_) => Err(self.exceeded()),
        }
    }

    /// The value with nothing lazy in it: what is worked out again at every use, in a depth of its own, becomes a list.
    pub fn settled(&self, value: Value) -> Result<Value, Error> {
        if value.kind() != ValueKind::Iterable {
            self.weigh(&value, 1)?;
            return Ok(value);
        }
        let mut items = Vec::new();
        for item in value.try_iter()? {
            self.weigh(&item, 1)?;
            self.pay(NODE)?;
            items.push(item);
        }
        Ok(Value::from(items))
    }
}

/// Text that is paid for while it is written.
pub struct MeteredText<'b> {
    budget: &'b Budget,
    times: u64,
    text: String,
}

impl Write for MeteredText<'_> {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        let cost = (text.len() as u64).saturating_mul(self.times);
        self.budget.pay(cost).map_err(|_| std::fmt::Error)?;
        self.text.push_str(text);
        Ok(())
    }
}

/// An error that the engine adds file and line to.
pub fn refused(why: impl Into<String>) -> Error {
    Error::new(ErrorKind::InvalidOperation, why.into())
}

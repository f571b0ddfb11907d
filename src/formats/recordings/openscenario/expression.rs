//! Expressions in attributes of OpenSCENARIO: `${$speed / 3.6}`.

use std::collections::HashMap;

/// Values of parameters by their names, without `$`.
pub type Values = HashMap<String, String>;

/// Brackets within each other at most.
const DEEPEST: usize = 50;

/// An attribute with the values of parameters in their places: `$name` or `${expression}`. `None` where it is neither,
/// or cannot be worked out.
pub fn replaced(text: &str, values: &Values) -> Option<String> {
    let name = text.trim().strip_prefix('$')?;
    let Some(expression) = name.strip_prefix('{').and_then(|e| e.strip_suffix('}')) else {
        return values.get(name).cloned();
    };
    let mut reader = Reader {
        rest: expression,
        values,
        depth: 0,
    };
    let value = reader.sum()?;
    let whole = reader.rest.trim().is_empty() && value.is_finite();
    whole.then(|| value.to_string())
}

/// Reads an expression from its beginning on.
struct Reader<'a> {
    rest: &'a str,
    values: &'a Values,
    depth: usize,
}

impl<'a> Reader<'a> {
    /// Whether this comes next, which is passed over.
    fn passes(&mut self, symbol: char) -> bool {
        self.rest = self.rest.trim_start();
        let rest = self.rest.strip_prefix(symbol);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    /// What comes next as long as it is made of such characters.
    fn word(&mut self, of: impl Fn(char) -> bool) -> &'a str {
        let end = self.rest.find(|c| !of(c)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        word
    }

    fn sum(&mut self) -> Option<f64> {
        let mut value = self.product()?;
        loop {
            if self.passes('+') {
                value += self.product()?;
            } else if self.passes('-') {
                value -= self.product()?;
            } else {
                return Some(value);
            }
        }
    }

    fn product(&mut self) -> Option<f64> {
        let mut value = self.factor()?;
        loop {
            if self.passes('*') {
                value *= self.factor()?;
            } else if self.passes('/') {
                value /= self.factor()?;
            } else if self.passes('%') {
                value %= self.factor()?;
            } else {
                return Some(value);
            }
        }
    }

    fn factor(&mut self) -> Option<f64> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return None;
        }
        let value = self.signed();
        self.depth -= 1;
        value
    }

    fn signed(&mut self) -> Option<f64> {
        if self.passes('-') {
            return Some(-self.factor()?);
        }
        if self.passes('+') {
            return self.factor();
        }
        if self.passes('(') {
            let value = self.sum()?;
            return self.passes(')').then_some(value);
        }
        if self.passes('$') {
            let name = self.word(|c| c.is_alphanumeric() || c == '_');
            return self.values.get(name)?.trim().parse().ok();
        }
        if self.rest.starts_with(|c: char| c.is_alphabetic()) {
            return self.function();
        }
        self.number()
    }

    fn number(&mut self) -> Option<f64> {
        let begin = self.rest;
        self.word(|c| c.is_ascii_digit() || c == '.');
        let mantissa = begin.len() - self.rest.len();
        if self.rest.starts_with(['e', 'E']) {
            self.rest = &self.rest[1..];
            if self.rest.starts_with(['+', '-']) {
                self.rest = &self.rest[1..];
            }
            self.word(|c| c.is_ascii_digit());
        }
        let end = begin.len() - self.rest.len();
        (mantissa > 0).then(|| begin[..end].parse().ok()).flatten()
    }

    fn function(&mut self) -> Option<f64> {
        let name = self.word(char::is_alphanumeric);
        if !self.passes('(') {
            return None;
        }
        let mut of = vec![self.sum()?];
        while self.passes(',') {
            of.push(self.sum()?);
        }
        if !self.passes(')') {
            return None;
        }
        Some(match (name, &of[..]) {
            ("abs", [x]) => x.abs(),
            ("sign", [x]) if *x == 0.0 => 0.0,
            ("sign", [x]) => x.signum(),
            ("round", [x]) => x.round(),
            ("floor", [x]) => x.floor(),
            ("ceil", [x]) => x.ceil(),
            ("sqrt", [x]) => x.sqrt(),
            ("sin", [x]) => x.sin(),
            ("cos", [x]) => x.cos(),
            ("tan", [x]) => x.tan(),
            ("asin", [x]) => x.asin(),
            ("acos", [x]) => x.acos(),
            ("atan", [x]) => x.atan(),
            ("pow", [x, y]) => x.powf(*y),
            ("min", [x, y]) => x.min(*y),
            ("max", [x, y]) => x.max(*y),
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_are_worked_out() {
        let values = [("Speed", "90"), ("_a1", "-2.5"), ("word", "car")];
        let values: Values = values
            .map(|(k, v)| (k.to_string(), v.to_string()))
            .into_iter()
            .collect();
        let cases = [
            ("$Speed", Some("90")),
            ("$word", Some("car")),
            ("${$Speed / 3.6}", Some("25")),
            ("${$_a1-30}", Some("-32.5")),
            ("${2 + 3 * (4 - -1)}", Some("17")),
            ("${-(1.5e1) % 4}", Some("-3")),
            ("${max(pow(2, 3), sqrt(9)) - abs($_a1)}", Some("5.5")),
            ("${1 / 0}", None),
            ("${$missing + 1}", None),
            ("${$word + 1}", None),
            ("${1 +}", None),
            ("${(1}", None),
            ("${1) }", None),
            ("${run(1)}", None),
            ("$missing", None),
            ("90", None),
        ];
        for (text, expected) in cases {
            assert_eq!(replaced(text, &values).as_deref(), expected, "{text}");
        }
        let deep = format!("${{{}1{}}}", "(".repeat(9000), ")".repeat(9000));
        assert_eq!(replaced(&deep, &values), None);
    }
}

//! Parameters of OpenSCENARIO, and expressions in attributes: `${$speed / 3.6}`, `${not $isFast}`.
//!
//! Operators and functions are those of the standard's versions 1.1 to 1.3, constants those of esmini.

use std::collections::HashMap;

use crate::commonroad::ReadError;
use crate::recordings::opendrive::tree::Node;

/// Values of parameters by their names, without `$`.
pub type Values = HashMap<String, String>;

/// Brackets within each other at most.
const MAX_DEPTH: usize = 50;

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
    let value = reader.either()?;
    reader.rest.trim().is_empty().then(|| value.written())?
}

/// What an expression is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Value {
    Number(f64),
    Truth(bool),
}

impl Value {
    fn number(self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(number),
            Self::Truth(_) => None,
        }
    }

    fn truth(self) -> Option<bool> {
        match self {
            Self::Truth(truth) => Some(truth),
            Self::Number(_) => None,
        }
    }

    fn parse(text: &str) -> Option<Self> {
        match text.trim() {
            "true" => Some(Self::Truth(true)),
            "false" => Some(Self::Truth(false)),
            number => number.parse().ok().map(Self::Number),
        }
    }

    /// As an attribute has it; nothing for what is no number.
    fn written(self) -> Option<String> {
        match self {
            Self::Number(number) => number.is_finite().then(|| number.to_string()),
            Self::Truth(truth) => Some(truth.to_string()),
        }
    }
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

    /// Whether this word comes next, which is passed over.
    fn passes_word(&mut self, word: &str) -> bool {
        self.rest = self.rest.trim_start();
        let behind = self
            .rest
            .strip_prefix(word)
            .filter(|b| !b.starts_with(|c: char| c.is_alphanumeric() || c == '_'));
        self.rest = behind.unwrap_or(self.rest);
        behind.is_some()
    }

    fn either(&mut self) -> Option<Value> {
        let mut value = self.both()?;
        while self.passes_word("or") {
            let other = self.both()?.truth()?;
            value = Value::Truth(value.truth()? || other);
        }
        Some(value)
    }

    fn both(&mut self) -> Option<Value> {
        let mut value = self.sum()?;
        while self.passes_word("and") {
            let other = self.sum()?.truth()?;
            value = Value::Truth(value.truth()? && other);
        }
        Some(value)
    }

    fn sum(&mut self) -> Option<Value> {
        let mut value = self.product()?;
        loop {
            let plus = self.passes('+');
            if !plus && !self.passes('-') {
                return Some(value);
            }
            let (a, b) = (value.number()?, self.product()?.number()?);
            value = Value::Number(if plus { a + b } else { a - b });
        }
    }

    fn product(&mut self) -> Option<Value> {
        let mut value = self.factor()?;
        loop {
            let Some(symbol) = ['*', '/', '%'].into_iter().find(|s| self.passes(*s)) else {
                return Some(value);
            };
            let (a, b) = (value.number()?, self.factor()?.number()?);
            value = Value::Number(match symbol {
                '*' => a * b,
                '/' => a / b,
                _ => a % b,
            });
        }
    }

    fn factor(&mut self) -> Option<Value> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return None;
        }
        let value = self.signed();
        self.depth -= 1;
        value
    }

    fn signed(&mut self) -> Option<Value> {
        if self.passes('-') {
            return Some(Value::Number(-self.factor()?.number()?));
        }
        if self.passes('+') {
            return self.factor();
        }
        if self.passes_word("not") {
            return Some(Value::Truth(!self.factor()?.truth()?));
        }
        if self.passes('(') {
            let value = self.either()?;
            return self.passes(')').then_some(value);
        }
        if self.passes('$') {
            let name = self.word(|c| c.is_alphanumeric() || c == '_');
            return Value::parse(self.values.get(name)?);
        }
        if self.rest.starts_with(|c: char| c.is_alphabetic()) {
            return self.named();
        }
        self.number().map(Value::Number)
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

    /// A constant, or a function with its arguments.
    fn named(&mut self) -> Option<Value> {
        let name = self.word(char::is_alphanumeric);
        if !self.passes('(') {
            return match name {
                "pi" | "PI" => Some(Value::Number(std::f64::consts::PI)),
                "e" => Some(Value::Number(std::f64::consts::E)),
                truth => Value::parse(truth).filter(|v| v.truth().is_some()),
            };
        }
        let mut of = vec![self.either()?.number()?];
        while self.passes(',') {
            of.push(self.either()?.number()?);
        }
        if !self.passes(')') {
            return None;
        }
        let value = match (name, &of[..]) {
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
        };
        Some(Value::Number(value))
    }
}

/// The document with the values of its parameters in their places.
pub fn filled(mut root: Node) -> Result<Node, ReadError> {
    let values = declared(&root)?;
    root.change_values(&|value| replaced(value, &values));
    Ok(root)
}

/// An entry of a catalog with the values that a reference assigns, or its own.
pub fn assigned(mut entry: Node, reference: &Node) -> Result<Node, ReadError> {
    let mut values = declared(&entry)?;
    for assignment in reference.within("ParameterAssignment") {
        let name = assignment.needed("parameterRef")?.trim_start_matches('$');
        let value = assignment.text("value").unwrap_or_default();
        values.insert(name.to_string(), value.to_string());
    }
    entry.change_values(&|value| replaced(value, &values));
    Ok(entry)
}

fn declared(of: &Node) -> Result<Values, ReadError> {
    let mut values = Values::new();
    for parameter in of.within("ParameterDeclaration") {
        let name = parameter.needed("name")?.trim_start_matches('$');
        let value = parameter.text("value").unwrap_or_default();
        // A value may be told by parameters before it.
        let value = replaced(value, &values).unwrap_or_else(|| value.to_string());
        values.insert(name.to_string(), value);
        // Its type says nothing more; limits were checked where the value was chosen.
        parameter.skip();
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn expressions_are_worked_out() {
        let values = [
            ("Speed", "90"),
            ("_a1", "-2.5"),
            ("word", "car"),
            ("isFast", "true"),
        ];
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
            ("${pi}", Some("3.141592653589793")),
            ("${pi/2}", Some("1.5707963267948966")),
            ("${-PI * 2}", Some("-6.283185307179586")),
            ("${floor(e) + sign(-3) + round(2.5) + ceil(0.1)}", Some("5")),
            ("${atan(0) + cos(0) + min(1, 2) + abs(asin(0))}", Some("2")),
            ("$isFast", Some("true")),
            ("${not $isFast}", Some("false")),
            ("${$isFast and (false or not(false))}", Some("true")),
            ("${false and true or true}", Some("true")),
            ("${not 1}", None),
            ("${1 and true}", None),
            ("${true + 1}", None),
            ("${nothing}", None),
            ("${pie}", None),
            ("${notTrue}", None),
            ("${true or }", None),
            ("${inf}", None),
            ("${nan}", None),
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

    #[test]
    fn formulas_are_evaluated_as_they_are_written() {
        use crate::openscenario::Formula;

        let (a, b) = (Formula::parameter(0, "gap"), Formula::parameter(1, "_b"));
        let clamped = (&a * -0.25 + 1.0).at_least(-0.5).at_most(0.75);
        let formulas = [
            &a - &b,
            (&a - (&b - 2.5)) / (&b * &b),
            &clamped * &clamped * (&clamped * -2.0 + 3.0),
            (&b / 3.0).atan() - 1e-7,
        ];
        for values in [[2.0, -1.5], [-8.0, 0.125], [0.3, 1e-9]] {
            let named = [("gap", values[0]), ("_b", values[1])];
            let named = named.map(|(name, value)| (name.to_owned(), value.to_string()));
            for formula in &formulas {
                let text = formula.to_string();
                let read = replaced(&text, &named.clone().into()).unwrap();
                let (read, expected) = (read.parse::<f64>().unwrap(), formula.value(&values));
                let off = (read - expected).abs() / expected.abs().max(1.0);
                assert!(off < 1e-12, "{text}: {read}, {expected}");
            }
        }
        assert_eq!((&a * 0.0 + 2.0).to_string(), "2.0");
        assert_eq!((&a + 0.0 - -2.0).to_string(), "${($gap - (-2.0))}");
    }
}

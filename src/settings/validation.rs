//! What is wrong with `config.toml`: all of it, key by key, in plain words.

use nearmiss_base::system::{KeyLines, Mistake, available, toml_mistake};
use nearmiss_record::fields::Fields;
use toml::{Table, Value};

use super::{Config, planner};

/// Everything that is wrong with a text, in its order; of a text that is no TOML, where it stops being one.
pub fn mistakes(text: &str) -> Vec<Mistake> {
    let table: Table = match toml::from_str(text) {
        Ok(table) => table,
        Err(error) => return vec![no_toml(text, &error)],
    };
    let lines = KeyLines::new(text);
    let section = table.get("planner").and_then(Value::as_table);
    let inner = section
        .map_or_else(Vec::new, planner::mistakes)
        .into_iter()
        .map(|(path, words)| {
            let path = std::iter::once("planner").chain(path.iter().map(String::as_str));
            let line = lines.line(&path.collect::<Vec<_>>());
            Mistake { line, words }
        });
    let mut found: Vec<Mistake> = inner.collect();
    found.extend(table.into_iter().filter_map(|(key, value)| {
        let words = wrong::<Config>("", &key, &value)?;
        let line = lines.line(&[&key]);
        Some(Mistake { line, words })
    }));
    found.sort_by_key(|mistake| mistake.line);
    found
}

/// What is wrong with a key of a table and its value, if anything is; `table` is the name of the table with its dot.
pub(super) fn wrong<F: Fields>(table: &str, key: &str, value: &Value) -> Option<String> {
    // What only a command line sets is no key of the file.
    let rows = || F::rows().iter().filter(|row| !row.is("run"));
    let Some(row) = rows().find(|row| row.key == key) else {
        let known: Vec<&str> = rows().map(|row| row.key).collect();
        return Some(format!(
            "unknown key `{table}{key}`{}",
            available(key, known)
        ));
    };
    let wrong = F::default().set(key, value).err()?;
    Some(format!(
        "{table}{key}{}",
        wrong.first(value, &row.expected())
    ))
}

/// Where a text stops being TOML; of its line only the key is told: the value may be a secret in the wrong place.
fn no_toml(text: &str, error: &toml::de::Error) -> Mistake {
    let Mistake { line, words } = toml_mistake(text, error);
    let written = line.and_then(|line| text.lines().nth(line - 1));
    let key = written.and_then(|written| Some(written.split_once('=')?.0.trim()));
    let words = match key.filter(|key| !key.is_empty()) {
        Some(key) => format!("{key}: invalid TOML: {words}"),
        None => format!("invalid TOML: {words}"),
    };
    Mistake { line, words }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn said(text: &str) -> Vec<String> {
        let found = mistakes(text).into_iter();
        found
            .map(|m| format!("{}: {}", m.line.unwrap_or_default(), m.words))
            .collect()
    }

    #[test]
    fn all_are_named_in_plain_words() {
        let text = "radius = \"lots\"\nmouse = 1\nmodell = \"a/b\"\n\nhistory = 3\nmax_tokens = 5_000_000_000\n\
            temperature = 3\neditor = \"ed\"\nqwrtz = 1\nprovider = [1]\n";
        let found = said(text);
        let starts = [
            "1: radius = \"lots\": expected a number",
            "2: mouse = 1: expected true or false",
            "3: unknown key `modell`; did you mean `model`?",
            "6: max_tokens = 5000000000: expected a whole number",
            "7: temperature = 3: expected a number from 0 to 2",
            "8: editor: unknown editor `ed`; available: plain, vim, emacs",
            "9: unknown key `qwrtz`; available: theme, glyphs,",
            "10: provider = a list: expected a table",
        ];
        assert_eq!(found.len(), starts.len(), "{found:#?}");
        for (found, start) in found.iter().zip(starts) {
            assert!(found.starts_with(start), "{found}");
        }
        assert_eq!(said("# nothing\n"), [""; 0]);
    }

    #[test]
    fn what_is_no_toml_is_named_without_its_value() {
        let found = said("mouse = true\napi_key = sk-secret\n");
        assert!(
            found[0].starts_with("2: api_key: invalid TOML: "),
            "{found:?}"
        );
        assert!(!found[0].contains("secret"), "{found:?}");
        assert!(said("mouse = true\nmouse = true\n")[0].starts_with("2: mouse: "));
    }
}

//! The header of a table: its columns, and what stands between them.

/// What may stand between two fields.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];

/// The separator of a table that begins with `head`, and the names of its columns. The separator is the one that makes
/// most columns.
pub fn of(head: &[u8]) -> (u8, Vec<String>) {
    let line = head.split(|b| *b == b'\n').next().unwrap_or_default();
    let count = |separator: u8| line.iter().filter(|b| **b == separator).count();
    // Of as many the first one.
    let separator = SEPARATORS
        .into_iter()
        .rev()
        .max_by_key(|s| count(*s))
        .unwrap_or(b',');
    let line = String::from_utf8_lossy(line);
    let names = line.split(char::from(separator)).map(name);
    (separator, names.collect())
}

/// The name of a column without what surrounds it.
pub fn name(field: &str) -> String {
    let plain = field.trim_start_matches('\u{feff}').trim();
    plain.trim_matches('"').trim().to_string()
}

/// A number. Where fields are separated by something else, it may have a decimal comma; whether it has one comes with it.
pub fn number(text: &str, separator: u8) -> Option<(f64, bool)> {
    let text = text.trim();
    if let Ok(value) = text.parse() {
        return Some((value, false));
    }
    let has_comma = separator != b',' && text.matches(',').count() == 1 && !text.contains('.');
    let with_point = has_comma.then(|| text.replace(',', "."))?;
    Some((with_point.parse().ok()?, true))
}

/// What is wrong with a row that has fields beyond the columns; nothing where these are empty.
pub fn too_long<'f>(fields: impl Iterator<Item = &'f [u8]>, columns: usize) -> Option<String> {
    let beyond = fields.skip(columns);
    let count = beyond
        .filter(|field| !field.trim_ascii().is_empty())
        .count();
    (count > 0).then(|| {
        format!(
            "{} fields for {columns} columns; a list of numbers or a number with a decimal comma has to be in quotes",
            columns + count
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_separator_is_the_one_that_makes_most_columns() {
        let of = |text: &str| {
            let (separator, names) = of(text.as_bytes());
            (char::from(separator), names.join("|"))
        };
        assert_eq!(of("a,b\n1;2;3"), (',', "a|b".into()));
        assert_eq!(of("\u{feff}a; \"b, c\" ;d\r\n"), (';', "a|b, c|d".into()));
        assert_eq!(of("a\tb"), ('\t', "a|b".into()));
        assert_eq!(of("words"), (',', "words".into()));
        assert_eq!(of(""), (',', String::new()));
    }

    #[test]
    fn commas_are_decimal_where_they_separate_nothing() {
        assert_eq!(number(" 1.5", b','), Some((1.5, false)));
        assert_eq!(number("1,5", b';'), Some((1.5, true)));
        assert_eq!(number("1,5", b','), None);
        for odd in ["1.000,5", "1,2,3", "a,b", ""] {
            assert_eq!(number(odd, b';'), None, "{odd}");
        }
        let fields = |text: &'static str| text.split(';').map(str::as_bytes);
        assert_eq!(too_long(fields("1;2;"), 2), None);
        assert!(
            too_long(fields("1;2;3"), 2).is_some_and(|said| said.starts_with("3 fields for 2"))
        );
    }
}

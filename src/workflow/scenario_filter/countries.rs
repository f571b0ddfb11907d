//! Names of the countries in benchmark ids: ISO 3166-1 alpha-3, and CommonRoad's invented Zamunda.

/// A country a line: its code, then its names, the English one first.
const TABLE: &str = include_str!("countries.txt");

/// Letters that a word needs at least to be taken for the beginning of a name: shorter ones begin too many.
const LEAST: usize = 4;

/// Codes of the countries that a word names or begins to name, in any case.
#[must_use]
pub fn codes_of(word: &str) -> Vec<&'static str> {
    let word = word.to_lowercase();
    let names_it = |name: &str| {
        let name = name.to_lowercase();
        let begins = |part: &str| part.starts_with(&word);
        // "korea" is in "South Korea", too.
        name == word
            || word.chars().count() >= LEAST && (begins(&name) || name.split(' ').any(begins))
    };
    let countries = TABLE.lines().filter_map(|line| line.split_once(' '));
    countries
        .filter(|(_, names)| names.split(", ").any(names_it))
        .map(|(code, _)| code)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_or_its_beginning_gives_the_code() {
        assert_eq!(codes_of("germany"), ["DEU"]);
        assert_eq!(codes_of("Deutschland"), ["DEU"]);
        assert_eq!(codes_of("germ"), ["DEU"]);
        assert_eq!(codes_of("us"), ["USA"]);
        assert_eq!(codes_of("zamunda"), ["ZAM"]);
        assert_eq!(codes_of("korea"), ["KOR", "PRK"]);
        assert!(codes_of("ger").is_empty() && codes_of("").is_empty());
    }

    #[test]
    fn every_line_is_a_code_and_names() {
        for line in TABLE.lines() {
            let (code, names) = line.split_once(' ').unwrap_or_default();
            let capitals = code.chars().all(|c| c.is_ascii_uppercase());
            assert!(code.len() == 3 && capitals && !names.is_empty(), "{line}");
        }
    }
}

//! Cuts a sentence into words and signs, and reduces words to stems, so that `cut-ins` and `cutting in` are alike.

/// A word, number or sign of a sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Token {
    /// As it was said.
    pub said: String,
    /// In small letters.
    pub small: String,
    /// Its stem.
    pub stem: String,
    /// Its value, if it is a number.
    pub number: Option<f64>,
}

impl Token {
    fn of(said: &str) -> Self {
        let small = said.to_lowercase();
        let number = small.parse::<f64>().ok();
        let number = number.filter(|n| {
            n.is_finite() && small.starts_with(|c: char| c.is_ascii_digit() || c == '.')
        });
        Self {
            stem: stem(&small),
            number: number.or_else(|| {
                NUMBERS
                    .iter()
                    .find(|(word, _)| *word == small)
                    .map(|(_, n)| *n)
            }),
            small,
            said: said.to_string(),
        }
    }
}

/// Numbers in words.
const NUMBERS: &[(&str, f64)] = &[
    ("zero", 0.0),
    ("one", 1.0),
    ("two", 2.0),
    ("three", 3.0),
    ("four", 4.0),
    ("five", 5.0),
    ("six", 6.0),
    ("seven", 7.0),
    ("eight", 8.0),
    ("nine", 9.0),
    ("ten", 10.0),
    ("twenty", 20.0),
    ("thirty", 30.0),
    ("fifty", 50.0),
    ("hundred", 100.0),
    ("half", 0.5),
];

/// The words of a sentence. A hyphen between letters separates words; a unit behind a number is a word of its own.
#[must_use]
pub fn tokens(sentence: &str) -> Vec<Token> {
    let text = sentence.replace(['²', '³'], "2").replace('^', "");
    let letters: Vec<char> = text.chars().collect();
    let mut found: Vec<String> = Vec::new();
    let mut word = String::new();
    let mut end = |word: &mut String| {
        if !word.is_empty() {
            found.push(std::mem::take(word));
        }
    };
    for (at, &c) in letters.iter().enumerate() {
        let before = at.checked_sub(1).map(|i| letters[i]);
        let after = letters.get(at + 1).copied();
        let between_digits =
            before.is_some_and(|b| b.is_ascii_digit()) && after.is_some_and(|a| a.is_ascii_digit());
        let is_number = word.starts_with(|c: char| c.is_ascii_digit() || c == '.');
        match c {
            '.' | ',' if between_digits && is_number => word.push('.'),
            '.' if word.is_empty() && after.is_some_and(|a| a.is_ascii_digit()) => word.push('.'),
            '<' | '>' | '=' | '≤' | '≥' => {
                end(&mut word);
                let sign = match c {
                    '≤' => "<=",
                    '≥' => ">=",
                    '<' => "<",
                    '>' => ">",
                    _ => "=",
                };
                // The second half of `<=`.
                let joins = c == '=' && matches!(before, Some('<' | '>'));
                match joins {
                    true => word.push('='),
                    false => word.push_str(sign),
                }
                if !(matches!(c, '<' | '>') && after == Some('=')) {
                    end(&mut word);
                } else {
                    // `<=` stays one sign.
                    word.clear();
                    word.push_str(sign);
                    word.push('=');
                    end(&mut word);
                }
            }
            '/' | '_' => word.push(c),
            _ if c.is_alphanumeric() => {
                if is_number && c.is_alphabetic() {
                    end(&mut word);
                }
                word.push(c);
            }
            _ => end(&mut word),
        }
    }
    end(&mut word);
    // The `=` of a sign that was joined already.
    let mut kept: Vec<String> = Vec::new();
    for word in found {
        if word == "=" && kept.last().is_some_and(|last| last == "<=" || last == ">=") {
            continue;
        }
        kept.push(word);
    }
    kept.iter().map(|word| Token::of(word)).collect()
}

/// The stem of a word in small letters: no English, only the same for the forms of a word.
#[must_use]
pub fn stem(word: &str) -> String {
    if word.len() < 4 || word.bytes().any(|b| !b.is_ascii_alphabetic()) {
        return word.to_string();
    }
    if let Some(rest) = word.strip_suffix("ies") {
        return format!("{rest}y");
    }
    let plural = word.ends_with('s') && !word.ends_with("ss") && !word.ends_with("us");
    let one = &word[..word.len() - usize::from(plural)];
    let mut endings = ["ing", "ed"].iter();
    let cut = endings.find_map(|ending| one.strip_suffix(ending));
    let cut = cut.filter(|rest| rest.len() >= 3 && rest.contains(['a', 'e', 'i', 'o', 'u', 'y']));
    let mut stem = cut.unwrap_or(one).to_string();
    if stem.len() > 3 && stem.ends_with('e') {
        stem.pop();
    }
    let mut last = stem.bytes().rev();
    if stem.len() > 3 && last.next() == last.next() {
        stem.pop();
    }
    stem
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(sentence: &str) -> Vec<String> {
        tokens(sentence).into_iter().map(|t| t.said).collect()
    }

    #[test]
    fn units_signs_and_hyphens_separate_words() {
        assert_eq!(
            said("cut-ins, TTC<=1.5s!"),
            ["cut", "ins", "TTC", "<=", "1.5", "s"]
        );
        assert_eq!(said("over 4 m/s² (US101)."), ["over", "4", "m/s2", "US101"]);
        assert_eq!(said("a ≥ .5 = 1,5"), ["a", ">=", ".5", "=", "1.5"]);
        assert!(said(" … ").is_empty());
    }

    #[test]
    fn forms_of_a_word_have_one_stem() {
        for forms in [
            &["cut", "cuts", "cutting"][..],
            &["merge", "merges", "merging", "merged"],
            &["cross", "crosses", "crossing", "crossed"],
            &["bus", "buses"],
            &["bicycle", "bicycles"],
            &["lorry", "lorries"],
            &["collision", "collisions"],
            &["change", "changes", "changing"],
            &["lane", "lanes"],
        ] {
            let stems: Vec<String> = forms.iter().map(|form| stem(form)).collect();
            assert!(stems.iter().all(|one| *one == stems[0]), "{stems:?}");
        }
        assert_eq!(stem("s"), "s");
    }
}

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
    /// Whether a comma or the like stands before it.
    pub pause: bool,
    /// The text between blanks that begins with it.
    pub chunk: Option<Chunk>,
}

/// A text between blanks, without punctuation around it: `road:urban`, `ZAM_Urban-3_3`.
#[derive(Debug, Clone, PartialEq)]
pub struct Chunk {
    /// The text.
    pub text: String,
    /// How many words it is.
    pub words: usize,
}

impl Token {
    fn of(said: &str) -> Self {
        let small = said.to_lowercase();
        let begins = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-');
        let number = small
            .parse::<f64>()
            .ok()
            .filter(|n| n.is_finite() && small.starts_with(begins));
        let in_words = NUMBERS.iter().find(|(word, _)| *word == small);
        Self {
            stem: stem(&small),
            number: number.or(in_words.map(|(_, n)| *n)),
            small,
            said: said.to_string(),
            pause: false,
            chunk: None,
        }
    }

    /// Left and right, which no term tells apart.
    #[must_use]
    pub fn is_side(&self) -> bool {
        ["left", "right", "leftwards", "rightwards"].contains(&self.small.as_str())
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
    ("eleven", 11.0),
    ("twelve", 12.0),
    ("fifteen", 15.0),
    ("twenty", 20.0),
    ("thirty", 30.0),
    ("forty", 40.0),
    ("fifty", 50.0),
    ("sixty", 60.0),
    ("hundred", 100.0),
    ("half", 0.5),
    ("quarter", 0.25),
];

/// What is written in another way: before, after.
const SPELLINGS: &[(&str, &str)] = &[
    ("\u{2019}", "'"),
    ("\u{2212}", "-"),
    ("can't", "can not"),
    ("won't", "will not"),
    ("n't", " not"),
    ("w/o ", "without "),
    ("w/ ", "with "),
    ("U.S.A.", "USA"),
    ("U.S.", "US"),
    ("²", "2"),
    ("³", "2"),
    ("^", ""),
];

/// The words of a sentence. A hyphen between letters separates words; a unit behind a number is a word of its own.
#[must_use]
pub fn tokens(sentence: &str) -> Vec<Token> {
    let mut text = sentence.to_string();
    for (before, after) in SPELLINGS {
        text = text.replace(before, after);
    }
    let mut all: Vec<Token> = Vec::new();
    let mut pause = false;
    for written in text.split_whitespace() {
        let written = written.trim_start_matches(OPENING);
        let chunk = written.trim_end_matches(CLOSING);
        let chunk = chunk.strip_suffix("'s").unwrap_or(chunk);
        let mut words: Vec<Token> = cut(chunk).iter().map(|word| Token::of(word)).collect();
        let sides = words.iter().any(Token::is_side);
        let count = words.len();
        if let Some(first) = words.first_mut() {
            first.pause = pause;
            first.chunk = (count == 1 || !sides).then(|| Chunk {
                text: chunk.to_string(),
                words: count,
            });
            pause = false;
        }
        all.extend(words);
        pause |= written.ends_with([',', ';', ':', '.', '!', '?']);
    }
    all
}

const OPENING: [char; 7] = ['"', '\'', '(', '[', '{', '\u{201c}', '\u{201e}'];
const CLOSING: [char; 12] = [
    '"', '\'', ')', ']', '}', '\u{201d}', '\u{201c}', ',', ';', ':', '!', '?',
];

/// The words and signs of a text without blanks.
fn cut(chunk: &str) -> Vec<String> {
    let letters: Vec<char> = chunk.chars().collect();
    let mut found: Vec<String> = Vec::new();
    let mut word = String::new();
    let mut at = 0;
    while let Some(&c) = letters.get(at) {
        let before = at.checked_sub(1).map(|i| letters[i]);
        let after = letters.get(at + 1).copied();
        let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
        let is_number = word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-'));
        at += 1;
        match c {
            '.' | ',' if is_number && digit(before) && digit(after) => word.push('.'),
            '.' if word.is_empty() && digit(after) => word.push('.'),
            '-' if word.is_empty()
                && digit(after)
                && !before.is_some_and(char::is_alphanumeric) =>
            {
                word.push('-');
            }
            // Of rates alone: `m/s`, `km/h`.
            '/' if ["m", "km", "ft"].contains(&word.to_lowercase().as_str()) => word.push('/'),
            '_' => word.push('_'),
            _ if c.is_alphanumeric() => {
                if is_number && c.is_alphabetic() {
                    found.push(std::mem::take(&mut word));
                }
                word.push(c);
            }
            _ => {
                if !word.is_empty() {
                    found.push(std::mem::take(&mut word));
                }
                let or_equal = after == Some('=');
                let sign = match c {
                    '<' if or_equal => "<=",
                    '>' if or_equal => ">=",
                    '<' => "<",
                    '>' => ">",
                    '=' => "=",
                    '≤' => "<=",
                    '≥' => ">=",
                    '&' => "and",
                    '!' if found.is_empty() => "!",
                    _ => continue,
                };
                at += usize::from(or_equal);
                found.push(sign.to_string());
            }
        }
    }
    if !word.is_empty() {
        found.push(word);
    }
    found
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
    let cut = endings
        .find_map(|ending| one.strip_suffix(ending))
        .filter(|rest| rest.len() >= 3 && rest.contains(['a', 'e', 'i', 'o', 'u', 'y']));
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
    #![allow(clippy::unwrap_used)]

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
        assert_eq!(said("1-2 s, < -0.5"), ["1", "2", "s", "<", "-0.5"]);
        assert_eq!(said("cars/trucks aren't"), ["cars", "trucks", "are", "not"]);
        assert_eq!(said("the ego's lane"), ["the", "ego", "lane"]);
        let chunks = tokens("merges, road:urban");
        assert!(chunks[1].pause && !chunks[0].pause);
        assert_eq!(chunks[1].chunk.as_ref().unwrap().text, "road:urban");
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

//! The words, numbers and marks of a sentence, and patterns that are found in them whatever the ending of a word.

use std::collections::HashMap;
use std::ops::Range;

use super::number::Number;

/// A word, a number with its unit, or a mark.
#[derive(Debug, Clone, PartialEq)]
pub struct Token {
    /// Where it stands in the sentence, bytes.
    pub span: Range<usize>,
    /// As it is written, in lower case.
    pub word: String,
    /// Without the ending of a verb or a plural; a mark or number as it is written.
    pub stem: String,
    /// Its place among the numbers of the sentence.
    pub number: Option<usize>,
}

impl Token {
    /// Whether it is one of these words, as written; they have spaces between.
    pub fn is(&self, words: &str) -> bool {
        words.split(' ').any(|word| word == self.word)
    }

    /// Whether it is a word of letters.
    pub fn is_word(&self) -> bool {
        self.number.is_none() && self.word.starts_with(char::is_alphabetic)
    }

    /// Whether it may stand between the words of a pattern: an article or an adverb.
    pub fn is_filler(&self) -> bool {
        const FILLERS: &str = "the a an very still also now already just quite rather even too well far so then again always bit little \
        much";
        self.is(FILLERS) || self.word.ends_with("ly")
    }
}

/// A word without its ending: "approaching", "approaches" and "approach" are one.
pub fn stem(word: &str) -> String {
    if word.len() <= 3 || !word.is_ascii() {
        return word.into();
    }
    let cut = ["ing", "ed", "es", "s", "e"];
    let Some(rest) = cut.iter().find_map(|end| {
        let rest = word.strip_suffix(end)?;
        let is_double_s = *end == "s" && rest.ends_with(['s', 'u', 'i']);
        // "Speed", "bus".
        let is_whole = is_double_s || *end == "ed" && rest.ends_with('e');
        (rest.len() >= 3 && !is_whole).then_some(rest)
    }) else {
        return word.into();
    };
    // "stopping" and "stop".
    let bytes = rest.as_bytes();
    let last = bytes[bytes.len() - 1];
    let is_double = bytes[bytes.len() - 2] == last && !b"slaeiou".contains(&last);
    let end = if is_double && rest.len() > 3 {
        rest.len() - 1
    } else {
        rest.len()
    };
    rest[..end].into()
}

/// The tokens of a sentence in lower case, with its numbers.
pub fn tokens(lower: &str, numbers: &[Number]) -> Vec<Token> {
    const MARKS: &str = ",;:()/=<>≤≥≈~+-–—→÷×?[]{}|&";
    let mut found: Vec<Token> = Vec::new();
    let mut at = 0;
    let mut coming = numbers.iter().enumerate().peekable();
    while let Some(c) = lower[at..].chars().next() {
        if let Some((place, number)) = coming.next_if(|(_, n)| n.span.start <= at) {
            if number.span.end <= at {
                continue;
            }
            let word = lower[at..number.span.end].to_owned();
            found.push(Token {
                span: number.span.clone(),
                stem: word.clone(),
                word,
                number: Some(place),
            });
            at = number.span.end;
            continue;
        }
        let rest = &lower[at..];
        if c.is_alphabetic() {
            let limit = coming.peek().map_or(rest.len(), |(_, n)| n.span.start - at);
            let end = { rest[..limit].char_indices() }
                .find(|(_, c)| !c.is_alphanumeric())
                .map_or(limit, |(end, _)| end);
            let end = if end == 0 { c.len_utf8() } else { end };
            push_word(&mut found, &rest[..end], at);
            at += end;
            continue;
        }
        let end = at + c.len_utf8();
        // "Isn't", "it's".
        if matches!(c, '\'' | '’') {
            let tail = &lower[end..];
            let ending = ["s", "re", "m", "ve", "ll", "d", "t"].iter().find(|e| {
                tail.starts_with(**e) && !tail[e.len()..].starts_with(char::is_alphanumeric)
            });
            if let Some(ending) = ending {
                contract(&mut found, ending, at..end + ending.len());
                at = end + ending.len();
                continue;
            }
        }
        // TeX: "\approx", "\text{".
        if c == '\\' {
            let letters = lower[end..]
                .bytes()
                .take_while(u8::is_ascii_alphabetic)
                .count();
            let (mark, name) = (&lower[at..end], &lower[end..end + letters]);
            if ["approx", "times", "div"].contains(&name) {
                let mark = match name {
                    "approx" => "≈",
                    "times" => "×",
                    _ => "÷",
                };
                found.push(Token {
                    span: at..end + letters,
                    word: mark.into(),
                    stem: mark.into(),
                    number: None,
                });
            }
            let _ = mark;
            at = end + letters;
            continue;
        }
        let joins = c == '-'
            && lower[..at].ends_with(char::is_alphabetic)
            && lower[end..].starts_with(char::is_alphabetic);
        if MARKS.contains(c) && !joins {
            found.push(Token {
                span: at..end,
                word: c.to_string(),
                stem: c.to_string(),
                number: None,
            });
        }
        at = end;
    }
    // "The cyclist's still ahead" has a verb.
    for at in 0..found.len().saturating_sub(1) {
        const BEHIND_IS: &str =
            "still already not a an the in on at ahead behind about just only now way too very";
        let next = &found[at + 1];
        if found[at].is("'s") && (next.is(BEHIND_IS) || next.word.ends_with("ing")) {
            found[at].word = "is".into();
            found[at].stem = "is".into();
        }
    }
    found
}

/// A word, or two that are written as one.
fn push_word(found: &mut Vec<Token>, word: &str, at: usize) {
    const JOINED: [(&str, &str, &str); 11] = [
        ("dtclong", "dtc", "longitudinal"),
        ("dtclat", "dtc", "lateral"),
        ("ttclong", "ttc", "longitudinal"),
        ("ttclat", "ttc", "lateral"),
        ("vrellong", "vrel", "longitudinal"),
        ("vrellat", "vrel", "lateral"),
        ("cannot", "can", "not"),
        ("standstill", "standing", "still"),
        ("cutin", "cut", "in"),
        ("carfollowing", "car", "following"),
        ("onto", "on", "to"),
    ];
    let mut push = |word: &str, span: Range<usize>| {
        found.push(Token {
            span,
            stem: stem(word),
            word: word.into(),
            number: None,
        });
    };
    let span = at..at + word.len();
    match JOINED.iter().find(|(joined, ..)| *joined == word) {
        Some((_, first, second)) => {
            push(first, span.clone());
            push(second, span);
        }
        None => push(word, span),
    }
}

/// The end of a contraction as a word of its own.
fn contract(found: &mut Vec<Token>, ending: &str, span: Range<usize>) {
    let word = match ending {
        "t" => {
            // "Isn" and "'t".
            if let Some(verb) = found.last_mut()
                && let Some(bare) = verb.word.strip_suffix('n').map(str::to_owned)
            {
                let bare = match bare.as_str() {
                    "wo" => "will",
                    "ca" => "can",
                    bare => bare,
                };
                verb.word = bare.into();
                verb.stem = stem(bare);
            }
            "not"
        }
        "re" => "are",
        "m" => "am",
        "ve" => "have",
        "ll" => "will",
        "d" => "would",
        _ => {
            let is_verb = found
                .last()
                .is_some_and(|t| t.is("it he she that there who what nobody nothing let"));
            if is_verb { "is" } else { "'s" }
        }
    };
    found.push(Token {
        span,
        stem: word.into(),
        word: word.into(),
        number: None,
    });
}

/// A sequence of words, each with its alternatives.
#[derive(Debug, Clone)]
struct Pattern<T> {
    elements: Vec<Element>,
    says: T,
}

#[derive(Debug, Clone)]
struct Element {
    /// Stems, or words as written.
    any: Vec<(bool, String)>,
    is_optional: bool,
}

impl Element {
    fn read(text: &str) -> Self {
        let bare = text.strip_prefix('?');
        let any = bare
            .unwrap_or(text)
            .split('|')
            .map(|one| match one.strip_prefix('=') {
                Some(word) if !word.is_empty() => (true, word.to_owned()),
                _ => (false, stem(one)),
            });
        Self {
            any: any.collect(),
            is_optional: bare.is_some(),
        }
    }

    fn fits(&self, token: &Token) -> bool {
        token.number.is_none()
            && self.any.iter().any(|(is_exact, text)| {
                let own = if *is_exact { &token.word } else { &token.stem };
                own == text
            })
    }
}

/// Patterns, and what each says.
///
/// A pattern is words with spaces between: `a|b` is either, `?a` may be missing, and `=closing` is the word as written, where
/// others stand for all their forms. Articles and adverbs may stand between.
pub struct Lexicon<T> {
    by_stem: HashMap<String, Vec<Pattern<T>>>,
}

impl<T: Copy> Lexicon<T> {
    /// Of patterns; the first word of none is optional.
    pub fn new(all: &[(&str, T)]) -> Self {
        let mut by_stem: HashMap<String, Vec<Pattern<T>>> = HashMap::new();
        for (text, says) in all {
            let elements: Vec<Element> = text.split(' ').map(Element::read).collect();
            let Some(first) = elements.first() else {
                continue;
            };
            for (is_exact, word) in first.any.clone() {
                let key = if is_exact { stem(&word) } else { word };
                by_stem.entry(key).or_default().push(Pattern {
                    elements: elements.clone(),
                    says: *says,
                });
            }
        }
        Self { by_stem }
    }

    /// What the longest pattern that begins at a place says, and where it ends.
    pub fn at(&self, tokens: &[Token], from: usize) -> Option<(T, usize)> {
        let all = self.by_stem.get(&tokens.get(from)?.stem)?;
        let ends = all.iter().filter_map(|pattern| {
            let end = matched(&pattern.elements, tokens, from)?;
            Some((pattern.says, end))
        });
        ends.max_by_key(|(_, end)| *end)
    }

    /// All that are said in a part of the tokens, in order, none inside another: what, and where.
    pub fn all(&self, tokens: &[Token], part: Range<usize>) -> Vec<(T, Range<usize>)> {
        let mut found = Vec::new();
        let mut from = part.start;
        while from < part.end {
            match self.at(&tokens[..part.end], from) {
                Some((says, end)) => {
                    found.push((says, from..end));
                    from = end;
                }
                None => from += 1,
            }
        }
        found
    }
}

/// Where a pattern that begins at a place ends.
fn matched(elements: &[Element], tokens: &[Token], from: usize) -> Option<usize> {
    let Some((first, rest)) = elements.split_first() else {
        return Some(from);
    };
    if let Some(token) = tokens.get(from)
        && first.fits(token)
        && let Some(end) = then(rest, tokens, from + 1)
    {
        return Some(end);
    }
    if first.is_optional {
        return matched(rest, tokens, from);
    }
    None
}

/// The rest of a pattern, behind what may stand between.
fn then(rest: &[Element], tokens: &[Token], from: usize) -> Option<usize> {
    if rest.is_empty() {
        return Some(from);
    }
    let mut best = None;
    for at in from..=from + 4 {
        if let Some(end) = matched(rest, tokens, at) {
            // What is only filler is no part of it.
            best = best.max(Some(if end == at { from } else { end }));
        }
        if !tokens.get(at).is_some_and(Token::is_filler) {
            break;
        }
    }
    best
}

/// Whether a text denies: with a word of its own, or a contraction.
pub fn denies(text: &str) -> bool {
    const DENIALS: [&str; 12] = [
        "not", "no", "never", "nor", "neither", "without", "cannot", "nowhere", "hardly", "barely",
        "rarely", "lacks",
    ];
    DENIALS.iter().any(|word| has_word(text, word)) || is_contracted(text)
}

/// Whether a text has a contraction that denies: "isn't".
pub fn is_contracted(text: &str) -> bool {
    text.contains("n't") || text.contains("n’t")
}

/// Whether a word occurs, not as a part of another.
pub fn has_word(lower: &str, word: &str) -> bool {
    find_word(lower, word).is_some()
}

/// Where words stand in a text, not as a part of others.
pub fn find_word(lower: &str, word: &str) -> Option<usize> {
    lower.match_indices(word).map(|(at, _)| at).find(|at| {
        let part = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
        let end = at + word.len();
        !part(lower[..*at].chars().next_back()) && !part(lower[end..].chars().next())
    })
}

/// Whether a sentence in lower case is in another language than English: by its script, or by its small words.
pub fn is_foreign(lower: &str) -> bool {
    const SMALL: [&str; 44] = [
        "der", "das", "und", "ist", "nicht", "mit", "auf", "uns", "wir", "ein", "eine", "einen",
        "von", "zur", "zum", "dem", "den", "im", "sich", "wird", "für", "aber", "noch", "vor",
        "bei", "le", "la", "les", "est", "une", "et", "dans", "sur", "devant", "el", "los", "está",
        "una", "con", "en", "del", "il", "di", "che",
    ];
    let letters = lower.chars().filter(|c| c.is_alphabetic()).count();
    let latin = lower
        .chars()
        .filter(|c| c.is_alphabetic() && *c < '\u{250}')
        .count();
    let words = lower.split(|c: char| !c.is_alphabetic());
    latin * 5 < letters * 4 || words.filter(|word| SMALL.contains(word)).take(2).count() == 2
}

#[cfg(test)]
mod tests {
    use super::super::number::numbers;
    use super::*;

    fn read(text: &str) -> Vec<Token> {
        tokens(text, &numbers(text))
    }

    #[test]
    fn endings_and_contractions_are_seen_through() {
        for words in [
            ["approaching", "approaches", "approach"],
            ["stopping", "stopped", "stop"],
            ["braking", "brakes", "brake"],
            ["closing", "closes", "closed"],
        ] {
            assert_eq!(stem(words[0]), stem(words[1]));
            assert_eq!(stem(words[0]), stem(words[2]));
        }
        let words: Vec<String> = read("it isn't 3.2 m front-left; won’t ttc_long")
            .into_iter()
            .map(|t| t.word)
            .collect();
        assert_eq!(
            words,
            [
                "it", "is", "not", "3.2 m", "front", "left", ";", "will", "not", "ttc", "long"
            ]
        );
    }

    #[test]
    fn patterns_have_alternatives_and_gaps() {
        let lexicon = Lexicon::new(&[
            ("close in", 1),
            ("=closing", 2),
            ("move ?right toward|towards ego|us", 3),
        ]);
        let at = |text: &str| lexicon.at(&read(text), 0);
        assert_eq!(at("closes rapidly in on"), Some((1, 3)));
        assert_eq!(at("closing fast"), Some((2, 1)));
        assert_eq!(at("close to it"), None);
        assert_eq!(at("moves slowly towards the ego"), Some((3, 5)));
    }
}

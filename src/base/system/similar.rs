//! Names that a mistyped one probably means.

/// The one of the known words that a mistyped one probably means.
#[must_use]
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let likeness = |other: &str| strsim::jaro(word, other);
    let best = known
        .into_iter()
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    best.filter(|known| likeness(known) > 0.75)
}

/// The names that a mistyped one may mean, at most three, the most alike first. Case does not count, and a name that
/// contains the word is always alike.
#[must_use]
pub fn similar<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let wanted = word.to_lowercase();
    let likeness = |name: &str| {
        let name = name.to_lowercase();
        let contained = wanted.chars().count() >= SHORTEST && name.contains(&wanted);
        let alike = strsim::jaro_winkler(&wanted, &name);
        if contained {
            alike.max(CONTAINED)
        } else {
            alike
        }
    };
    let mut found: Vec<(f64, &str)> = known
        .into_iter()
        .map(|name| (likeness(name), name))
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let best = found.first().map_or(0.0, |(likeness, _)| *likeness);
    // Far behind the best one, a name is noise.
    found.retain(|(likeness, _)| *likeness >= ALIKE && *likeness > best - SPREAD);
    let mut names: Vec<&str> = found.into_iter().map(|(_, name)| name).collect();
    names.dedup();
    names.truncate(MOST);
    names
}

/// ``; did you mean `a`, `b` or `c`?``, or nothing where no name is alike.
#[must_use]
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    match &similar(word, known)[..] {
        [] => String::new(),
        [one] => format!("; did you mean `{one}`?"),
        [first @ .., last] => format!("; did you mean `{}` or `{last}`?", first.join("`, `")),
    }
}

/// ``unknown task `saftey`; did you mean `safety`?``: the error for a word that is none of the known ones.
#[must_use]
pub fn unknown<'a>(
    what: &str,
    word: &str,
    known: impl IntoIterator<Item = &'a str> + Clone,
) -> String {
    format!("unknown {what} `{word}`{}", available(word, known))
}

/// What is known instead of a word: the names that it may mean, or all of them where it is like none and they are few.
#[must_use]
pub fn available<'a>(word: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> String {
    let meant = did_you_mean(word, known.clone());
    let all: Vec<&str> = known.into_iter().collect();
    match all.len() {
        _ if !meant.is_empty() => meant,
        0 => String::new(),
        1..=FEW => format!("; available: {}", all.join(", ")),
        more => {
            let first = all[..FEW].join(", ");
            format!("; available: {first} and {} more", more - FEW)
        }
    }
}

/// Suggestions, at most.
const MOST: usize = 3;

/// Names that are listed where no one is alike.
const FEW: usize = 8;

/// Words at least this much alike, 0 to 1, may be the same one mistyped.
const ALIKE: f64 = 0.82;

/// A suggestion is at most so much less alike than the best one.
const SPREAD: f64 = 0.08;

/// How alike a name is that contains the word.
const CONTAINED: f64 = 0.9;

/// Characters of a word that is looked for inside names.
const SHORTEST: usize = 3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_near_or_nothing_is() {
        assert_eq!(nearest("modell", ["mouse", "model"]), Some("model"));
        assert_eq!(nearest("qwrtz", ["mouse", "model"]), None);
    }

    #[test]
    fn a_few_names_are_suggested_the_best_first() {
        let commands = ["metrics", "models", "describe", "prompt", "prompts"];
        assert_eq!(similar("metrix", commands), ["metrics"]);
        assert_eq!(similar("promts", commands), ["prompts", "prompt"]);
        assert!(similar("data", commands).is_empty());
        let scenarios = ["ZAM_CutIn-1_1_T-1", "ZAM_Merge-1_1_T-1"];
        assert_eq!(similar("cutin", scenarios), ["ZAM_CutIn-1_1_T-1"]);
        assert_eq!(
            available("saftey", ["collision", "safety"]),
            "; did you mean `safety`?"
        );
        assert_eq!(available("x", ["a", "b"]), "; available: a, b");
        assert_eq!(
            unknown("command", "promts", commands),
            "unknown command `promts`; did you mean `prompts` or `prompt`?"
        );
    }
}

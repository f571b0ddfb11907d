//! Which axis of the ego a number is about, and what the words around it refer to.

/// Whether a number is where a change begins: "from 5 m to 3 m"; "approaching from behind" says nothing of numbers.
pub fn from_number(lower: &str) -> bool {
    lower.match_indices("from ").any(|(at, word)| {
        let rest = lower[at + word.len()..].trim_start_matches(['*', '~', '-', '−', '+', '`', ' ']);
        let begins = !lower[..at].ends_with(char::is_alphanumeric);
        begins && rest.starts_with(|c: char| c.is_ascii_digit())
    })
}

/// A text without the ego where something is only told relative to it: "closing in on the ego at".
pub fn without_reference(text: &str) -> String {
    let mut text = text.replace("the ego", "ego").replace("towards", "toward");
    for before in [
        "toward",
        "from",
        "relative to",
        "in front of",
        "ahead of",
        "behind",
        "to",
        "on",
        "with",
        "of",
        "as",
        "both",
    ] {
        text = text.replace(&format!(" {before} ego"), " ");
    }
    text
}

/// The axis of a number: named before it, or right behind it, as in "2.4 m longitudinal, 9.4 m lateral".
pub fn axis_of(near: &str, after: &str) -> Option<bool> {
    let after = after.trim_start_matches('(');
    let behind = ["longitudinal", "lateral"].map(|word| after.starts_with(word));
    let words = near.trim_end_matches(['*', ' ', '`', ':', '=', '(', '≈', '~', '-', '−']);
    let before = words.ends_with("longitudinal") || words.ends_with("lateral");
    match behind {
        [true, _] if !before => Some(true),
        [_, true] if !before => Some(false),
        _ => axis(near),
    }
}

/// The axis of "3 m in front of the ego" or "2 m to the left of the ego".
pub fn from_ego(after: &str) -> Option<bool> {
    let said = |words: &[&str]| {
        let rest = words.iter().find_map(|word| after.strip_prefix(word));
        rest.is_some_and(|rest| {
            let rest = rest.trim_start_matches([' ', '*']);
            let rest = rest.strip_prefix("the ").unwrap_or(rest);
            rest.starts_with("ego") || rest.starts_with("current ego")
        })
    };
    if said(&["in front of", "ahead of", "behind"]) {
        Some(true)
    } else {
        said(&["to the left of", "to the right of", "left of", "right of"]).then_some(false)
    }
}

/// The axis that is named, if it is the only one.
pub fn only_axis(text: &str) -> Option<bool> {
    let other = |long| if long { "lateral" } else { "longitudinal" };
    axis(text).filter(|long| !text.contains(other(*long)))
}

/// The last axis that is named: along (true) or across the ego's heading.
pub fn axis(near: &str) -> Option<bool> {
    let last = |words: &[&str]| words.iter().filter_map(|word| near.rfind(word)).max();
    let long = last(&["longitudinal", "_long", "dtclong", "ttclong", "vrellong"]);
    let lat = last(&["lateral", "_lat", "dtclat", "ttclat", "vrellat"]);
    match (long, lat) {
        (None, None) => None,
        (a, b) => Some(a > b),
    }
}

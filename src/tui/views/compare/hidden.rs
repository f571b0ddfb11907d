//! Blind mode: hides which model wrote an answer.

use std::borrow::Cow;

use crate::model::{Model, ShownAnswer};
use nearmiss_scene::judge;

/// The displayed name of an answer.
pub fn name(model: &Model, shown: ShownAnswer) -> String {
    match shown {
        _ if model.compare.hides() => "answer".into(),
        ShownAnswer::Reference => judge::NAME.into(),
        ShownAnswer::Column(place) => model
            .answers
            .columns
            .get(place)
            .map_or(String::new(), |c| c.model.clone()),
    }
}

/// The text of an answer without the names of its model. Every place in it stays where it was.
pub fn text<'t>(model: &Model, shown: ShownAnswer, text: &'t str) -> Cow<'t, str> {
    let mut text = Cow::Borrowed(text);
    let ShownAnswer::Column(place) = shown else {
        return text;
    };
    let Some(column) = model
        .answers
        .columns
        .get(place)
        .filter(|_| model.compare.hides())
    else {
        return text;
    };
    let returned = column.answer().and_then(|a| a.model_returned.as_deref());
    for id in [Some(column.model.as_str()), returned]
        .into_iter()
        .flatten()
    {
        let bare = id.rsplit('/').next().unwrap_or(id);
        // "gemini" of "gemini-1.5-pro"; short beginnings occur in other words.
        let family = bare
            .split(['-', ':', '.', ' '])
            .next()
            .filter(|f| f.len() >= 3);
        for name in [Some(id), Some(bare), family].into_iter().flatten() {
            text = without(text, name);
        }
    }
    text
}

/// `text` with every occurrence of a name, in any case, blotted out.
fn without<'t>(text: Cow<'t, str>, name: &str) -> Cow<'t, str> {
    let (lower, name) = (text.to_ascii_lowercase(), name.to_ascii_lowercase());
    if name.is_empty() || !name.is_ascii() || !lower.contains(&name) {
        return text;
    }
    let mut blotted = String::with_capacity(text.len());
    let mut from = 0;
    for (at, found) in lower.match_indices(&name) {
        blotted.push_str(&text[from..at]);
        blotted.extend(std::iter::repeat_n('*', found.len()));
        from = at + found.len();
    }
    blotted.push_str(&text[from..]);
    Cow::Owned(blotted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_blotted_out_in_their_places() {
        let text = without("As GPT-4o, I (gpt-4o) say ü.".into(), "gpt-4o");
        assert_eq!(text, "As ******, I (******) say ü.");
        assert_eq!(without("plain".into(), ""), "plain");
    }
}

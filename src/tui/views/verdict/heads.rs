//! Column headers of the verdict table: model names shortened but distinguishable.

use unicode_width::UnicodeWidthStr;

use crate::tui::widgets::words::fit;

/// Models' ids in so many columns each: whole, or without their provider, and then with their beginning, which tells
/// models apart. Of those that would read the same, as much of the provider is left as tells them apart. The title of
/// the reasoning has them whole.
pub fn heads(ids: &[&str], width: usize) -> Vec<String> {
    let plain: Vec<String> = ids.iter().map(|id| short(id, 0, width)).collect();
    let alike = |i: usize, heads: &[String]| {
        (0..ids.len()).any(|j| ids[j] != ids[i] && heads[j] == heads[i])
    };
    let longest = ids.iter().filter_map(|id| id.find('/')).max().unwrap_or(0);
    let mut best = plain.clone();
    for letters in 1..=longest {
        let unclear: Vec<usize> = (0..ids.len()).filter(|i| alike(*i, &best)).collect();
        if unclear.is_empty() {
            break;
        }
        // All that read alike change together, also those that another one of them has just left alone.
        for i in (0..ids.len()).filter(|i| alike(*i, &plain)) {
            best[i] = short(ids[i], letters, width);
        }
    }
    best
}

/// An id within `width` columns, with `letters` of its provider if it does not fit whole.
fn short(id: &str, letters: usize, width: usize) -> String {
    match id.split_once('/') {
        Some((provider, model)) if id.width() > width => {
            let some: String = provider.chars().take(letters).collect();
            match some.is_empty() {
                true => fit(model, width),
                false => fit(&format!("{some}/{model}"), width),
            }
        }
        _ => fit(id, width),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_read_the_same_keeps_a_part_of_its_provider() {
        let two = ["recorded/gpt-4o", "openai/gpt-4o"];
        assert_eq!(heads(&two, 20), two);
        assert_eq!(heads(&two, 10), ["r/gpt-4o", "o/gpt-4o"]);
        let narrow = heads(&two, 7);
        assert_ne!(narrow[0], narrow[1], "{narrow:?}");
        assert!(narrow.iter().all(|head| head.width() <= 7), "{narrow:?}");
        let providers = ["openrouter/gpt-4o", "openai/gpt-4o"];
        assert_eq!(heads(&providers, 12), ["openr/gpt-4o", "opena/gpt-4o"]);
    }

    #[test]
    fn what_is_clear_or_the_same_stays_short() {
        let clear = ["openai/gpt-4o-mini", "gemini/gemini-2.5-pro"];
        assert_eq!(heads(&clear, 11), ["gpt-4o-mini", "gemini-2.5…"]);
        let same = ["openai/gpt-4o-mini", "openai/gpt-4o-mini"];
        assert_eq!(heads(&same, 11), ["gpt-4o-mini"; 2]);
        assert_eq!(heads(&[], 11), [""; 0]);
    }
}

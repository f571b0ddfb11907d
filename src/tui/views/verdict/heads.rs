//! Column headers of the verdict table: model names shortened but distinguishable.

use unicode_width::UnicodeWidthStr;

use crate::widgets::words::{fit, fit_middle};

/// Columns of answers, and of the built-in judge where `last` names what it needs: as much as each needs, and what is
/// left in equal parts; where there is less, the widest get less. An answer needs `least`, its model without the
/// provider, and a gap.
pub fn widths(ids: &[&str], last: Option<usize>, least: usize, room: usize) -> Vec<usize> {
    let bare = |id: &&str| {
        id.split_once('/')
            .map_or(id.width(), |(_, model)| model.width())
    };
    let needed = ids.iter().map(|id| least.max(bare(id) + 1));
    let needed: Vec<usize> = needed.chain(last).collect();
    let count = needed.len().max(1);
    let sum: usize = needed.iter().sum();
    if sum <= room {
        let more = (room - sum) / count;
        return needed.into_iter().map(|width| width + more).collect();
    }
    // The narrow ones get what they need, the others share what is left.
    let (mut share, mut narrow) = (room / count, 0);
    loop {
        let within = || needed.iter().filter(|width| **width <= share);
        let taken: usize = within().sum();
        let (few, others) = (within().count(), count - within().count());
        if few == narrow || others == 0 {
            break;
        }
        (share, narrow) = (room.saturating_sub(taken) / others, few);
    }
    needed.into_iter().map(|width| width.min(share)).collect()
}

/// Models' ids in so many columns each: whole, or without their provider, and then with their beginning and end, which
/// tell models apart. Of those that would read the same, as much of the provider is left as tells them apart. The title of
/// the reasoning has them whole.
pub fn heads(ids: &[&str], widths: &[usize]) -> Vec<String> {
    let width = |i: usize| widths.get(i).copied().unwrap_or(0);
    let plain = ids.iter().enumerate();
    let plain: Vec<String> = plain.map(|(i, id)| short(id, 0, width(i))).collect();
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
            best[i] = short(ids[i], letters, width(i));
        }
    }
    best
}

/// An id within `width` columns, with `letters` of its provider if it does not fit whole.
fn short(id: &str, letters: usize, width: usize) -> String {
    match id.split_once('/') {
        Some((provider, model)) if id.width() > width => {
            let some: String = provider.chars().take(letters).collect();
            if some.is_empty() {
                fit_middle(model, width)
            } else {
                fit_middle(&format!("{some}/{model}"), width)
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
        assert_eq!(heads(&two, &[20, 20]), two);
        assert_eq!(heads(&two, &[10, 10]), ["r/gpt-4o", "o/gpt-4o"]);
        let narrow = heads(&two, &[7, 7]);
        assert_ne!(narrow[0], narrow[1], "{narrow:?}");
        assert!(narrow.iter().all(|head| head.width() <= 7), "{narrow:?}");
        let providers = ["openrouter/gpt-4o", "openai/gpt-4o"];
        assert_eq!(
            heads(&providers, &[12, 12]),
            ["openr/gpt-4o", "opena/gpt-4o"]
        );
    }

    #[test]
    fn what_is_clear_or_the_same_stays_short() {
        let clear = ["openai/gpt-4o-mini", "gemini/gemini-2.5-pro"];
        assert_eq!(heads(&clear, &[11, 11]), ["gpt-4o-mini", "gemin…5-pro"]);
        let same = ["openai/gpt-4o-mini", "openai/gpt-4o-mini"];
        assert_eq!(heads(&same, &[11, 11]), ["gpt-4o-mini"; 2]);
        assert_eq!(heads(&[], &[]), [""; 0]);
    }

    #[test]
    fn columns_are_as_wide_as_their_heads() {
        let ids = ["lab/pyro-8b", "lab/sage-70b", "lab/pyro-8b", "lab/sage-70b"];
        let narrow = widths(&ids, Some(8), 8, 43);
        assert_eq!(narrow, [8, 9, 8, 9, 8]);
        assert_eq!(
            heads(&ids, &[7, 8, 7, 8]),
            ["pyro-8b", "sage-70b"].repeat(2)
        );
        assert_eq!(
            widths(&ids, Some(8), 8, 47),
            [9, 10, 9, 10, 9],
            "what is left"
        );
        assert_eq!(
            widths(&["lab/a-very-long-name", "a/b"], Some(8), 8, 30),
            [14, 8, 8]
        );
        assert_eq!(
            widths(&ids, Some(8), 8, 20),
            [4; 5],
            "never more than there is"
        );
        assert_eq!(widths(&[], Some(8), 8, 20), [20]);
        assert_eq!(widths(&[], None, 8, 20), [0; 0]);
    }
}

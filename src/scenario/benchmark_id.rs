//! The benchmark id: whether it follows the rule, and what the reference reader makes of one that does not.

use std::borrow::Cow;

/// Whether `id` follows `(C-)?COUNTRY_Map-1(_1(_[STPI](-1)+)?)?`, with numbers from 1.
#[must_use]
pub fn is_valid(id: &str) -> bool {
    let rest = id.strip_prefix("C-").unwrap_or(id);
    let mut parts = rest.split('_');
    let country = parts
        .next()
        .is_some_and(|c| c.len() == 3 && c.bytes().all(|b| b.is_ascii_uppercase()));
    let map = parts
        .next()
        .and_then(|m| m.split_once('-'))
        .is_some_and(|(name, number)| {
            !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric()) && is_number(number)
        });
    let configuration = parts.next().is_none_or(is_number);
    let prediction = parts.next().is_none_or(|p| {
        let mut pieces = p.split('-');
        let kind = pieces
            .next()
            .is_some_and(|k| matches!(k, "S" | "T" | "P" | "I"));
        let numbers: Vec<&str> = pieces.collect();
        kind && !numbers.is_empty() && numbers.into_iter().all(is_number)
    });
    country && map && configuration && prediction && parts.next().is_none()
}

fn is_number(text: &str) -> bool {
    !text.starts_with('0') && !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

/// The id as the reference reader prints it: one that breaks the rule becomes the name of a map in Zamunda.
#[must_use]
pub fn normalized(id: &str) -> Cow<'_, str> {
    if is_valid(id) {
        return Cow::Borrowed(id);
    }
    let letters: String = id.chars().filter(char::is_ascii_alphanumeric).collect();
    Cow::Owned(format!("ZAM_{letters}-1"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule() {
        for id in [
            "DEU_Bremen-1_10_T-1",
            "C-USA_US101-33_2_S-1-2",
            "ZAM_Tutorial-1",
            "ZAM_A1-2_3",
        ] {
            assert!(is_valid(id), "{id}");
            assert_eq!(normalized(id), id);
        }
        for id in [
            "",
            "ZAM_test_0-1",
            "DEU_A-0_1_T-1",
            "DE_A-1",
            "DEU_A-1_1_X-1",
            "DEU_A-1_1_T",
            "DEU_A-1_1_T-1_2",
        ] {
            assert!(!is_valid(id), "{id}");
        }
        assert_eq!(normalized("ZAM_test_0-1"), "ZAM_ZAMtest01-1");
    }
}

//! Damaged streams: whatever bytes come and wherever they are cut, there is one end, and it is the same.

use nearmiss::llm::{Dialect, decode};
use proptest::prelude::*;

use super::support::dialects::usual_of;
use super::*;

/// What was said, and whether it was finished.
fn said(items: &[Result<Chunk, Error>]) -> (String, String, bool) {
    let (mut reasoning, mut text) = (String::new(), String::new());
    for item in items {
        match item {
            Ok(Chunk::Reasoning(piece)) => reasoning += piece,
            Ok(Chunk::Text(piece)) => text += piece,
            _ => {}
        }
    }
    let finished = matches!(items.last(), Some(Ok(Chunk::Finished(_))));
    (reasoning, text, finished)
}

#[derive(Clone, Debug)]
enum Damage {
    Cut(usize, usize),
    Repeat(usize, usize),
    Put(usize, String),
}

fn damage() -> impl Strategy<Value = Damage> {
    let text = prop_oneof![
        Just("null".to_string()),
        Just("\n\n".to_string()),
        Just("data: [DONE]\n\n".to_string()),
        Just("<think>".to_string()),
        Just("\"error\":{\"message\":\"x\"},".to_string()),
        "\\PC{0,4}",
    ];
    let (at, length) = (0..4000usize, 0..80usize);
    prop_oneof![
        (at.clone(), length.clone()).prop_map(|(at, n)| Damage::Cut(at, n)),
        (at.clone(), length).prop_map(|(at, n)| Damage::Repeat(at, n)),
        (at, text).prop_map(|(at, text)| Damage::Put(at, text)),
    ]
}

fn damaged(text: &str, damages: &[Damage]) -> String {
    let mut letters: Vec<char> = text.chars().collect();
    for damage in damages {
        let place = |at: usize, n: usize| {
            let from = at % (letters.len() + 1);
            from..(from + n).min(letters.len())
        };
        match damage {
            Damage::Cut(at, n) => drop(letters.drain(place(*at, *n))),
            Damage::Repeat(at, n) => {
                let place = place(*at, *n);
                let again = letters[place.clone()].to_vec();
                letters.splice(place.end..place.end, again);
            }
            Damage::Put(at, text) => {
                let from = place(*at, 0).start;
                letters.splice(from..from, text.chars());
            }
        }
    }
    letters.into_iter().collect()
}

fn one_end(items: &[Result<Chunk, Error>]) -> bool {
    let is_end = |item: &&Result<Chunk, Error>| matches!(item, Err(_) | Ok(Chunk::Finished(_)));
    items.iter().filter(is_end).count() == 1 && items.last().is_some_and(|item| is_end(&item))
}

#[test]
fn hostile_streams_end_in_time() {
    let begun = Instant::now();
    let piece = vec![b'a'; 16 << 10];
    for dialect in Dialect::ALL {
        let endless = [&b"data: "[..]]
            .into_iter()
            .chain(std::iter::repeat_n(piece.as_slice(), 1000));
        let items = decode(dialect, endless);
        assert!(
            matches!(&items[..], [Err(Error::Malformed { what, .. })] if what.contains("too large")),
            "{dialect:?} {items:?}"
        );
    }
    let spaces = delta(" ").repeat(40_000) + &delta("{}") + FINISH + DONE;
    let items = decode(Dialect::OpenAiChat, spaces.as_bytes().chunks(4096));
    let (_, text, finished) = said(&items);
    assert!(finished && text.len() == 40_002);
    let nested = format!("data: {}\n\n", "[".repeat(100_000));
    let items = decode(Dialect::Gemini, [nested.as_bytes()]);
    assert!(
        matches!(&items[..], [Err(Error::Malformed { .. })]),
        "{items:?}"
    );
    assert!(
        begun.elapsed() < Duration::from_secs(20),
        "{:?}",
        begun.elapsed()
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn damaged_streams(dialect in 0..Dialect::ALL.len(), damages in prop::collection::vec(damage(), 1..4), size in 1..60usize) {
        let dialect = Dialect::ALL[dialect];
        let text = damaged(&usual_of(dialect), &damages);
        let whole = decode(dialect, [text.as_bytes()]);
        prop_assert!(one_end(&whole), "{text}\n{whole:?}");
        let pieces = decode(dialect, text.as_bytes().chunks(size));
        prop_assert_eq!(said(&whole), said(&pieces), "{}", text);
    }

    #[test]
    fn any_bytes(dialect in 0..Dialect::ALL.len(), bytes in prop::collection::vec(any::<u8>(), 0..200), size in 1..9usize) {
        let dialect = Dialect::ALL[dialect];
        let whole = decode(dialect, bytes.chunks(size));
        prop_assert!(one_end(&whole), "{bytes:?}\n{whole:?}");
    }
}

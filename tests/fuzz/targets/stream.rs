//! Any bytes, cut anywhere, end in one finished answer or one error, in every dialect, and the same wherever they are
//! cut.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nearmiss::llm::{Chunk, Dialect, Error, decode};

/// Reasoning, text and how it ended.
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

fuzz_target!(|bytes: &[u8]| {
    let Some((&first, bytes)) = bytes.split_first() else {
        return;
    };
    let dialect = Dialect::ALL[usize::from(first) % Dialect::ALL.len()];
    let cut = usize::from(first) / Dialect::ALL.len() + 1;
    let whole = decode(dialect, [bytes]);
    let ends = whole.iter().filter(|item| matches!(item, Err(_) | Ok(Chunk::Finished(_))));
    assert_eq!(ends.count(), 1, "{whole:?}");
    assert!(matches!(whole.last(), Some(Err(_) | Ok(Chunk::Finished(_)))), "{whole:?}");
    // Bytes that are no text are noticed as soon as they arrive, so what came before them depends on the pieces.
    if std::str::from_utf8(bytes).is_ok() {
        assert_eq!(said(&whole), said(&decode(dialect, bytes.chunks(cut))));
    }
});

//! Checks untrusted JSON before parsing: a few bytes can expand to a value many times their size.

/// Most values in the document of one answer.
pub(super) const MAX_VALUES: usize = 1_000_000;

/// Whether a document has at most `most` values; each follows a comma or the start of a list or object.
pub(super) fn is_bounded(document: &[u8], most: usize) -> bool {
    if document.len() <= most {
        return true;
    }
    let (mut values, mut quoted, mut escaped) = (1_usize, false, false);
    for byte in document {
        match byte {
            _ if escaped => escaped = false,
            b'\\' => escaped = quoted,
            b'"' => quoted = !quoted,
            b',' | b'[' | b'{' if !quoted => values += 1,
            _ => {}
        }
    }
    values <= most
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_counted_and_texts_are_not_looked_into() {
        assert!(is_bounded(b"[1,2,{\"a\":3}]", 5));
        assert!(!is_bounded(b"[1,2,{\"a\":3}]", 4));
        assert!(is_bounded(br#"{"a":"[,,\"[,,,,"}"#, 2));
        assert!(!is_bounded(&b"[],".repeat(100), 99));
    }
}

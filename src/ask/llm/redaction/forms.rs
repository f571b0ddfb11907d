//! The encoded forms of a secret to search for.

use base64::Engine;
use base64::engine::general_purpose::STANDARD_NO_PAD;

use super::escapes::taken_back;
use super::redactor::LAYERS;

/// Shortest secret, in bytes, searched in base64 and hexadecimal; shorter ones would match by chance.
const CODED_FROM: usize = 8;

/// A secret as it is written, also with the escapes that it seems to hold itself taken back, and in hexadecimal.
pub(super) fn plain(secret: &str) -> Vec<Vec<u8>> {
    let mut forms = vec![secret.as_bytes().to_vec()];
    // In forms a space is a plus sign.
    if secret.contains(' ') {
        forms.push(secret.replace(' ', "+").into_bytes());
    }
    // In a text with escapes `a%41b` is read as `aAb`, whether that was meant or not.
    const KINDS: &[u8] = b"%\\&";
    let mut layer = secret.as_bytes().to_vec();
    let mut meant: Vec<Vec<u8>> = Vec::new();
    for _ in 0..LAYERS {
        meant.extend((1..1 << KINDS.len()).map(|chosen| {
            let kinds = KINDS
                .iter()
                .enumerate()
                .filter(|(at, _)| (chosen >> at) & 1 == 1);
            taken_back(&layer, &kinds.map(|(_, kind)| *kind).collect::<Vec<u8>>())
        }));
        layer = taken_back(&layer, KINDS);
    }
    meant.sort();
    meant.dedup();
    forms.extend(
        meant
            .into_iter()
            .filter(|m| m.len() >= 4 && m != secret.as_bytes()),
    );
    if secret.len() >= CODED_FROM {
        let hex = secret.bytes().map(|byte| format!("{byte:02x}"));
        forms.push(hex.collect::<String>().into_bytes());
    }
    forms
}

/// The fixed part of the base64 of any text with the secret, which may begin at each of three places of a group.
pub(super) fn base64(secret: &str) -> Vec<Vec<u8>> {
    if secret.len() < CODED_FROM {
        return Vec::new();
    }
    let at = |before: usize| {
        let text = [&vec![0; before], secret.as_bytes()].concat();
        let whole = STANDARD_NO_PAD.encode(&text).into_bytes();
        // Each letter stands for six bits: those that hold bits of neighbours, too, can be any.
        let (first, end) = ((before * 8).div_ceil(6), text.len() * 8 / 6);
        whole[first..end].to_vec()
    };
    (0..3).map(at).collect()
}

/// The URL-safe alphabet differs from the standard one in two letters.
pub(super) fn same_alphabet(byte: u8) -> u8 {
    match byte {
        b'-' => b'+',
        b'_' => b'/',
        other => other,
    }
}

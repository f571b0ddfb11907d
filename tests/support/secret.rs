//! The forms in which a server can give a secret back, and what must not be found of it anywhere.

use base64::Engine;
use base64::engine::general_purpose::{STANDARD, STANDARD_NO_PAD, URL_SAFE, URL_SAFE_NO_PAD};

fn each(text: &str, step: usize, write: impl Fn(char) -> String) -> String {
    let letters = text.chars().enumerate();
    let written = letters.map(|(at, c)| match at % step {
        0 => write(c),
        _ => c.to_string(),
    });
    written.collect()
}

fn percent(c: char) -> String {
    format!("%{:02X}", u32::from(c))
}

fn json(c: char) -> String {
    format!("\\u{:04x}", u32::from(c))
}

/// An ASCII secret as servers may write it, without those forms that begin with a backslash.
pub fn forms(secret: &str) -> Vec<String> {
    let upper = each(secret, 1, percent);
    let mut forms = vec![
        secret.to_owned(),
        secret.to_uppercase(),
        upper.to_lowercase(),
        each(secret, 2, percent),
        each(secret, 1, |c| {
            if c.is_ascii_alphanumeric() {
                c.to_string()
            } else {
                percent(c)
            }
        }),
        upper.replace('%', "%25"),
        upper,
        each(secret, 1, |c| format!("&#{};", u32::from(c))),
        secret.bytes().map(|b| format!("{b:02x}")).collect(),
    ];
    for text in [
        secret.to_owned(),
        format!("Bearer {secret}"),
        format!("user:{secret}"),
        format!("me:{secret}, and more"),
    ] {
        forms.push(STANDARD.encode(&text));
        forms.push(STANDARD_NO_PAD.encode(&text));
        forms.push(URL_SAFE.encode(&text));
        forms.push(URL_SAFE_NO_PAD.encode(&text));
    }
    forms
}

/// Those that are made of escapes of JSON, so that reading JSON brings the secret to light.
pub fn escaped(secret: &str) -> Vec<String> {
    vec![
        each(secret, 1, json),
        each(secret, 3, json),
        each(secret, 1, json).to_uppercase().replace("\\U", "\\u"),
        secret.replace('/', "\\/"),
        each(secret, 1, json).replace('\\', "\\\\"),
    ]
}

/// All forms one after the other, to be a string in JSON as it stands.
pub fn quoted(secrets: &[&str]) -> String {
    let all = secrets.iter().flat_map(|s| [forms(s), escaped(s)].concat());
    all.collect::<Vec<_>>().join(" | ")
}

/// Which form of the secrets is in some bytes, in any case of letters where that changes nothing.
pub fn leak(secrets: &[&str], bytes: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(bytes);
    let small = text.to_lowercase();
    secrets.iter().find_map(|secret| {
        let mut needles = [forms(secret), escaped(secret)].concat();
        // What stays the same wherever the secret begins in the text that is encoded.
        for before in 0..3 {
            let coded = STANDARD_NO_PAD.encode(format!("{}{secret}", &"xx"[..before.min(2)]));
            needles.push(coded[before + 2..coded.len() - 2].to_owned());
        }
        needles.push(secret[..secret.len() - 1].to_owned());
        needles.into_iter().find(|needle| {
            text.contains(needle.as_str())
                || (needle.contains(['%', '\\']) && small.contains(&needle.to_lowercase()))
        })
    })
}

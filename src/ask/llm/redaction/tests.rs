//! Tests of what counts as a secret, where it may be sent, and of secrets in all forms, split at every position.
#![allow(clippy::unwrap_used)]

use base64::Engine;
use base64::engine::general_purpose::{STANDARD, URL_SAFE, URL_SAFE_NO_PAD};

use super::super::endpoint::Endpoint;
use super::*;

const SECRETS: [&str; 4] = [
    "sk-test-0123456789abcdef",
    "pa/ss+w%41rd&x\\q?=~",
    "Grüße-2026 an alle",
    "aaaaaaaaaaaa",
];

fn secrets(text: &str) -> Secrets {
    Secrets::new(&[text.to_owned()])
}

/// Each letter, or every so manieth one, written by `write`.
fn each(text: &str, step: usize, write: impl Fn(char) -> String) -> String {
    let letters = text.chars().enumerate();
    let written = letters.map(|(at, c)| match at % step {
        0 => write(c),
        _ => c.to_string(),
    });
    written.collect()
}

fn percent(c: char) -> String {
    let mut buffer = [0; 4];
    let bytes = c.encode_utf8(&mut buffer).bytes();
    bytes.map(|byte| format!("%{byte:02X}")).collect()
}

fn json(c: char) -> String {
    let mut buffer = [0; 2];
    let units = c.encode_utf16(&mut buffer).iter();
    units.map(|unit| format!("\\u{unit:04x}")).collect()
}

/// Everything that a secret may be written as, and nothing is left of.
fn whole_forms(secret: &str) -> Vec<String> {
    let quoted = serde_json::to_string(secret).unwrap_or_default();
    let quoted = quoted.trim_matches('"');
    let again = serde_json::to_string(&each(secret, 1, json)).unwrap_or_default();
    vec![
        secret.to_owned(),
        secret.to_ascii_uppercase(),
        each(secret, 1, percent),
        each(secret, 1, percent).to_lowercase(),
        each(secret, 1, |c| {
            if c.is_ascii_alphanumeric() {
                c.to_string()
            } else {
                percent(c)
            }
        }),
        each(&each(secret, 1, percent), 3, percent),
        each(secret, 1, json),
        each(secret, 1, |c| json(c).to_uppercase().replace("\\U", "\\u")),
        again.trim_matches('"').to_owned(),
        each(quoted, 1, |c| c.to_string()),
        quoted.replace('/', "\\/"),
        each(secret, 1, |c| format!("&#{};", u32::from(c))),
        each(secret, 1, |c| format!("&#x{:X};", u32::from(c))),
        each(secret, 1, |c| format!("\\u{{{:x}}}", u32::from(c))),
        each(&each(secret, 1, json), 1, percent),
        secret.bytes().map(|b| format!("{b:02x}")).collect(),
        secret.bytes().map(|b| format!("{b:02X}")).collect(),
    ]
}

/// The base64 of texts that hold the secret, at each of the three places of a group.
fn coded_forms(secret: &str) -> Vec<String> {
    let texts = ["", "Bearer ", "user:", "xx", "\u{0}"].map(|before| format!("{before}{secret}"));
    let longer = texts.clone().map(|text| text + ", and more");
    let both = texts.iter().chain(&longer);
    let coded = both.flat_map(|text| {
        [
            STANDARD.encode(text),
            URL_SAFE.encode(text),
            URL_SAFE_NO_PAD.encode(text),
            STANDARD.encode(text).replace('/', "\\/"),
            STANDARD
                .encode(text)
                .replace('+', "%2B")
                .replace('/', "%2f"),
        ]
    });
    coded.collect()
}

fn in_pieces(secrets: &Secrets, text: &str, size: usize) -> String {
    let mut redactor = Redactor::new(secrets);
    let letters: Vec<char> = text.chars().collect();
    let pieces = letters.chunks(size).map(|c| c.iter().collect::<String>());
    let shown: String = pieces.map(|piece| redactor.push(&piece)).collect();
    shown + &redactor.end()
}

#[test]
fn every_form_goes_wherever_it_is_cut() {
    for secret in SECRETS {
        let secrets = secrets(secret);
        for form in whole_forms(secret) {
            let text = format!("Because <{form}> says so.");
            for size in 1..=text.chars().count() {
                let shown = in_pieces(&secrets, &text, size);
                assert_eq!(shown, "Because <[key]> says so.", "{text} by {size}");
            }
            assert!(secrets.are_in(&text));
        }
    }
}

#[test]
fn base64_goes_wherever_the_secret_begins_in_it() {
    for secret in SECRETS {
        let secrets = secrets(secret);
        for form in coded_forms(secret) {
            let text = format!("Because <{form}> says so.");
            let whole = in_pieces(&secrets, &text, text.len());
            assert_eq!(whole.matches("[key]").count(), 1, "{text}: {whole}");
            assert!(whole.starts_with("Because <") && whole.ends_with("> says so."));
            // At most a letter on each side still holds bits of it.
            let gone = (text.len() + 5).saturating_sub(whole.len());
            assert!(gone + 2 >= secret.len() * 4 / 3, "{text}: {whole}");
            for size in 1..=9 {
                assert_eq!(in_pieces(&secrets, &text, size), whole, "{text} by {size}");
            }
        }
    }
}

#[test]
fn usual_text_stays_as_it_is() {
    let all: Vec<String> = SECRETS.map(str::to_owned).to_vec();
    let secrets = Secrets::new(&all);
    let verdict = r#"{"collision": true, "obstacles": [{"id": 301, "risk_score": 1, "reason": "sk\u00e9 \"close\" \\ 5 %, a&b &amp; c/d"}]}"#;
    for text in [
        "",
        "é 車 🚗",
        verdict,
        "a % b %4 \\ & &# \\u00",
        "sk-test-0123456789abcde",
    ] {
        for size in 1..=text.chars().count().max(1) {
            assert_eq!(in_pieces(&secrets, text, size), text, "by {size}");
        }
        assert_eq!(Secrets::default().redact(text), text);
    }
}

#[test]
fn nothing_is_held_back_but_what_may_be_a_secret() {
    let secrets = secrets(SECRETS[0]);
    let mut redactor = Redactor::new(&secrets);
    for (piece, shown) in [
        ("Hello", "Hello"),
        ("is", "i"),
        ("o", "so"),
        ("5 %", "5 "),
        (" of", "% of"),
        (" ask sk-test-01", " ask "),
        ("2 of sk-", "sk-test-012 of "),
        ("TEST-0123456789abcdefg", "[key]g"),
    ] {
        assert_eq!(redactor.push(piece), shown, "{piece}");
    }
    assert_eq!(redactor.end(), "");
}

#[test]
fn what_is_held_back_is_bounded() {
    let secrets = secrets("aaaaaaaaaaaa");
    for text in ["a", "\\", "%25", "\\u0061", "&#97;", "\\\\u0061", "YWFh"] {
        let mut redactor = Redactor::new(&secrets);
        let mut shown = 0;
        for _ in 0..20_000 {
            shown += redactor.push(text).len();
            assert!(
                redactor.held.len() < 2000,
                "{text}: {}",
                redactor.held.len()
            );
        }
        if secrets.are_in(&text.repeat(12)) {
            assert!(shown < 100, "{text}: {shown}");
        }
    }
}

#[test]
fn secrets_that_overlap_are_one_and_neighbours_are_two() {
    let secrets = Secrets::new(&["sk-sk-abé1".to_owned(), "abé1-and-more".to_owned()]);
    for (text, shown) in [
        ("a sk-sk-abé1 b", "a [key] b"),
        ("sk-sk-sk-abé1", "sk-[key]"),
        ("sk-sk-abé1sk-sk-abé1", "[key][key]"),
        ("sk-sk-abé1-and-more!", "[key]!"),
        ("sk-sk-abé1-and-mo!", "[key]-and-mo!"),
        ("ask sk-s", "ask sk-s"),
        ("sk-sk-abe", "sk-sk-abe"),
    ] {
        for size in 1..=text.len() {
            assert_eq!(in_pieces(&secrets, text, size), shown, "{text} by {size}");
        }
    }
}

#[test]
fn a_text_that_breaks_off_in_a_secret_does_not_show_most_of_it() {
    let secrets = secrets(SECRETS[0]);
    for (text, shown) in [
        ("it is sk-test-0123456789abcde", "it is [key]"),
        ("it is sk-test-", "it is [key]"),
        ("it is sk-test", "it is sk-test"),
        ("it is sk%2Dtest%2D012%3", "it is [key]"),
        ("c2stdGVzdC0wMTIz", "[key]"),
        ("it is", "it is"),
    ] {
        assert_eq!(secrets.redact_cut(text), shown);
    }
    assert_eq!(secrets.redact("it is sk-test-01234"), "it is sk-test-01234");
}

fn endpoint(base_url: &str) -> Endpoint {
    Endpoint::new("lab", base_url)
}

fn with_key(base_url: &str, key: &str) -> Endpoint {
    Endpoint {
        key: Some(key.into()),
        ..endpoint(base_url)
    }
}

fn with_header(base_url: &str, value: &str) -> Endpoint {
    Endpoint {
        headers: vec![("x-team".into(), value.into())],
        ..endpoint(base_url)
    }
}

#[test]
fn keys_are_secrets_unless_they_are_placeholders() {
    for (key, hidden) in [
        ("sk-0123456789", true),
        (" sk-0123456789 \n", true),
        ("not-a-key", true),
        ("k3y9", true),
        ("EMPTY", false),
        ("none", false),
        ("ollama", false),
        ("k1", false),
        ("", false),
    ] {
        let secrets = with_key("https://h", key).secrets();
        assert_eq!(secrets.are_in(&format!("it is {key}!")), hidden, "{key}");
    }
}

#[test]
fn headers_and_addresses_hold_secrets_and_other_things() {
    for (value, text, hidden) in [
        ("team-perception", "team-perception", true),
        ("1", "1", false),
        ("true", "true", false),
        ("v1.2.3", "v1.2.3", false),
        ("2024-10-21", "on 2024-10-21", false),
        ("12345678", "12345678 m", false),
        ("1234567890123456", "1234567890123456", true),
        ("Bearer sk-0123456789", "of sk-0123456789", true),
        ("Basic bWU6aHVudGVyMjI=", "it is hunter22", true),
        ("a=1; session=tok3n-in-cookie", "tok3n-in-cookie", true),
        ("Lane Change Study", "the study of lanes", false),
    ] {
        let secrets = with_header("https://h", value).secrets();
        assert_eq!(secrets.are_in(text), hidden, "{value}: {text}");
    }
    let url = "https://me:hunter%2F22@h/v1?api-version=2024-10-21-preview&key=topsecret&n=5";
    let secrets = endpoint(url).secrets();
    for text in ["hunter%2F22", "hunter/22", "bWU6aHVudGVyLzIy", "topsecret"] {
        assert!(secrets.are_in(text), "{text}");
    }
    for text in ["2024-10-21-preview", "me", "5", "https://h/v1"] {
        assert!(!secrets.are_in(text), "{text}");
    }
    assert!(
        endpoint("https://tok3n-for-all@h")
            .secrets()
            .are_in("tok3n-for-all")
    );
    assert!(!format!("{secrets:?}").contains("secret\""));
}

#[test]
fn secrets_go_unencrypted_to_this_machine_alone() {
    const KEY: &str = "sk-0123456789";
    for here in [
        "http://127.0.0.1:8000",
        "http://127.9.9.9",
        "http://localhost:8000/v1",
        "http://LOCALHOST",
        "http://[::1]:8000",
        "http://[::ffff:127.0.0.1]",
        "https://lab.example",
    ] {
        assert_eq!(with_key(here, KEY).keeps_secrets(), Ok(()), "{here}");
    }
    for elsewhere in [
        "http://lab.example",
        "http://10.0.0.7:8000/v1",
        "http://localhost.lab.example",
        "http://127.0.0.1.lab.example",
        "http://[2001:db8::1]",
    ] {
        assert_eq!(
            endpoint(elsewhere).keeps_secrets(),
            Ok(()),
            "nothing to send"
        );
        let mut all = [
            with_key(elsewhere, KEY),
            with_header(elsewhere, "1"),
            endpoint(&elsewhere.replacen("//", "//me:pw@", 1)),
            endpoint(&format!("{elsewhere}?token=in-the-query")),
            Endpoint {
                key_command: Some(crate::llm::KeyCommand::Shell("pass lab".into())),
                ..endpoint(elsewhere)
            },
        ];
        for endpoint in &mut all {
            let why = endpoint.keeps_secrets().unwrap_err().to_string();
            for words in ["unencrypted", "https://", "allow_http", "[provider.lab]"] {
                assert!(why.contains(words), "{words}: {why}");
            }
            assert!(!why.contains(KEY) && !why.contains("in-the-query"), "{why}");
            endpoint.allow_http = true;
            assert_eq!(endpoint.keeps_secrets(), Ok(()));
        }
        assert_eq!(with_key(elsewhere, " \n").keeps_secrets(), Ok(()));
    }
    let version = endpoint("http://lab.example?api-version=2024-10-21");
    assert_eq!(version.keeps_secrets(), Ok(()));
}

//! Tests of what counts as a secret, and where it may be sent.
#![allow(clippy::unwrap_used)]
use super::super::super::endpoint::Endpoint;

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

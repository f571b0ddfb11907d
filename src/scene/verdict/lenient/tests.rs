//! Tests of typical mistakes of models, one by one.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use serde_json::json;

use super::*;

fn one(text: &str) -> JsonPiece {
    let mut found = read(text);
    assert_eq!(found.len(), 1, "{text}: {found:?}");
    found.remove(0)
}

#[test]
fn valid_json_is_read_exactly_and_without_repairs() {
    let texts = [
        r#"{"a": [1, -2.5e3, true, null, "x"], "b": {"c": {}}, "d": "say \"no\", or {yes} // #"}"#,
        r#"{ "a" : "", "b":"\u00e9\ud83d\ude97\\", "c": "x , \"y\" : z", "it's": "“q”, 'r': }" }"#,
        "{\"a\":\n\n\t1 ,\r\n\"b\":\"c\"                                                                                                        ,\"d\":0}",
        r#"[{"a": 1}, {"a": [[], [[1, 2], [3]]]}]"#,
    ];
    for text in texts {
        let piece = one(&format!("Before {{that}}.\n```json\n{text}\n```\nAfter."));
        assert_eq!(piece.value, serde_json::from_str::<Value>(text).unwrap());
        assert!(
            piece.repairs.is_empty() && piece.end == End::Whole,
            "{piece:?}"
        );
    }
}

#[test]
fn slips_are_put_right_and_named() {
    use Repair::*;
    let cases: &[(&str, Value, &[Repair])] = &[
        (
            "{\"a\": 1, // one\n# two\n /* three */ \"b\": 2}",
            json!({"a": 1, "b": 2}),
            &[Comments],
        ),
        (
            r#"{"a": [1, 2,], "b": 3,}"#,
            json!({"a": [1, 2], "b": 3}),
            &[ExtraCommas],
        ),
        (
            r#"{"a": 1,, "b": 2}"#,
            json!({"a": 1, "b": 2}),
            &[ExtraCommas],
        ),
        (
            "{\"a\": 1\n \"b\": \"x\" \"c\": [{} {}]}",
            json!({"a": 1, "b": "x", "c": [{}, {}]}),
            &[MissingCommas],
        ),
        (
            "{{\"a\": {{\"b\": \"c\"}},\n \"d\": 1}}",
            json!({"a": {"b": "c"}, "d": 1}),
            &[DoubledBraces],
        ),
        (
            "{'a': 'it's', 'b': 'x'}",
            json!({"a": "it's", "b": "x"}),
            &[OtherQuotes, InnerQuotes],
        ),
        ("{“a”: “b”}", json!({"a": "b"}), &[OtherQuotes]),
        (
            "{\"a\": \"open,\n\"b\": \"shut\"}",
            json!({"a": "open", "b": "shut"}),
            &[MissingCommas, MissingQuotes],
        ),
        (
            "{\"a: 1,\n b\": 2, \"c\": d\"}",
            json!({"a": 1, "b": 2, "c": "d"}),
            &[MissingQuotes],
        ),
        (
            r#"{"a": "the "late", as it were, turn", "b": 1}"#,
            json!({"a": "the \"late\", as it were, turn", "b": 1}),
            &[InnerQuotes],
        ),
        (
            "{a: 1, b_c: 2, d-e: 3}",
            json!({"a": 1, "b_c": 2, "d-e": 3}),
            &[BareKeys],
        ),
        (
            r#"{"a": high risk, "b": x}"#,
            json!({"a": "high risk", "b": "x"}),
            &[BareWords],
        ),
        (
            r#"{"a": None, "b": True, "c": FALSE}"#,
            json!({"a": null, "b": true, "c": false}),
            &[Literals],
        ),
        (
            r#"{"a": NaN, "b": -Infinity, "c": 1e999}"#,
            json!({"a": null, "b": null, "c": null}),
            &[NotANumber],
        ),
        (
            r#"{"a": +1, "b": .5, "c": 2., "d": 007}"#,
            json!({"a": 1.0, "b": 0.5, "c": 2.0, "d": 7.0}),
            &[Numbers],
        ),
        (
            "{\"a\": \"x\ny\tz\"}",
            json!({"a": "x\ny\tz"}),
            &[ControlCharacters],
        ),
        (
            r#"{"a": "\(x\) \u12 \'"}"#,
            json!({"a": "\\(x\\) \\u12 '"}),
            &[Escapes],
        ),
        (
            r#"{"a": , "b": }"#,
            json!({"a": null, "b": null}),
            &[MissingValues],
        ),
        (
            r#"{"a": [1, 2}, "b": 3}"#,
            json!({"a": [1, 2]}),
            &[Brackets],
        ),
        (r#"{"a": (1, 2)}"#, json!({"a": [1, 2]}), &[Brackets]),
        (r#"{"a": 1, "a": 2}"#, json!({"a": 2}), &[DoubledKeys]),
    ];
    for (text, value, repairs) in cases {
        let piece = one(text);
        assert_eq!(piece.value, *value, "{text}");
        assert_eq!(piece.repairs, repairs.iter().copied().collect(), "{text}");
    }
}

#[test]
fn what_is_complete_before_a_cut_is_kept() {
    let text = r#"{"a": true, "b": [{"c": 1, "d": "e"}, {"c": 12, "d": "f"}], "g": "the end"}"#;
    let cases = [
        (r#"{"a": tr"#, json!({})),
        (
            r#"{"a": true, "b": [{"c": 1, "d": "e"}, {"c": 1"#,
            json!({"a": true, "b": [{"c": 1, "d": "e"}, {}]}),
        ),
        (
            r#"{"a": true, "b": [{"c": 1, "d": "e"}, {"c": 12, "d": "f"}], "g": "the"#,
            json!({"a": true, "b": [{"c": 1, "d": "e"}, {"c": 12, "d": "f"}]}),
        ),
    ];
    for (cut, value) in cases {
        assert!(text.starts_with(cut));
        let piece = one(cut);
        assert_eq!((piece.value, piece.end), (value, End::CutOff), "{cut}");
    }
    for length in 1..text.len() {
        let found = read(&text[..length]);
        assert_eq!(found.last().map(|p| p.end), Some(End::CutOff), "{length}");
    }
}

#[test]
fn prose_and_mathematics_are_no_json() {
    for text in [
        r"\frac{12.3}{4.5} = \text{TTC}, f(x) = {x | x > 0}, [12], [see 3], {}",
        "{ {{{ [[[ ((( }}} ]]] )))",
        "use {obstacle} and {{ ego }}",
        "",
    ] {
        assert_eq!(read(text), vec![], "{text}");
    }
    let found = read("TTC = \\frac{19.5}{4.65}; in short {see: below {\"a\": 1}");
    assert_eq!(found.last().unwrap().value, json!({"a": 1}));
    let found = read("{see: below\n```json\n{\"a\": 1}\n```");
    assert_eq!(found.last().unwrap().value, json!({"a": 1}));
}

#[test]
fn bombs_are_read_in_linear_time() {
    let seeds = [
        "{",
        "[",
        "{\"a\":",
        "[{\"a\":",
        "{\"a\":[",
        "{\"",
        "{'a",
        "\"",
        "{a:\"",
        "{\"a\":\"\"b\"",
        "/*",
        "{/*",
        "{//\n",
        "{\"a\": \"x\",\n",
        "{a:(",
        "}",
        "{\"a\"",
        "{a ",
        "{\"a\":\\",
        "{“",
        "{a:'",
        "{\"a\":1,\"",
        "[[1",
    ];
    for seed in seeds {
        for prefix in ["", "{\"a\": \"", "{a: ", "{\"a\": ["] {
            let text = format!("{prefix}{}", seed.repeat(100_000 / seed.len()));
            let begun = std::time::Instant::now();
            let found = read(&text);
            let taken = begun.elapsed();
            assert!(
                taken.as_secs() < 5,
                "{prefix}{seed}: {taken:?}, {}",
                found.len()
            );
        }
    }
}

/// Any JSON value, with texts that look like the ends of texts.
fn values() -> impl Strategy<Value = Value> {
    let text = "[a-c0-9 \"'“”‘’,:;{}\\[\\]()/\\\\*#`\n\té🚗-]{0,12}";
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        (-1e6..1e6_f64).prop_map(Value::from),
        text.prop_map(Value::from),
    ];
    leaf.prop_recursive(5, 40, 5, move |inner| {
        let list = proptest::collection::vec(inner.clone(), 0..5).prop_map(Value::from);
        let entries = proptest::collection::vec((text, inner), 0..5);
        prop_oneof![
            list,
            entries.prop_map(|e| Value::Object(e.into_iter().collect()))
        ]
    })
}

proptest! {
    #[test]
    fn any_valid_json_is_read_exactly(value in values(), pretty: bool) {
        let value = json!({"first": value});
        let text = if pretty { format!("{value:#}") } else { value.to_string() };
        let piece = one(&format!("So:\n```json\n{text}\n```\n"));
        prop_assert_eq!((piece.value, piece.end), (value, End::Whole));
        prop_assert_eq!(piece.repairs, BTreeSet::new());
    }
}

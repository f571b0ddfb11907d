//! The fifty sentences of `tests/find/sentences.txt`, and what holds for any sentence.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use super::Sentence;
use super::lexicon::documented;
use crate::workflow::Filter;

const SENTENCES: &str = include_str!("../../../tests/find/sentences.txt");

/// A sentence, the filter that is meant, and the words without a term.
fn cases() -> Vec<(&'static str, &'static str, &'static str)> {
    let blocks = SENTENCES.split("\n\n").skip(1);
    let case = |block: &'static str| {
        let mut lines = block.trim().lines();
        let sentence = lines.next().unwrap();
        let filter = lines.next().unwrap().strip_prefix("=> ").unwrap();
        let unknown = lines.next().and_then(|line| line.strip_prefix("?? "));
        (sentence, filter, unknown.unwrap_or_default())
    };
    blocks.map(case).collect()
}

fn terms(filter: &str) -> BTreeSet<String> {
    let sorted = |term: &str| match term.split_once(':') {
        Some((key, values)) => {
            let values: BTreeSet<&str> = values.split(',').collect();
            format!("{key}:{}", values.into_iter().collect::<Vec<_>>().join(","))
        }
        None => term.to_string(),
    };
    filter.split(' ').map(sorted).collect()
}

#[test]
fn of_fifty_sentences_at_least_45_become_the_filter_that_is_meant() {
    let cases = cases();
    assert_eq!(cases.len(), 50);
    let mut wrong = Vec::new();
    for (sentence, filter, unknown) in &cases {
        let read = Sentence::read(sentence);
        let missed = read.not_understood.join(" ");
        if terms(&read.filter) != terms(filter) || missed != *unknown {
            wrong.push(format!(
                "{sentence}\n  is    {} ?? {missed}\n  meant {filter} ?? {unknown}",
                read.filter
            ));
        }
    }
    println!(
        "{} of {} as meant\n{}",
        cases.len() - wrong.len(),
        cases.len(),
        wrong.join("\n")
    );
    assert!(wrong.len() <= 5, "{}", wrong.join("\n"));
}

#[test]
fn every_filter_is_one_that_the_filter_language_reads() {
    let made = cases().into_iter().map(|(s, ..)| Sentence::read(s).filter);
    let meant = cases().into_iter().map(|(_, f, _)| f.to_string());
    let phrases = documented().into_iter().map(|(_, gives)| gives);
    let phrases = phrases.filter(|gives| gives.contains([':', '<']));
    for filter in made.chain(meant).chain(phrases) {
        let read = Filter::read_for_windows(&filter);
        assert!(
            read.wrong.is_empty() && !read.incomplete,
            "{filter}: {:?}",
            read.wrong
        );
    }
}

#[test]
fn a_word_without_meaning_is_named_wherever_it_stands() {
    for (sentence, _, unknown) in cases() {
        let words: Vec<&str> = sentence.split(' ').collect();
        for at in [0, words.len()] {
            let mut words = words.clone();
            words.insert(at, "qwertz");
            let read = Sentence::read(&words.join(" "));
            let missed = read.not_understood.join(" ");
            assert!(missed.contains("qwertz"), "{words:?}");
            let rest = missed.replace("qwertz", " ");
            let rest: Vec<&str> = rest.split_whitespace().collect();
            assert_eq!(rest.join(" "), unknown, "{words:?}");
        }
    }
}

#[test]
fn no_input_breaks_it() {
    for odd in [
        "",
        "  ",
        "not",
        "under",
        "between 1",
        "1",
        "< >",
        "=",
        "<=",
        "tagged",
        "… ½ \u{0} 🙂",
        "a metre and",
        "not not cut-ins",
        "high",
        "between 1 and",
        "at least",
    ] {
        let _ = Sentence::read(odd);
    }
    assert_eq!(Sentence::read("high speed").not_understood, ["high speed"]);
    assert_eq!(Sentence::read("TTC on motorways").not_understood, ["TTC"]);
    assert_eq!(Sentence::read("gap below 1 s").filter, "time_gap<1");
}

//! The fifty sentences of `tests/find/sentences.txt`, and what holds for any sentence.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use super::Sentence;
use super::lexicon::documented;
use crate::Filter;

const SENTENCES: &str = include_str!("../../../tests/find/sentences.txt");
const MORE: &str = include_str!("../../../tests/find/more_sentences.txt");

type Case = (&'static str, &'static str, &'static str);

/// A sentence, the filter that is meant, and the words without a term.
fn cases_of(text: &'static str) -> Vec<Case> {
    let blocks = text.split("\n\n").skip(1);
    let case = |block: &'static str| {
        let mut lines = block.trim().lines();
        let sentence = lines.next().unwrap();
        let filter = lines.next().unwrap().strip_prefix("=> ").unwrap();
        let unknown = lines.next().and_then(|line| line.strip_prefix("?? "));
        (sentence, filter, unknown.unwrap_or_default())
    };
    blocks.map(case).collect()
}

fn cases() -> Vec<Case> {
    cases_of(SENTENCES)
}

fn missed(read: &Sentence) -> String {
    let parts = read.not_understood.iter().map(|part| part.words.as_str());
    parts.collect::<Vec<_>>().join(" ")
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

/// Sentences that do not become what is meant.
fn misread(cases: &[Case]) -> Vec<String> {
    let mut wrong = Vec::new();
    for (sentence, filter, unknown) in cases {
        let read = Sentence::read(sentence);
        let missed = missed(&read);
        if terms(&read.filter) != terms(filter) || missed != *unknown {
            wrong.push(format!(
                "{sentence}\n  is    {} ?? {missed}\n  meant {filter} ?? {unknown}",
                read.filter
            ));
        }
    }
    wrong
}

#[test]
fn of_fifty_sentences_at_least_45_become_the_filter_that_is_meant() {
    let cases = cases();
    assert_eq!(cases.len(), 50);
    let wrong = misread(&cases);
    println!("{} of 50 as meant", cases.len() - wrong.len());
    assert!(wrong.len() <= 5, "{}", wrong.join("\n"));
}

#[test]
fn sentences_that_were_misread_once_become_the_filter_that_is_meant() {
    let wrong = misread(&cases_of(MORE));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_filter_is_one_that_the_filter_language_reads() {
    let all = || cases().into_iter().chain(cases_of(MORE));
    let made = all().map(|(s, ..)| Sentence::read(s).filter);
    let meant = all().map(|(_, f, _)| f.to_string());
    let phrases = documented()
        .into_iter()
        .map(|(_, gives)| gives)
        .filter(|gives| gives.contains([':', '<']));
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
            let missed = missed(&read);
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
        "or",
        "no or",
        "tagged left",
        "minimum",
        "from behind a",
        "!",
        "max max TTC",
        "TTC and PET and",
        "no between 1 and 2 s TTC",
        "vehicles and",
        "not at",
        ":",
        "a:b",
        "-",
    ] {
        let _ = Sentence::read(odd);
    }
    assert_eq!(missed(&Sentence::read("high speed")), "high speed");
    assert_eq!(missed(&Sentence::read("TTC on motorways")), "TTC");
    assert_eq!(Sentence::read("gap below 1 s").filter, "time_gap<1");
}

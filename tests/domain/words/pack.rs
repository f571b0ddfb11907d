//! The pack of templates that asks as "From Words to Collisions" asks.

use nearmiss::description::Form;
use nearmiss::prompts::{Pack, Prompt};
use nearmiss::verdict::{Task, parse};

use crate::words::templates::{filled, of_pack};

#[test]
fn every_combination_has_its_parts_in_the_papers_order() {
    let files = of_pack(Pack::Paper);
    assert_eq!(files.len(), 4, "two tasks, two frames");
    for file in files {
        let mut texts = Vec::new();
        for bits in 0..8 {
            let Prompt { system, user } = filled(&file, bits, Form::Prose);
            let at = |words: &str| system.find(words);
            let measures = at("## Measures and risk scores");
            assert_eq!(measures.is_some(), bits & 1 != 0, "{file}");
            assert_eq!(at("## Examples").is_some(), bits & 4 != 0, "{file}");
            assert_eq!(
                user.contains("Reason step by step"),
                bits & 2 != 0,
                "{file}"
            );
            let order = [at("You are"), measures, at("## Examples"), at("## Output")];
            let order: Vec<usize> = order.into_iter().flatten().collect();
            assert!(order.is_sorted() && at("## Output").is_some(), "{file}");
            let text = format!("{system}\n{user}");
            assert!(!text.contains("{{") && !text.contains("{%") && !text.contains("\n\n\n"));
            for case in ["Laterally aligned", "Longitudinally aligned", "TTC", "MDC"] {
                assert!(bits & 1 == 0 || system.contains(case), "{file}: {case}");
            }
            texts.push(text);
        }
        texts.sort();
        texts.dedup();
        assert_eq!(texts.len(), 8, "{file}");
    }
}

#[test]
fn its_examples_are_read_as_a_yes_and_a_no() {
    for file in of_pack(Pack::Paper) {
        let task = if file.contains("collision") {
            Task::Collision
        } else {
            Task::Safety
        };
        let system = filled(&file, 4, Form::Prose).system;
        let answers = system.lines().filter(|l| l.starts_with("{\"Coll"));
        let said: Vec<bool> = answers
            .map(|answer| parse(task, answer).unwrap().verdict.dangerous)
            .collect();
        assert_eq!(said, [true, false], "{file}");
    }
}

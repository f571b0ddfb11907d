//! What the reflecting model is told: the template, some of its wrong answers beside the truth, rules, earlier tries.

use super::ask::Graded;
use super::candidate::Candidate;
use super::prepare::TunePlan;
use super::truth_words::truth_words;
use nearmiss_ask::llm::{Message, Role};
use nearmiss_ask::prompts::Template;
use nearmiss_study::evaluation::Question;

/// Wrong answers that are shown at most.
pub(super) const SHOWN: usize = 4;

/// Characters of a question that are shown, the last ones: it ends with the present.
const QUESTION: usize = 5000;

/// Characters of a reasoning, and of an answer.
const REASONING: usize = 1500;

/// Earlier tries that are told, the last ones.
const TRIES: usize = 8;

const SYSTEM: &str = "\
You improve the prompt template of a study in which a language model judges driving scenes. You see the template, some \
questions that it made, the model's wrong answers, and what is exactly true.

Find out what the template lets the model get wrong in general, then write a better template.

Rules:
- The template is Jinja. Keep both blocks, `system` and `user`; keep `{{ description }}` and the include that says the \
form of the answer. Use no variable that it does not use already. Leave conditions on `cp`, `cot` and `icl` in place.
- The answer is read by a program: change neither its keys nor their meaning.
- The new template is measured on other scenes. Write rules that hold for any scene: no ids, no names, no numbers of the \
scenes below, and nothing about how these end.
- Change what matters, and leave the rest as it is. Every question pays for each word of the template.

Answer with one JSON object: `diagnosis` (what goes wrong, in general), `change` (what you change, in one sentence), \
`template` (the whole new text after the front matter).";

/// A wrong answer to be shown.
pub(super) struct WrongAnswer<'a> {
    /// The place of its question.
    pub place: usize,
    /// The question as the parent asks it.
    pub question: &'a Question,
    /// The answer.
    pub graded: &'a Graded,
}

/// The messages.
pub(super) fn messages(
    plan: &TunePlan,
    parent: &Candidate,
    (wrong, (right, not_right)): (&[WrongAnswer<'_>], (usize, usize)),
    tries: &[String],
) -> Vec<Message> {
    let mut text = format!(
        "# The template, after its front matter\n\n```\n{}\n```\n",
        Template::body_of(&parent.source).trim()
    );
    for name in plan.library.included(&parent.source) {
        let fragment = plan
            .library
            .fragments()
            .get(name)
            .map_or("", String::as_str);
        text += &format!("\n# It includes {name}\n\n```\n{}\n```\n", fragment.trim());
    }
    let way = &plan.way;
    let techniques = way.techniques.map(|t| t.to_string()).unwrap_or_default();
    text += &format!(
        "\n# How it is asked\n\nTask {}, techniques {techniques}. Of {} questions {right} were answered right.\n",
        way.task.name(),
        right + not_right
    );
    for (number, one) in wrong.iter().take(SHOWN).enumerate() {
        text += &format!("\n# Wrong answer {}\n\n", number + 1);
        text += &wrong_answer(plan, one);
    }
    if !tries.is_empty() {
        text += "\n# Tried before; propose something else\n\n";
        for one in &tries[tries.len().saturating_sub(TRIES)..] {
            text += &format!("- {one}\n");
        }
    }
    vec![
        Message::new(Role::System, SYSTEM),
        Message::new(Role::User, text),
    ]
}

fn wrong_answer(plan: &TunePlan, one: &WrongAnswer<'_>) -> String {
    let graded = one.graded;
    let mut text = format!(
        "Question:\n\n{}\n\n",
        last(&one.question.prompt.user, QUESTION)
    );
    if !graded.reasoning.trim().is_empty() {
        text += &format!(
            "Reasoning of the model:\n\n{}\n\n",
            last(&graded.reasoning, REASONING)
        );
    }
    text += &format!("Its answer:\n\n{}\n\n", first(&graded.text, REASONING));
    if let Some(why) = &graded.unreadable {
        text += &format!("The answer cannot be read: {why}\n\n");
    }
    text += &format!(
        "True is {}\n",
        truth_words(plan, &plan.questions[one.place])
    );
    text
}

/// The most that the messages can have beside the template and what it includes, in characters.
pub(super) const LONGEST: usize =
    SYSTEM.len() + SHOWN * (QUESTION + 2 * REASONING + 400) + TRIES * 400 + 400;

/// The first characters of a text.
fn first(text: &str, most: usize) -> String {
    let text = text.trim();
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}

/// The last characters of a text.
fn last(text: &str, most: usize) -> String {
    let text = text.trim();
    match text.char_indices().rev().nth(most) {
        Some((start, c)) => format!("…{}", &text[start + c.len_utf8()..]),
        None => text.to_string(),
    }
}

/// A change in a line, for later requests.
pub(super) fn in_a_line(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    first(&words.join(" "), 200)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_cut_at_characters() {
        assert_eq!(
            (first("äöü", 2).as_str(), last("äöü", 2).as_str()),
            ("äö…", "…öü")
        );
        assert_eq!(
            (first(" ab ", 2).as_str(), last(" ab ", 2).as_str()),
            ("ab", "ab")
        );
        assert_eq!(in_a_line(" a\n b\t c "), "a b c");
    }
}

//! What the reflecting model is told: the template, wrong answers beside the truth, rules, earlier tries; and asking it.

use std::sync::Arc;

use nearmiss_ask::llm::{Message, Request, Role, Schema};
use nearmiss_ask::prompts::Template;
use nearmiss_scene::verdict::Task;
use nearmiss_store::Store;
use nearmiss_study::evaluation::{Label, Labelled, ModelJudge, Question};

use super::ask::{Graded, TuneAbort};
use super::candidate::{self, Candidate};
use super::outcome::Usage;
use super::prepare::{TunePlan, TuneQuestion};
use crate::ask::{TextError, TextQuestion};
use crate::batch::BatchControl;

/// Wrong answers that are shown at most.
pub(super) const MAX_SHOWN: usize = 4;

/// Characters of a question that are shown, the last ones: it ends with the present.
const QUESTION_LENGTH: usize = 5000;

/// Characters of a reasoning, and of an answer.
const REASONING_LENGTH: usize = 1500;

/// Earlier tries that are told, the last ones.
const MAX_TRIES: usize = 8;

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
        Template::strip_front_matter(&parent.source).trim()
    );
    for name in plan.library.included(&parent.source) {
        let fragment = plan
            .library
            .fragments()
            .get(name)
            .map_or("", String::as_str);
        text += &format!("\n# It includes {name}\n\n```\n{}\n```\n", fragment.trim());
    }
    let configuration = &plan.configuration;
    let techniques = configuration
        .techniques
        .map(|t| t.to_string())
        .unwrap_or_default();
    text += &format!(
        "\n# How it is asked\n\nTask {}, techniques {techniques}. Of {} questions {right} were answered right.\n",
        configuration.task.name(),
        right + not_right
    );
    for (number, one) in wrong.iter().take(MAX_SHOWN).enumerate() {
        text += &format!("\n# Wrong answer {}\n\n", number + 1);
        text += &wrong_answer(plan, one);
    }
    if !tries.is_empty() {
        text += "\n# Tried before; propose something else\n\n";
        for one in &tries[tries.len().saturating_sub(MAX_TRIES)..] {
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
        last(&one.question.prompt.user, QUESTION_LENGTH)
    );
    if !graded.reasoning.trim().is_empty() {
        text += &format!(
            "Reasoning of the model:\n\n{}\n\n",
            last(&graded.reasoning, REASONING_LENGTH)
        );
    }
    text += &format!(
        "Its answer:\n\n{}\n\n",
        first(&graded.text, REASONING_LENGTH)
    );
    if let Some(why) = &graded.unreadable {
        text += &format!("The answer cannot be read: {why}\n\n");
    }
    text += &format!(
        "True is {}\n",
        truth_sentence(plan, &plan.questions[one.place])
    );
    text
}

/// The most that the messages can have beside the template and what it includes, in characters.
pub(super) const MAX_LENGTH: usize = SYSTEM.len()
    + MAX_SHOWN * (QUESTION_LENGTH + 2 * REASONING_LENGTH + 400)
    + MAX_TRIES * 400
    + 400;

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

/// Who proposes templates.
pub(super) struct Reflector {
    pub model: Box<ModelJudge>,
    pub store: Arc<Store>,
    pub control: BatchControl,
}

impl Reflector {
    /// The request that is sent.
    pub fn request(&self, messages: Vec<Message>) -> Request {
        Request {
            model: self.model.name.clone(),
            messages,
            parameters: self.model.parameters,
            schema: Some(Schema {
                is_bounded: false,
                name: "template_proposal".into(),
                schema: candidate::schema(),
            }),
            tools: None,
        }
    }

    /// The answer to these messages: that of the store, or a new one; or why none came.
    ///
    /// # Errors
    /// See [`TuneAbort`].
    pub async fn ask(
        &self,
        messages: Vec<Message>,
        sample: u32,
        usage: &mut Usage,
    ) -> Result<Result<String, String>, TuneAbort> {
        let question = TextQuestion::new(&self.model, self.request(messages), sample);
        if let Some(found) = question.stored(&self.store)? {
            usage.reflections_stored += 1;
            return Ok(found);
        }
        if self.control.is_stopped() {
            return Err(TuneAbort::Interrupted);
        }
        match question.ask(&self.store).await {
            Ok((answer, _)) => {
                usage.reflections += 1;
                Ok(answer)
            }
            Err(TextError::Failed(why)) => Ok(Err(why)),
            Err(TextError::Stopped(why)) => Err(TuneAbort::Stopped(why)),
            Err(TextError::Store(error)) => Err(TuneAbort::Store(error)),
        }
    }
}

/// The truth about a question in a sentence.
pub(super) fn truth_sentence(plan: &TunePlan, asked: &TuneQuestion) -> String {
    let case = &asked.question.case;
    let whom = match asked.critical.as_slice() {
        [] => "another body".to_string(),
        [one] => format!("obstacle {one}"),
        several => {
            let ids: Vec<String> = several.iter().map(ToString::to_string).collect();
            format!("obstacles {}", ids.join(", "))
        }
    };
    let extreme = Task::HIGH_RISK;
    match (asked.truth, case.task) {
        (Label::Collision(_), _) if plan.by_score => {
            format!("yes: the exact risk score of {whom} is {extreme} or lower")
        }
        (Label::Safe, _) if plan.by_score => {
            format!("no: no obstacle has an exact risk score of {extreme} or lower")
        }
        (Label::Collision(_), Task::Safety) => {
            let label = Some(asked.truth);
            let contact = Labelled::new(&case.scene, label).contact;
            let after =
                contact.map(|step| (step - case.window.last()) as f64 * case.scene.scenario.dt());
            match after.filter(|seconds| *seconds > 0.0) {
                Some(seconds) => format!(
                    "yes: the ego's body touches {whom}, first {seconds:.1} s after the last described moment"
                ),
                None => format!("yes: the ego's body touches {whom}"),
            }
        }
        (Label::Safe, Task::Safety) => format!(
            "no: the ego's body touches no other body within {} s after the last described moment",
            case.horizon
        ),
        (Label::Collision(_), _) => format!("yes: the ego's body touches that of {whom}"),
        (Label::Safe, _) => "no: no body touches the ego's at any step or between two".to_string(),
    }
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

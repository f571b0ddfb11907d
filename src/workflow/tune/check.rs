//! Whether a proposed template may be asked with.

use rayon::prelude::*;

use super::candidate::Candidate;
use super::prepare::TunePlan;
use nearmiss_ask::prompts::{Library, Template, answer_form};
use nearmiss_scene::verdict;
use nearmiss_study::evaluation::{Question, prepare};

/// A template that may be asked with, and all dev questions as it asks them.
pub(super) struct Checked {
    pub source: String,
    pub hash: String,
    pub questions: Vec<Question>,
}

/// Checks the text of a proposal: it is a template, no known one, keeps description and form of the answer in the
/// messages of all dev scenarios, and has nothing of these scenarios in itself.
///
/// # Errors
/// Why it may not be asked with, in words that name no scenario but one it names itself.
pub(super) fn check(
    plan: &TunePlan,
    text: &str,
    parent: &Candidate,
    known: &[Candidate],
) -> Result<Checked, String> {
    let body = Template::body_of(text.trim_start());
    let source = plan.template.with_body(body);
    let template = Template::read(&source).map_err(|error| error.in_file(&plan.file))?;
    let hash = plan.library.hash(&source);
    if let Some(same) = known.iter().find(|one| one.hash == hash) {
        return Err(match same.number {
            0 => "it is the base template".to_string(),
            number => format!("it is candidate {number}"),
        });
    }
    let before = Template::body_of(&parent.source);
    if let Some(why) = plan.traces.found(template.body(), before) {
        return Err(why);
    }
    let included = plan.library.included(&source);
    let of_base = plan.library.included(&plan.template.source);
    if let Some(name) = of_base
        .iter()
        .find(|name| is_of_answer(name) && !included.contains(*name))
    {
        return Err(format!(
            "it does not include \"{name}\", which says the form of the answer"
        ));
    }
    let questions = rendered(plan, &source)?;
    for (question, base) in questions.iter().zip(&plan.questions) {
        keeps(question, &base.question)?;
    }
    Ok(Checked {
        source,
        hash,
        questions,
    })
}

/// Whether a fragment says the form of the answer.
fn is_of_answer(name: &str) -> bool {
    name.contains("answer")
}

/// All dev questions as a template asks them.
///
/// # Errors
/// The first that cannot be rendered.
pub(super) fn rendered(plan: &TunePlan, source: &str) -> Result<Vec<Question>, String> {
    if source == plan.template.source {
        let questions = plan.questions.iter().map(|one| one.question.clone());
        return Ok(questions.collect());
    }
    let library = with_template(plan, source)?;
    let of = |question: &Question| {
        let made = prepare(question.case.clone(), &library, None);
        made.map_err(|error| format!("it cannot be filled: {error}"))
    };
    let questions = plan.questions.par_iter().map(|one| of(&one.question));
    questions.collect()
}

/// The templates with this one in the place of the base.
fn with_template(plan: &TunePlan, source: &str) -> Result<Library, String> {
    let mut library = plan.library.clone();
    let used = library.use_draft(&plan.file, source);
    used.map_err(|error| error.in_file(&plan.file))?;
    Ok(library)
}

/// Whether a message still has what the base's has.
fn keeps(question: &Question, base: &Question) -> Result<(), String> {
    let texts =
        |question: &Question| format!("{}\n{}", question.prompt.system, question.prompt.user);
    let (now, before) = (texts(question), texts(base));
    let form = answer_form(&verdict::schema(base.case.task));
    let lost = |part: &str| before.contains(part) && !now.contains(part);
    if lost(base.description.trim()) {
        return Err(
            "the description of the scene is not in the messages: keep {{ description }}".into(),
        );
    }
    if lost(form.trim()) {
        return Err(
            "the form of the answer is not in the messages: keep the include of _answer.md".into(),
        );
    }
    let name = base.case.name.as_str();
    if now.contains(name) && !before.contains(name) {
        return Err(
            "the messages say the name of the scenario: {{ scenario }} may not be shown".into(),
        );
    }
    Ok(())
}

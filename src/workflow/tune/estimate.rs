//! What a tune asks at most, what that can cost, and whether it can be asked, before anything is sent.

use std::sync::Arc;

use super::TuneSettings;
use super::divide::DevPart;
use super::prepare::TunePlan;
use super::reflect::LONGEST;
use super::reflector::Reflector;
use super::request::TuneModels;
use super::rounds::MINIBATCH;
use nearmiss_ask::llm::{self, Message, Request, Role};
use nearmiss_store::{Store, StoreError};
use nearmiss_study::evaluation::batch::{Estimate, Price, Size, question_key};
use nearmiss_study::evaluation::can_ask;

/// Questions and proposals at most, and the most they can cost.
#[derive(Debug, Clone, PartialEq)]
pub struct TuneEstimate {
    /// Answers of the base that are missing: what is asked in any case.
    pub base: Estimate,
    /// Answers at most, all templates together, those of the store included.
    pub answers: usize,
    /// Proposals at most.
    pub reflections: usize,
    /// The most that all can cost, US dollars, with templates as long as the base; `None` where a price or a limit of
    /// tokens is unknown.
    pub most_usd: Option<f64>,
}

/// Estimates a tune; nothing is sent.
///
/// # Errors
/// The store cannot be read.
pub fn estimate(
    plan: &TunePlan,
    models: &TuneModels,
    settings: &TuneSettings,
    store: &Store,
) -> Result<TuneEstimate, StoreError> {
    let mut base = Estimate::default();
    let mut dearest: Option<f64> = Some(0.0);
    for one in &plan.questions {
        let mut size = Size::estimate(&one.question, &models.judge);
        let price = match size.price {
            Price::AtMost(usd) => Some(usd),
            Price::Free => Some(0.0),
            _ => None,
        };
        dearest = dearest.zip(price).map(|(a, b)| a.max(b));
        let key = question_key(&one.question, &models.judge)?;
        size.stored = match &key {
            Some(key) => store.has_answer(key, 0)?,
            None => false,
        };
        base.add(Some(size), None);
    }
    let proposals = (settings.rounds * settings.candidates) as usize;
    let (feedback, selection) = (
        plan.of_part(DevPart::Feedback).len(),
        plan.of_part(DevPart::Selection).len(),
    );
    // Every candidate is asked the selection part and the few shown questions; a parent all feedback questions at most.
    let parents = (settings.rounds as usize).saturating_sub(1);
    let more = proposals * (selection + MINIBATCH.min(feedback)) + parents * feedback;
    let request = longest(plan, models);
    let reflection = models.reflect.endpoint.at_most(&request);
    let known = base.unbounded == 0 && base.unpriced == 0;
    let most_usd = reflection
        .zip(dearest)
        .filter(|_| known)
        .map(|(reflection, answer)| {
            base.usd + reflection * proposals as f64 + answer * more as f64
        });
    Ok(TuneEstimate {
        answers: plan.questions.len() + more,
        reflections: proposals,
        base,
        most_usd,
    })
}

/// A request for a proposal as long as one with the base can be.
fn longest(plan: &TunePlan, models: &TuneModels) -> Request {
    let reflector = Reflector {
        model: models.reflect.clone(),
        store: Arc::clone(&models.store),
        control: models.control.clone(),
    };
    let included = plan.library.included(&plan.template.source);
    let fragments = { included.iter() }.filter_map(|name| plan.library.fragments().get(*name));
    let fragments: usize = fragments.map(String::len).sum();
    let longest = LONGEST + plan.template.source.len() + fragments;
    reflector.request(vec![Message::new(Role::User, "a".repeat(longest))])
}

/// Whether both models can be asked as things stand, and a proposal is within the budget; nothing is sent.
///
/// # Errors
/// Which cannot be, and why.
pub async fn can_tune(plan: &TunePlan, models: &TuneModels) -> Result<(), String> {
    let model = &models.reflect;
    let request = longest(plan, models);
    let checked = llm::check(&model.client, &model.endpoint, &request).await;
    checked.map_err(|why| format!("{}: a proposal cannot be asked for: {why}", model.id))?;
    let Some(first) = plan.questions.first() else {
        return Ok(());
    };
    let checked = can_ask(&first.question, &models.judge).await;
    checked.map_err(|why| format!("{}: {why}", models.judge.id()))
}

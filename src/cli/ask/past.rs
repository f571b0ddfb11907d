//! A stored answer asked for under another provider's name, and its cost at the prices known here.

use jiff::Timestamp;
use jiff::tz::TimeZone;

use nearmiss_ask::llm::Usage;
use nearmiss_study::evaluation::{Answer, Judge};

/// Whose answer it is: the model, and where it was asked for under another name, which run that was.
pub(super) fn whose(answer: &Answer, asked: &str) -> String {
    match answer.run {
        Some(run) if answer.model != asked => {
            format!(
                "{asked}; the answer of run {run}, asked as {}",
                answer.model
            )
        }
        _ => answer.model.clone(),
    }
}

/// What an answer cost by the prices of the model that is asked for now, US dollars, with where they are from; nothing
/// where the run knows its cost, or the prices or tokens are not known.
pub(super) fn worked_out(answer: &Answer, judge: &Judge) -> Option<(f64, String)> {
    let (Judge::Model(model), Some(past), None) = (judge, &answer.past, answer.consumed.cost_usd)
    else {
        return None;
    };
    let asked = Timestamp::from_millisecond(past.created_ms).ok()?;
    let day = asked.to_zoned(TimeZone::UTC).date();
    let prices = &model.endpoint.prices;
    let pricing = prices.of_answer(&model.name, answer.model_returned.as_deref(), day)?;
    let usage = Usage {
        input_tokens: answer.consumed.input_tokens,
        output_tokens: answer.consumed.output_tokens,
        reasoning_tokens: answer.consumed.reasoning_tokens,
        cached_tokens: answer.consumed.cached_tokens,
        ..Usage::default()
    };
    let usd = pricing.cost(&usage, asked)?;
    let origin = pricing.origin().map_or(String::new(), |o| format!(", {o}"));
    let provider = &model.endpoint.name;
    Some((
        usd,
        format!("computed now: tokens of the run times prices of {provider}{origin}"),
    ))
}

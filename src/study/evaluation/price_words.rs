//! Names for the source of an answer's cost.

use jiff::Timestamp;
use jiff::tz::TimeZone;

use super::judges::ModelJudge;
use nearmiss_ask::llm::CostSource;

/// Describes the source of a cost.
pub(super) fn stated(source: CostSource, model: &ModelJudge, returned: Option<&str>) -> String {
    let table = "tokens times listed prices";
    match source {
        CostSource::Server => "stated by the server".into(),
        CostSource::Prices => {
            let today = Timestamp::now().to_zoned(TimeZone::UTC).date();
            let prices = &model.endpoint.prices;
            let pricing = prices.of_answer(&model.name, returned, today);
            if let Some(free) = pricing.as_ref().and_then(|pricing| pricing.free_words()) {
                return free;
            }
            match pricing.and_then(|pricing| pricing.origin()) {
                Some(origin) => format!("{table}, {origin}"),
                None => table.into(),
            }
        }
    }
}

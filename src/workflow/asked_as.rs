//! How stored runs were asked, as far as only their batch knows it: look ahead and measures.

use std::collections::HashMap;

use nearmiss_store::{BatchId, RunId, Store, StoreError};
use nearmiss_study::evaluation::Case;
use nearmiss_study::evaluation::batch::Spec;
use nearmiss_study::evaluation::report::AskedAs;

/// How the runs of batches were asked, where that is not the usual way.
///
/// # Errors
/// The store cannot be read.
pub fn asked_as(store: &Store) -> Result<HashMap<RunId, AskedAs>, StoreError> {
    let mut known: HashMap<BatchId, AskedAs> = HashMap::new();
    for (batch, _) in store.batches()? {
        if let Ok(spec) = Spec::from_json(&batch.spec) {
            let asked = AskedAs {
                horizon: Some(spec.experiment.within.unwrap_or(Case::HORIZON)),
                measures: spec.experiment.measures(),
            };
            known.insert(batch.id, asked);
        }
    }
    let unknown = AskedAs {
        horizon: None,
        measures: None,
    };
    let of_runs = store.run_batches()?.into_iter().filter_map(|(run, batch)| {
        // Other words are no batches: these runs were asked one by one.
        let batch: BatchId = batch.parse().ok()?;
        Some((run, known.get(&batch).copied().unwrap_or(unknown)))
    });
    Ok(of_runs
        .filter(|(_, asked)| *asked != AskedAs::default())
        .collect())
}

//! `nearmiss runs show -o FILE.png`: writes the picture that the model of a run was shown.

use std::path::Path;

use crate::{Failure, Outcome, output};
use nearmiss_base::system;
use nearmiss_store::{Run, Store};

/// Writes it.
pub fn write(store: &Store, run: &Run, file: &Path, overwrite: bool) -> Outcome {
    let id = run.id;
    let hashes = run.question.image_hashes();
    let Some(hash) = hashes.first() else {
        return Err(Failure::input(format!(
            "run {id} was asked without a picture, in the frame {}",
            run.question.frame
        )));
    };
    let image = store.image(hash).map_err(Failure::input)?.ok_or_else(|| {
        Failure::input(format!(
            "the picture {hash} of run {id} is not in the store; import the export or bundle again that has it"
        ))
    })?;
    system::save(file, &image.bytes, overwrite).map_err(|error| output::refused(&error))
}

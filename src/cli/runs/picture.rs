//! `nearmiss runs picture`: writes the picture that the model of a run was shown.

use std::path::PathBuf;

use crate::locked::Unlock;
use crate::{Failure, Outcome, output};
use nearmiss_base::system;
use nearmiss_store::{RunId, Store};

/// Arguments of `runs picture`.
#[derive(Debug, clap::Args)]
pub struct PictureOfRun {
    /// Number of the run.
    id: i64,
    /// File to write: a PNG, byte for byte as it was sent.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Replace an existing file.
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    pub unlock: Unlock,
}

/// Writes it.
pub fn write(store: &Store, arguments: &PictureOfRun) -> Outcome {
    let id = RunId(arguments.id);
    let run = super::known(store, id)?;
    super::refuse_locked(store, id, arguments.unlock)?;
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
    system::save(&arguments.output, &image.bytes, arguments.overwrite)
        .map_err(|error| output::refused(&error))
}

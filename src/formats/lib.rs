//! Files: finds, reads and writes scenarios and egos.

mod address;
pub mod commonroad;
mod dispatch;
mod ego;
mod library;
mod opendrive;
mod openscenario;
mod passed_over;
mod recordings;
mod resolve;
mod search;
mod unread;

pub use dispatch::{Ranking, only_part};
pub use ego::{
    EgoError, EgoSelection, PlannerDrives, USUAL_VEHICLE, ego_of_solution, find_recording,
    read_ego, read_ego_file, write_recording, write_sized_recording,
};
pub use library::{Entry, EntryLocation, bundled};
pub use openscenario::{Export, Exported, ExportedEgo, write_openscenario};
pub use passed_over::{PassedOver, PassedOverReason};
pub use recordings::{LongRecording, look_for_maps_in};
pub use resolve::resolved;
pub use search::{
    LibraryError, SearchResults, find, find_in_pieces, find_ranked, not_standard_input,
};

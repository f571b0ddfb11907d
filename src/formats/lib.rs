//! Files: finds, reads and writes scenarios and egos.

pub mod commonroad;
mod dispatch;
mod ego;
mod library;
mod opendrive;
mod openscenario;
mod recordings;
mod search;
mod tables;
mod unread;

pub use dispatch::{Ranking, only_part};
pub use ego::{
    EGO_FILES, EgoError, EgoSelection, PlannerDrives, USUAL_VEHICLE, ego_of_solution,
    find_recording, read_ego, read_ego_file, write_recording, write_sized_recording,
};
pub use library::{Entry, EntryLocation, bundled, resolved};
pub use openscenario::{
    Export, Exported, ExportedEgo, Formula, VariedMotion, VariedParameter, VariedVertex,
    write_openscenario,
};
pub use recordings::{
    Columns, ColumnsError, Forecast, LONGEST_PLAY, LongRecording, NamedTable, Player, RankedMoment,
    TableOptions, check_table, check_table_options, look_for_maps_in, play_with, read_forecasts,
    read_tables_with, reading_tables_with, usual_table_options,
};
pub use search::{
    LibraryError, PassedOver, PassedOverReason, SearchResults, find, find_in_pieces, find_ranked,
    not_standard_input,
};
pub use tables::{TableError, TableShape, WrittenTables, track_table, write_tables};

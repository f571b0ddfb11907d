//! The Python module: the workflows as functions, tables as Arrow. It translates, and decides nothing.

mod arguments;
mod attack;
mod errors;
mod files;
mod plan;
mod scenario;
mod settings;
mod table;
mod window;
mod work;
mod write;

use pyo3::prelude::*;

/// Measure, judge and endanger driving scenarios.
///
/// >>> import nearmiss
/// >>> scenario = nearmiss.open("ZAM_CutIn-1_1_T-1")
/// >>> scenario.worst()["what"]
/// >>> scenario.measures(names=["ttc", "distance"])    # an Arrow table
///
/// Tables have `__arrow_c_stream__`: `polars.DataFrame(table)`, `pyarrow.table(table)`, DuckDB and pandas take them without
/// copying. Lengths are in metres, angles in radians, times in seconds; moments of a recording are durations.
#[pymodule]
mod _nearmiss {
    #[pymodule_export]
    use super::attack::{Variant, attack};
    #[pymodule_export]
    use super::errors::Error;
    #[pymodule_export]
    use super::files::{
        drivers, encounters_of, from_tracks, index_batch, inspect, measure_batch, measures,
        of_bytes, open, scenarios, windows,
    };
    #[pymodule_export]
    use super::plan::{Drive, plan};
    #[pymodule_export]
    use super::scenario::{Figure, Scenario};
    #[pymodule_export]
    use super::table::Table;
    #[pymodule_export]
    use super::window::{Window, ask, check, judge, prompt, read_verdict};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // Those without a place have none.
        let error = module.getattr("Error")?;
        error.setattr("file", module.py().None())?;
        error.setattr("line", module.py().None())?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

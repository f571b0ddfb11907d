//! Tables, given and taken as Arrow streams by the PyCapsule interface. The only file with unsafe code.

use std::ffi::CStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::types::{DurationMicrosecondType, Float64Type, Int64Type};
use arrow_array::{ArrayRef, RecordBatch, RecordBatchIterator, RecordBatchReader};
use arrow_ipc::writer::FileWriter;
use arrow_schema::{ArrowError, DataType, SchemaRef};
use nearmiss_base::system::NewFile;
use nearmiss_record::{Clock, Row, escaped_html};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyCapsuleMethods, PyDict, PyList};

use crate::errors::Problem;
use crate::work;

const STREAM: &CStr = c"arrow_array_stream";

/// Rows that a notebook shows.
const SHOWN: usize = 10;

/// A table of Arrow batches.
///
/// `table.to_pandas()`, `table.to_polars()`, `pyarrow.table(table)` and DuckDB by the name of the variable take it as it is. Without
/// any of them `table.rows()` gives a dict a row. Moments of the recording are durations; units and meanings of columns are in `table.columns` and in the metadata of Arrow's fields.
#[pyclass(frozen, module = "nearmiss")]
pub struct Table {
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
}

impl Table {
    /// Rows of a table of ours.
    ///
    /// # Errors
    /// A column without gaps has one.
    pub fn new(table: &nearmiss_record::Table, rows: Vec<Row>) -> Result<Self, Problem> {
        let schema = table.arrow_schema(Clock::Durations);
        let batch = table.arrow_batch(&schema, rows).map_err(Problem::new)?;
        let batches = vec![batch];
        Ok(Self { schema, batches })
    }

    /// Tables of the same columns below each other; nothing of none.
    pub fn joined(parts: Vec<Self>, schema: SchemaRef) -> Self {
        let all = parts.into_iter().flat_map(|part| part.batches);
        Self {
            batches: all.collect(),
            schema,
        }
    }

    /// Everything that a Python object streams.
    ///
    /// # Errors
    /// It is no table, or its stream breaks off.
    pub fn taken(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        let reader = reader(object)?;
        let schema = reader.schema();
        // What pandas calls its index is no data of the user's.
        let is_data = |name: &str| !name.starts_with("__index_level_");
        let fields = schema.fields().iter().enumerate();
        let kept: Vec<usize> = fields
            .filter(|(_, field)| is_data(field.name()))
            .map(|(place, _)| place)
            .collect();
        let batches = reader.map(|batch| batch?.project(&kept));
        // A stream may hold other columns than it says.
        let batches = work::caught(|| batches.collect::<Result<_, _>>())?;
        Ok(Self {
            batches: batches.map_err(Problem::new)?,
            schema: Arc::new(schema.project(&kept).map_err(Problem::new)?),
        })
    }

    fn first_rows<'py>(&self, py: Python<'py>, most: usize) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let batches = self.batches.iter();
        let places = batches.flat_map(|batch| (0..batch.num_rows()).map(move |row| (batch, row)));
        let row = |(batch, place): (&RecordBatch, usize)| {
            let row = PyDict::new(py);
            for (field, column) in self.schema.fields().iter().zip(batch.columns()) {
                row.set_item(field.name(), value(py, column, place)?)?;
            }
            Ok(row)
        };
        places.take(most).map(row).collect()
    }

    /// The texts of a column; `None` without that column.
    ///
    /// # Errors
    /// It holds no texts, or has gaps.
    pub fn texts(&self, name: &str) -> Result<Option<Vec<String>>, Problem> {
        if self.schema.field_with_name(name).is_err() {
            return Ok(None);
        }
        let mut found = Vec::new();
        for batch in &self.batches {
            let Some(column) = batch.column_by_name(name) else {
                continue;
            };
            let texts = arrow_cast::cast(column, &DataType::Utf8).map_err(Problem::new)?;
            for text in texts.as_string::<i32>() {
                let text =
                    text.ok_or_else(|| Problem::new(format!("column {name}: a value is missing")))?;
                found.push(text.to_string());
            }
        }
        Ok(Some(found))
    }

    /// Writes it as an Arrow IPC file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), Problem> {
        let file = NewFile::begin(path, true).map_err(Problem::new)?;
        let broken = |error: ArrowError| named(path, &std::io::Error::other(error));
        let mut writer = FileWriter::try_new(file, &self.schema).map_err(broken)?;
        for batch in &self.batches {
            writer.write(batch).map_err(broken)?;
        }
        let file = writer.into_inner().map_err(broken)?;
        file.finish().map_err(Problem::new)
    }
}

/// The stream of a Python object: what has the Arrow interface, or a DataFrame of an older pandas.
#[allow(unsafe_code)]
fn reader(object: &Bound<'_, PyAny>) -> PyResult<RecordBatchStreamReader> {
    let py = object.py();
    let source = if object.hasattr("__arrow_c_stream__")? {
        object.clone()
    } else if object.hasattr("__arrow_c_array__")? || object.hasattr("to_parquet")? {
        // A batch alone, and pandas before 2.2, stream by pyarrow, which both need to be there at all.
        let arrow = py.import("pyarrow")?;
        if object.hasattr("to_parquet")? {
            arrow
                .getattr("Table")?
                .call_method1("from_pandas", (object,))?
        } else {
            let batches = PyList::new(py, [object])?;
            arrow
                .getattr("Table")?
                .call_method1("from_batches", (batches,))?
        }
    } else {
        return Err(PyTypeError::new_err(format!(
            "{} is no table: expected __arrow_c_stream__ (pyarrow, polars, DuckDB) or a pandas DataFrame",
            object.get_type().name()?
        )));
    };
    let given = source.call_method0("__arrow_c_stream__")?;
    let capsule = given.cast::<PyCapsule>()?;
    let pointer = capsule.pointer_checked(Some(STREAM)).map_err(|_| {
        PyTypeError::new_err("__arrow_c_stream__ gave another capsule than arrow_array_stream")
    })?;
    // SAFETY: the capsule has this name, so it holds a stream of Arrow's C interface, which stays there as long as the
    // capsule. `from_raw` moves the stream out and leaves a released one behind, as the interface asks of consumers.
    let stream = unsafe { FFI_ArrowArrayStream::from_raw(pointer.cast().as_ptr()) };
    Ok(RecordBatchStreamReader::try_new(stream).map_err(Problem::new)?)
}

#[pymethods]
impl Table {
    /// The stream, for libraries that take Arrow; each call begins anew.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // The interface lets a producer keep to its own schema.
        let _ = requested_schema;
        let batches = self.batches.clone().into_iter().map(Ok);
        let reader = RecordBatchIterator::new(batches, self.schema.clone());
        let stream = FFI_ArrowArrayStream::new(Box::new(reader));
        PyCapsule::new_with_value(py, stream, STREAM)
    }

    fn __len__(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    fn __repr__(&self) -> String {
        let names = self
            .schema
            .fields()
            .iter()
            .map(|field| field.name().as_str());
        let names: Vec<&str> = names.collect();
        format!(
            "<nearmiss.Table: {} rows of {}>",
            self.__len__(),
            names.join(", ")
        )
    }

    /// The columns: what each means and its unit, by its name.
    #[getter]
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        for field in self.schema.fields() {
            let said = |key: &str| {
                field
                    .metadata()
                    .get(key)
                    .map(String::as_str)
                    .unwrap_or_default()
                    .to_string()
            };
            let words = match said("unit") {
                unit if unit.is_empty() => said("description"),
                unit => format!("{} [{unit}]", said("description")),
            };
            columns.set_item(field.name(), words)?;
        }
        Ok(columns)
    }

    /// A dict for each row; None where there is no value, and a `datetime.timedelta` for a moment.
    fn rows<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, self.first_rows(py, usize::MAX)?)
    }

    /// The same as a pandas DataFrame.
    fn to_pandas<'py>(own: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let frame = own.py().import("pandas")?.getattr("DataFrame")?;
        if frame.hasattr("from_arrow")? {
            return frame.call_method1("from_arrow", (own,));
        }
        let arrow = own.py().import("pyarrow")?;
        arrow
            .call_method1("table", (own,))?
            .call_method0("to_pandas")
    }

    /// The same as a polars DataFrame.
    fn to_polars<'py>(own: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        own.py().import("polars")?.call_method1("DataFrame", (own,))
    }

    /// The first rows, for a notebook.
    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        let line = |cells: Vec<String>, tag: &str| {
            let cells = cells
                .iter()
                .map(|cell| format!("<{tag}>{}</{tag}>", escaped_html(cell)));
            format!("<tr>{}</tr>", cells.collect::<String>())
        };
        let names = self
            .schema
            .fields()
            .iter()
            .map(|field| field.name().clone());
        let mut lines = line(names.collect(), "th");
        for row in self.first_rows(py, SHOWN)? {
            let cells = row.values().iter().map(|cell| cell.to_string());
            lines.push_str(&line(cells.collect(), "td"));
        }
        Ok(format!(
            "<table>{lines}</table><p>{} rows</p>",
            self.__len__()
        ))
    }

    /// Writes it as an Arrow IPC file (.arrow or .feather), which polars and pandas read, and nearmiss where it is one of tracks.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let ending = path.extension().and_then(|ending| ending.to_str());
        if !matches!(ending, Some("arrow" | "feather")) {
            return Err(Problem::new(format!(
                "{}: a table is .arrow or .feather; to_pandas() and to_polars() write others",
                path.display()
            ))
            .into());
        }
        Ok(py.detach(|| self.save(&path))?)
    }
}

fn named(path: &Path, error: &std::io::Error) -> Problem {
    let why = nearmiss_base::system::error_text(error);
    Problem::new(format!("{}: {why}", path.display()))
}

/// A cell as Python's own.
fn value<'py>(py: Python<'py>, column: &ArrayRef, place: usize) -> PyResult<Bound<'py, PyAny>> {
    if column.is_null(place) {
        return Ok(py.None().into_bound(py));
    }
    match column.data_type() {
        DataType::Int64 => column
            .as_primitive::<Int64Type>()
            .value(place)
            .into_bound_py_any(py),
        DataType::Float64 => column
            .as_primitive::<Float64Type>()
            .value(place)
            .into_bound_py_any(py),
        DataType::Boolean => column.as_boolean().value(place).into_bound_py_any(py),
        DataType::Duration(_) => {
            let micros = column
                .as_primitive::<DurationMicrosecondType>()
                .value(place);
            let options = PyDict::new(py);
            options.set_item("microseconds", micros)?;
            py.import("datetime")?
                .getattr("timedelta")?
                .call((), Some(&options))
        }
        _ => column.as_string::<i32>().value(place).into_bound_py_any(py),
    }
}

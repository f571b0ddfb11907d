//! Nouns and knobs, described once: a noun has every face of a table, text, CSV, JSON lines, Parquet, panel and schema; a
//! knob ([`mod@fields`]) is read and written in every form.
//!
//! A noun is a struct. What its fields are called, mean and are measured in stands once, at the field:
//!
//! ```
//! use nearmiss_record::{Record, columns, rows, text_table};
//!
//! #[derive(serde::Serialize, schemars::JsonSchema)]
//! struct Drive {
//!     /// The scenario.
//!     #[schemars(title = "scenario")]
//!     scenario: String,
//!     /// The largest deceleration of the ego.
//!     #[schemars(title = "brakes", extend("unit" = "m/s²", "decimals" = 1))]
//!     deceleration: Option<f64>,
//! }
//!
//! impl Record for Drive {
//!     const NAME: &'static str = "drive";
//!     const TITLE: &'static str = "One drive a line";
//! }
//!
//! let drive = Drive { scenario: "A".into(), deceleration: Some(3.25) };
//! let text = text_table(&columns::<Drive>(), &rows([&drive])?);
//! assert_eq!(text, "scenario  brakes m/s²\nA                 3.2\n");
//! # Ok::<(), serde_json::Error>(())
//! ```

mod arrow;
mod captioned;
pub mod fields;
mod page;
mod reflect;
mod table;
#[cfg(test)]
mod tests;
mod text;
mod words;
mod writer;

pub use arrow::Clock;
pub use captioned::{
    CaptionedTable, NONE, escaped_html, escaped_latex, escaped_markdown, latex_comment,
    with_interval,
};
pub use page::HtmlPage;
pub use reflect::{Record, columns, columns_of, row, row_of, rows, schema, titled};
pub use table::{Cell, Column, Kind, Row, Table};
pub use text::{
    Align, SCHEMA_VERSION, TextTable, begins_formula, csv, json_line, line, lines, text_table,
    versioned,
};
pub use writer::{ColumnsFile, Encoded, Format, TableWriter};
#[doc(hidden)]
pub use {schemars, serde, strum};

//! JSON that commands print: the version of its form, and the schemas of `nearmiss help json`.

mod derived;
mod list;
mod schemas;

pub use derived::Output;
pub use nearmiss_record::{SCHEMA_VERSION, versioned};
pub use schemas::{document, keys, names};

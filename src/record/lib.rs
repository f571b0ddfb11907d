//! Things that are described once, and every form in which they are read and written.

pub mod fields;

//! Scenarios as protobuf files, for the tests of the library and of the program.

pub mod common;
pub mod single;
pub mod triple;
pub mod wire;

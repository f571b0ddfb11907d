//! Pieces that several views are made of.

pub mod ascii;
pub mod claimed;
pub mod fill;
pub mod frame;
pub mod highlight;
pub mod reading;
pub mod row;
pub mod scroll;
pub mod words;

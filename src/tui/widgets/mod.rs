//! Widgets shared by several views.

pub mod claimed;
pub mod highlight;
pub mod hints;
pub mod line_placer;
pub mod long_text;
pub mod markdown;
pub mod picker;
pub mod row;
pub mod unbroken;
pub mod window;
pub mod words;

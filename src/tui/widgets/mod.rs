//! Widgets shared by several views.

pub mod ascii;
pub mod claimed;
pub mod frame;
pub mod highlight;
pub mod hints;
pub mod line_placer;
pub mod lines;
pub mod long_text;
pub mod markdown;
pub mod picker;
pub mod row;
pub mod scroll;
pub mod window;
pub mod words;

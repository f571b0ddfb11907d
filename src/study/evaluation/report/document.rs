//! A report independent of its format: headings, paragraphs, tables and figures.

use nearmiss_scene::description::visible;

/// A whole report.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Document {
    /// Its title.
    pub title: String,
    /// Its contents.
    pub blocks: Vec<Block>,
}

/// A part of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Block {
    /// A heading.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// A table.
    Table(Table),
    /// Figures of one kind, side by side, and what they show; only HTML has them.
    Figures(String, Vec<Figure>),
}

/// A picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// Its caption.
    pub caption: String,
    /// The picture as SVG, its texts escaped.
    pub svg: String,
}

/// A table.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    /// Its caption.
    pub caption: String,
    /// Its name for references in LaTeX.
    pub name: String,
    /// Titles of the columns, and on which side they stand.
    pub columns: Vec<(String, Align)>,
    /// The cells, a row each as long as the columns.
    pub rows: Vec<Vec<String>>,
    /// Explanations of its numbers, for tables that stand alone in papers.
    pub notes: Vec<String>,
}

/// On which side of its column a cell stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

impl Table {
    /// An empty table. Titles that begin with `<` are those of words, all others of numbers.
    pub(crate) fn new(
        caption: impl Into<String>,
        name: impl Into<String>,
        titles: &[&str],
    ) -> Self {
        let column = |title: &&str| match title.strip_prefix('<') {
            Some(title) => (title.to_string(), Align::Left),
            None => ((*title).to_string(), Align::Right),
        };
        Self {
            caption: caption.into(),
            name: name.into(),
            columns: titles.iter().map(column).collect(),
            rows: Vec::new(),
            notes: Vec::new(),
        }
    }
}

/// Text on one line, with what terminals and browsers would obey shown instead.
pub(super) fn clean(text: &str) -> String {
    visible(text)
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}

//! A report independent of its format: headings, paragraphs, tables and figures.

use nearmiss_record::{CaptionedTable, escaped_markdown, latex_comment};

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
    Table(CaptionedTable),
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

impl Document {
    /// The report as Markdown; figures are left out.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n", escaped_markdown(&self.title));
        for block in &self.blocks {
            match block {
                Block::Heading(words) => text += &format!("\n## {}\n", escaped_markdown(words)),
                Block::Text(words) => text += &format!("\n{}\n", escaped_markdown(words)),
                Block::Table(table) => text += &table.markdown(),
                Block::Figures(..) => {}
            }
        }
        text
    }

    /// The tables as LaTeX, for `\input`, each with its notes beneath; figures are left out, and headings and
    /// paragraphs are comments.
    #[must_use]
    pub fn latex(&self) -> String {
        let mut text = latex_comment(&self.title);
        text += "% \\usepackage{booktabs,graphicx}\n";
        for block in &self.blocks {
            match block {
                Block::Heading(words) => text += &format!("\n%\n{}", latex_comment(words)),
                Block::Text(words) => text += &latex_comment(words),
                Block::Table(table) => text += &table.latex(),
                Block::Figures(..) => {}
            }
        }
        text
    }
}

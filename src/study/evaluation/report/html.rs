//! Reports as one self-contained HTML file, light or dark by the reader's preference.

use super::document::{Block, Document, Figure};
use crate::evaluation::AnswerPage;
use crate::evaluation::answer_page::{STYLE as ANSWERS_STYLE, source_hash};
use nearmiss_record::escaped_html as escaped;

/// The look: colours as variables, so that figures in SVG have them too.
const STYLE: &str = include_str!("report.css");

impl Document {
    /// The report as one file of HTML, with its figures in it, and the answers that it counts where there are any. The
    /// page runs nothing but its own script and asks for nothing.
    #[must_use]
    pub fn html(&self, answers: &AnswerPage) -> String {
        let title = escaped(&self.title);
        let style = if answers.is_empty() {
            format!("\n{STYLE}")
        } else {
            format!("\n{STYLE}{ANSWERS_STYLE}")
        };
        let script = if answers.is_empty() {
            "'none'".to_string()
        } else {
            format!("'{}'", AnswerPage::script_hash())
        };
        let policy = format!(
            "default-src 'none'; style-src '{}'; script-src {script}; img-src data:; base-uri 'none'; form-action 'none'",
            source_hash(&style)
        );
        let mut text = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <title>{title}</title>\n<style>{style}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n"
        );
        for block in &self.blocks {
            match block {
                Block::Heading(words) => text += &format!("<h2>{}</h2>\n", escaped(words)),
                Block::Text(words) => text += &format!("<p>{}</p>\n", escaped(words)),
                Block::Table(table) => text += &table.html(),
                Block::Figures(title, figures) => {
                    text += &format!("<h3>{}</h3>\n<div class=\"figures\">\n", escaped(title));
                    for figure in figures {
                        text += &html_of(figure);
                    }
                    text += "</div>\n";
                }
            }
        }
        text += "</main>\n";
        if !answers.is_empty() {
            text += &answers.html();
        }
        text + "</body>\n</html>\n"
    }
}

/// A figure, with its caption if it has one.
fn html_of(figure: &Figure) -> String {
    let caption = if figure.caption.is_empty() {
        String::new()
    } else {
        format!("<figcaption>{}</figcaption>\n", escaped(&figure.caption))
    };
    format!("<figure>\n{}{caption}</figure>\n", figure.svg)
}

//! A page's data as blocks of JSON in HTML: the grid at once, texts, details and pictures when they are asked for.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::{AnswerPage, Row};
use crate::evaluation::report::{name_of, technique};
use nearmiss_scene::description::visible;

/// The program of the page, and its look.
const SCRIPT: &str = concat!(include_str!("grid.js"), include_str!("answer.js"));
pub(crate) const STYLE: &str = include_str!("answers.css");

/// Answers whose details are one block.
const DETAILS: usize = 200;

/// Bytes of texts of one block, about.
const TEXTS: usize = 256 << 10;

/// `sha256-…`, by which a content security policy knows a script or a style.
pub(crate) fn source_hash(source: &str) -> String {
    let digest = Sha256::digest(source.as_bytes());
    format!("sha256-{}", BASE64_STANDARD.encode(digest))
}

impl AnswerPage {
    /// The script and its data, to stand at the end of the body.
    pub(crate) fn html(&self) -> String {
        let mut html = String::from(
            "<noscript><p>JavaScript is off: the answers cannot be shown.</p></noscript>\n<section id=\"answers\" hidden></section>\n",
        );
        let texts = self.texts.blocks(TEXTS);
        let firsts: Vec<usize> = texts.iter().map(|(first, _)| *first).collect();
        block(&mut html, "grid", &self.grid(&firsts));
        for (number, (_, texts)) in texts.iter().enumerate() {
            block(&mut html, &format!("texts-{number}"), &json!(texts));
        }
        for (number, details) in self.details.chunks(DETAILS).enumerate() {
            let details: Vec<Value> = details.iter().map(super::AnswerDetail::json).collect();
            block(&mut html, &format!("details-{number}"), &json!(details));
        }
        for (number, svg) in self.pictures.iter().enumerate() {
            block(&mut html, &format!("picture-{number}"), &json!(svg));
        }
        for (number, address) in self.sent.all.iter().enumerate() {
            block(&mut html, &format!("sent-{number}"), &json!(address));
        }
        html.push_str("<script>");
        html.push_str(SCRIPT);
        html.push_str("</script>\n");
        html
    }

    /// The hash of the script for the policy of the page.
    pub(crate) fn script_hash() -> String {
        source_hash(SCRIPT)
    }

    /// Ways, questions and marks, in columns.
    fn grid(&self, text_blocks: &[usize]) -> Value {
        let ways = self.ways.iter().map(|way| {
            json!({
                "name": visible(&name_of(way)),
                "frame": way.frame.map(|frame| frame.name()),
                "techniques": way.techniques.map(technique),
                "model": visible(&way.model),
                "settings": way.settings.words(),
                "template": way.template.as_ref().map(ToString::to_string),
            })
        });
        let letters: String = self.marks.iter().map(|mark| mark.letter).collect();
        let said: String = self.marks.iter().map(|mark| mark.said).collect();
        let column =
            |of: fn(&super::Mark) -> usize| -> Vec<usize> { self.marks.iter().map(of).collect() };
        json!({
            "ways": ways.collect::<Vec<_>>(),
            "rows": self.rows.iter().map(question).collect::<Vec<_>>(),
            "marks": {
                "row": column(|mark| mark.row),
                "way": column(|mark| mark.way),
                "sample": column(|mark| mark.sample as usize),
                "letter": letters,
                "said": said,
            },
            "texts": text_blocks,
            "details": DETAILS,
        })
    }
}

fn question(row: &Row) -> Value {
    json!({
        "task": row.task.name(),
        "scenario": row.scenario,
        "lead": row.lead,
        "window": row.window,
        "truth": row.truth,
        "critical": row.critical,
        "picture": row.picture,
    })
}

/// A block of data that no browser runs. Nothing in it ends the block or begins a comment, whatever it holds.
fn block(html: &mut String, name: &str, value: &Value) {
    html.push_str("<script type=\"application/json\" id=\"data-");
    html.push_str(name);
    html.push_str("\">");
    for c in value.to_string().chars() {
        match c {
            '<' => html.push_str("\\u003c"),
            '>' => html.push_str("\\u003e"),
            '&' => html.push_str("\\u0026"),
            c => html.push(c),
        }
    }
    html.push_str("</script>\n");
}

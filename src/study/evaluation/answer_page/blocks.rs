//! A page's data as blocks of JSON in HTML: the grid at once, texts, details and pictures when they are asked for.

use std::borrow::Cow;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::{AnswerPage, Row};
use crate::evaluation::PromptConfig;
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
            block(&mut html, &format!("texts-{number}"), &texts);
        }
        for (number, details) in self.details.chunks(DETAILS).enumerate() {
            block(&mut html, &format!("details-{number}"), &details);
        }
        for (number, svg) in self.pictures.iter().enumerate() {
            block(&mut html, &format!("picture-{number}"), svg);
        }
        for (number, address) in self.sent.all.iter().enumerate() {
            block(&mut html, &format!("sent-{number}"), address);
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
    fn grid<'p>(&'p self, text_blocks: &'p [usize]) -> Grid<'p> {
        let way = |way: &'p PromptConfig| GridWay {
            name: visible(&name_of(way)).into_owned(),
            frame: way.frame.map(|frame| frame.name()),
            techniques: way.techniques.map(technique),
            model: visible(&way.model),
            settings: way.settings.words(),
            template: way.template.as_ref().map(ToString::to_string),
        };
        Grid {
            ways: self.ways.iter().map(way).collect(),
            rows: &self.rows,
            marks: Marks {
                row: self.marks.iter().map(|mark| mark.row).collect(),
                way: self.marks.iter().map(|mark| mark.way).collect(),
                sample: self.marks.iter().map(|mark| mark.sample).collect(),
                letter: self.marks.iter().map(|mark| mark.letter).collect(),
                said: self.marks.iter().map(|mark| mark.said).collect(),
            },
            texts: text_blocks,
            details: DETAILS,
        }
    }
}

/// What a page shows at once.
#[derive(Serialize)]
struct Grid<'p> {
    ways: Vec<GridWay<'p>>,
    rows: &'p [Row],
    marks: Marks,
    /// The first text of each block of texts.
    texts: &'p [usize],
    /// Answers whose details are one block.
    details: usize,
}

/// A way of asking: a column of the grid.
#[derive(Serialize)]
struct GridWay<'p> {
    name: String,
    frame: Option<&'static str>,
    techniques: Option<String>,
    model: Cow<'p, str>,
    settings: Option<String>,
    template: Option<String>,
}

/// The answers in columns.
#[derive(Serialize)]
struct Marks {
    row: Vec<usize>,
    way: Vec<usize>,
    sample: Vec<u32>,
    letter: String,
    said: String,
}

/// A block of data that no browser runs. Nothing in it ends the block or begins a comment, whatever it holds.
fn block(html: &mut String, name: &str, value: &impl Serialize) {
    html.push_str("<script type=\"application/json\" id=\"data-");
    html.push_str(name);
    html.push_str("\">");
    // Neither maps with other keys than texts nor errors of our own are in it.
    for c in serde_json::to_string(value).unwrap_or_default().chars() {
        match c {
            '<' => html.push_str("\\u003c"),
            '>' => html.push_str("\\u003e"),
            '&' => html.push_str("\\u0026"),
            c => html.push(c),
        }
    }
    html.push_str("</script>\n");
}

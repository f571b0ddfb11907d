//! A page of HTML as one file: it runs its own scripts alone and asks for nothing, whatever its texts hold.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::escaped_html;

/// The look that all pages share: colours as variables, light and dark, and tables.
const STYLE: &str = include_str!("page.css");

/// What all scripts share: `make`, which makes elements and takes words as text.
const SCRIPT: &str = include_str!("page.js");

/// A page.
#[derive(Debug, Clone, Default)]
pub struct HtmlPage {
    /// Its title, as text.
    pub title: String,
    /// Its look, beside the one that all pages share.
    pub style: String,
    /// What stands in it, as HTML; [`HtmlPage::add_data`] adds data.
    pub body: String,
    /// What it runs once the body is there; empty where nothing is.
    pub script: &'static str,
}

impl HtmlPage {
    /// Adds a block of data that no browser runs, found by the id `data-NAME`. Nothing in it ends the block or begins a
    /// comment, whatever it holds.
    pub fn add_data(&mut self, name: &str, value: &impl Serialize) {
        let html = &mut self.body;
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

    /// The text of the file.
    #[must_use]
    pub fn html(&self) -> String {
        let title = escaped_html(&self.title);
        let style = format!("\n{STYLE}{}", self.style);
        let (allowed, script) = if self.script.is_empty() {
            ("none".to_string(), String::new())
        } else {
            let script = format!("\n{SCRIPT}{}", self.script);
            (source_hash(&script), format!("<script>{script}</script>\n"))
        };
        let policy = format!(
            "default-src 'none'; style-src '{}'; script-src '{allowed}'; img-src data:; base-uri 'none'; form-action 'none'",
            source_hash(&style)
        );
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <title>{title}</title>\n<style>{style}</style>\n</head>\n<body>\n{}{script}</body>\n</html>\n",
            self.body
        )
    }
}

/// `sha256-…`, by which a content security policy knows a script or a style.
fn source_hash(source: &str) -> String {
    let digest = Sha256::digest(source.as_bytes());
    format!("sha256-{}", BASE64_STANDARD.encode(digest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_becomes_markup_and_only_the_own_script_runs() {
        let mut page = HtmlPage {
            title: "</title><script>x</script>".into(),
            ..HtmlPage::default()
        };
        page.add_data("a", &["</script><!-- & \u{202e}"]);
        let html = page.html();
        assert!(html.contains("script-src 'none'") && !html.contains("<script>"));
        assert!(html.contains("[\"\\u003c/script\\u003e\\u003c!-- \\u0026 \u{202e}\"]"));
        page.script = "1;";
        let html = page.html();
        let runs = html
            .split_once("<script>")
            .and_then(|(_, rest)| rest.split_once("</script>"));
        let runs = runs.map_or("", |(script, _)| script);
        assert!(runs.ends_with("1;") && !runs.contains('<'));
        assert!(html.contains(&format!("script-src '{}'", source_hash(runs))));
    }
}

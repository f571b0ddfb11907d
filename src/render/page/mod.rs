//! A scenario as a page that plays it in a browser: one file that asks for nothing, made from a figure.

mod data;

use nearmiss_record::{HtmlPage, escaped_html as escaped};

use super::figure::Figure;
use super::palette::Palette;
use data::PageData;

/// What the page runs, and its look.
const SCRIPT: &str = include_str!("player.js");
const STYLE: &str = include_str!("player.css");

/// Attributes of a scenario that its page tells.
const TOLD: [&str; 4] = ["source", "author", "affiliation", "date"];

impl Figure<'_> {
    /// The page: the map of the figure at every step, its measures as plots and tables, and the moment that matters; it
    /// opens at a step. Its colours are those of the figure, and of `dark` where the browser prefers them. `story` has the
    /// sentences that tell what happened; they stand above the map, and nothing where there is none.
    #[must_use]
    pub fn page(&self, step: i64, dark: &Palette, story: &[String]) -> String {
        let light = &self.look().palette;
        let mut page = HtmlPage {
            title: format!("{}, nearmiss", self.name()),
            style: format!(
                "{STYLE}:root {{ {} }}\n@media (prefers-color-scheme: dark) {{ :root {{ {} }} }}\n",
                variables(light),
                variables(dark)
            ),
            body: format!("<header>\n<h1>{}</h1>\n", escaped(self.name())),
            script: SCRIPT,
        };
        page.body += &format!("<p class=\"facts\">{}</p>\n", self.summary());
        let sentences = story.iter().map(|sentence| escaped(sentence));
        let sentences = sentences.collect::<Vec<_>>().join(" ");
        if !sentences.is_empty() {
            page.body += &format!("<p id=\"story\">{sentences}</p>\n");
        }
        page.body += "</header>\n<noscript><p>JavaScript is off: the scenario cannot be played.</p></noscript>\n\
                      <main id=\"player\"></main>\n";
        page.body += &format!("<footer>{}</footer>\n", self.origin());
        page.add_data("scene", &PageData::new(self, step));
        page.html()
    }

    /// The ego, and how long the scenario is, as HTML.
    fn summary(&self) -> String {
        let subject = self.subject();
        let ego = match subject.scene {
            Some(scene) => format!("Ego {}", scene.ego),
            None => "No ego".into(),
        };
        let steps = self.steps();
        let seconds = (steps.end - 1 - steps.start).max(0) as f64 * subject.scenario.dt();
        let obstacles = subject.others().count();
        escaped(&format!(
            "{ego} · {obstacles} other road users and obstacles · {seconds:.1} s"
        ))
    }

    /// Where the scenario and the page come from, as HTML.
    fn origin(&self) -> String {
        let scenario = self.subject().scenario;
        let attributes = &scenario.header.attributes;
        let told = TOLD
            .iter()
            .filter_map(|key| Some(format!("{key}: {}", attributes.get(*key)?)));
        let version = concat!("nearmiss ", env!("CARGO_PKG_VERSION"));
        let own = [version.into(), format!("SHA-256 {}", scenario.hash)];
        let all: Vec<String> = told.chain(own).map(|words| escaped(&words)).collect();
        all.join(" · ")
    }
}

/// The colours of a palette as variables of a style sheet.
fn variables(palette: &Palette) -> String {
    let colors = [
        ("map", palette.background),
        ("text", palette.text),
        ("dim", palette.dim),
        ("grid", palette.grid),
        ("road", palette.road),
        ("path", palette.path),
        ("lane", palette.lane),
        ("lane-dashed", palette.lane_dashed),
        ("crosswalk", palette.crosswalk),
        ("goal", palette.goal),
        ("ego", palette.ego),
        ("obstacle", palette.obstacle),
        ("static", palette.static_obstacle),
        ("danger", palette.danger),
        ("picked", palette.emphasised(0)),
    ];
    let each = colors.map(|(name, color)| format!("--{name}: {color};"));
    each.join(" ")
}

#[cfg(test)]
mod tests;

//! The thresholds in use, and the source of each.

use ratatui::style::{Modifier, Style};
use ratatui::text::Line;

use crate::model::Model;
use crate::widgets::row;
use crate::widgets::words::quantity;
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::{LIMITS, MEASURES, Thresholds};

/// Columns of what is limited, in a narrow window and in a wide one.
const NAME: [usize; 2] = [28, 40];
/// Columns of a value with its unit.
const VALUE: usize = 18;

pub fn text(model: &Model, width: usize) -> Vec<Line<'static>> {
    let name_width = NAME[usize::from(width > 100)];
    let theme = &model.theme;
    let thresholds = &model.thresholds;
    let title = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
    let dim = Style::new().fg(theme.dim);
    let from = match thresholds.file() {
        None => "shipped values; to change them, write thresholds.toml in the configuration folder"
            .to_string(),
        Some(file) => format!("* from {}, the others shipped", visible(file)),
    };
    let mut lines = Vec::new();
    let mut part = |name: &str, rows: Vec<(String, String, bool, String)>| {
        lines.push(Line::styled(name.to_string(), title));
        for (name, value, own, source) in rows {
            let (sign, style) = if own {
                ("* ", Style::new().fg(theme.accent))
            } else {
                ("  ", Style::new())
            };
            let cells = [
                (format!("{sign}{name}"), name_width, style),
                (value, VALUE, style),
            ];
            lines.extend(row::lines(&cells, (&source, dim), width));
        }
    };
    part("thresholds", critical(thresholds));
    part("risk scores, up to", levels(thresholds));
    part("limits used by the measures", limits(thresholds));
    let place = 1;
    for wrapped in textwrap::wrap(&from, width.saturating_sub(2).max(10))
        .iter()
        .rev()
    {
        lines.insert(place, Line::styled(format!("  {wrapped}"), dim));
    }
    lines
}

fn critical(thresholds: &Thresholds) -> Vec<(String, String, bool, String)> {
    let rows = MEASURES.iter().flat_map(|measure| {
        thresholds.for_measure(measure.id).map(|t| {
            let name = format!("{} {}", measure.id, t.name);
            (
                name,
                quantity(t.value, measure.unit),
                t.own,
                t.source.clone(),
            )
        })
    });
    rows.collect()
}

fn levels(thresholds: &Thresholds) -> Vec<(String, String, bool, String)> {
    let risk = &thresholds.risk;
    let rows = risk.levels.iter().map(|level| {
        let bounds = match (level.distance, level.time) {
            (Some(d), Some(t)) => format!("{}, {}", quantity(d, "m"), quantity(t, "s")),
            _ => "above".to_string(),
        };
        let name = format!("{} {}", level.score, level.name);
        let own = thresholds.own_level(level.score);
        let source = if own {
            String::new()
        } else {
            risk.source.clone()
        };
        (name, bounds, own, source)
    });
    rows.collect()
}

fn limits(thresholds: &Thresholds) -> Vec<(String, String, bool, String)> {
    let rows = LIMITS.iter().map(|limit| {
        let own = thresholds.own_limit(limit);
        let source = if own { "" } else { limit.source };
        let about = format!("{} ({})", limit.name, limit.measures.join(" "));
        let about = match source {
            "" => about,
            source => format!("{about} · {source}"),
        };
        let value = quantity(limit.value(&thresholds.limits), limit.unit);
        (limit.id.to_string(), value, own, about)
    });
    rows.collect()
}

//! Renders the workbench to a picture, with or without a terminal.

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::style::{Color as Ink, Modifier};

use crate::action::Action;
use crate::features::scenarios::request::{Find, Found, Survey};
use crate::loaded::{Facts, Opened, Verdicts};
use crate::message::Msg;
use crate::model::Model;
use crate::theme::Theme;
use crate::update::{self, Open, update};
use crate::views;
use nearmiss_ask::prompts::Library;
use nearmiss_render::cells::Blocks;
use nearmiss_render::{Cell, Color, Palette, Screen, ScreenRequest};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::{Config, Folders};

/// Draws the workbench with a scenario, and returns the step shown.
///
/// # Errors
/// The theme or the scenario cannot be read, or a named obstacle does not exist.
pub fn screen(wanted: &ScreenRequest) -> Result<(Screen, i64), String> {
    let folders = Folders::find()?;
    let theme = Theme::load(&wanted.theme, &folders.themes(), true)?;
    let config = Config::read(&folders.config_file()).map_err(|e| e.in_short())?;
    let library = Library::load(Some(&folders.prompts()));
    let mut model = Model::new(Vec::new(), config, theme, library, Vec::new());
    model.thresholds = std::sync::Arc::new(folders.user_thresholds()?);
    model.size = wanted.size;
    // Pictures are drawn by the program itself, the finest blocks too.
    model.look.blocks_here = Blocks::Octants;
    let config = model.config.clone();
    model.look.configure_map(&config);
    // Drawn once before, so that the map knows its size when it is pointed at the ego.
    paint(&model)?;
    let thresholds = model.thresholds.clone();
    if let Some(measure) = wanted.measure {
        model.plot.measure = measure;
    }
    let mut todo = update(
        &mut model,
        Msg::reply::<Find>(Found::All(Ok(vec![wanted.entry.clone()].into()))),
    );
    while let Some(effect) = todo.pop() {
        let Some(Open { id, entry, .. }) = effect.request() else {
            continue;
        };
        let opened = read(entry, wanted, &thresholds)?;
        let msg = Msg::reply::<Open>((*id, Ok(Box::new(opened))));
        let effects = update(&mut model, msg);
        todo.extend(update::compute_now(&mut model, effects));
    }
    let facts = Facts::read(
        &wanted.entry,
        &wanted.ego,
        &thresholds,
        &Verdicts::default(),
    );
    drop(update(&mut model, Msg::reply::<Survey>((0, facts))));
    if let Some(id) = wanted.obstacle {
        let known = model
            .opened
            .as_ref()
            .is_some_and(|o| o.scenario.obstacle(id).is_some());
        if !known {
            return Err(format!(
                "{}: no obstacle {id} in the scenario",
                wanted.entry.display()
            ));
        }
    }
    match wanted.step {
        Some(step) => model.clock.go(step),
        None => drop(update::perform(&mut model, Action::CollisionStep)),
    }
    if wanted.obstacle.is_some() {
        model.picked = wanted.obstacle;
    }
    model.toasts.clear();
    model.refresh();
    update::compute_missing(&mut model);
    Ok((paint(&model)?, model.clock.step()))
}

fn read(
    entry: &nearmiss_formats::Entry,
    wanted: &ScreenRequest,
    thresholds: &Thresholds,
) -> Result<Opened, String> {
    let opened = Opened::read(entry, &wanted.ego, thresholds);
    opened.map_err(|error| format!("{}: {error}", entry.display()))
}

/// What the screen of the model's size shows.
///
/// # Errors
/// It could not be drawn.
pub fn paint(model: &Model) -> Result<Screen, String> {
    let backend = TestBackend::new(model.size.0, model.size.1);
    let mut terminal = Terminal::new(backend).map_err(|e| e.to_string())?;
    model.drawn.draw_for_picture(true);
    let drawn = terminal.draw(|frame| views::draw(frame, model));
    model.drawn.draw_for_picture(false);
    drawn.map_err(|e| e.to_string())?;
    let palette = if model.theme.dark { "dark" } else { "light" };
    let mut palette = Palette::named(palette, std::path::Path::new(""))?;
    palette.background = ink(model.theme.background).unwrap_or(palette.background);
    Ok(cells(terminal.backend().buffer(), &palette))
}

fn cells(buffer: &Buffer, palette: &Palette) -> Screen {
    let cell = |cell: &ratatui::buffer::Cell| {
        let style = cell.style();
        let has = |modifier| style.add_modifier.contains(modifier);
        let mut text = style.fg.and_then(ink).unwrap_or(palette.text);
        let mut ground = style.bg.and_then(ink);
        if has(Modifier::REVERSED) {
            (text, ground) = (ground.unwrap_or(palette.background), Some(text));
        }
        if has(Modifier::DIM) {
            text = text.towards(ground.unwrap_or(palette.background), 0.4);
        }
        Cell {
            symbol: cell.symbol().to_string(),
            text,
            ground,
            bold: has(Modifier::BOLD),
            underlined: has(Modifier::UNDERLINED),
        }
    };
    Screen {
        columns: usize::from(buffer.area.width),
        cells: buffer.content().iter().map(cell).collect(),
        ground: palette.background,
    }
}

/// A colour of the terminal; `None` for its own.
fn ink(color: Ink) -> Option<Color> {
    let index = match color {
        Ink::Reset => return None,
        Ink::Rgb(r, g, b) => return Some(Color::rgb(r, g, b)),
        Ink::Indexed(index) => index,
        Ink::Black => 0,
        Ink::Red => 1,
        Ink::Green => 2,
        Ink::Yellow => 3,
        Ink::Blue => 4,
        Ink::Magenta => 5,
        Ink::Cyan => 6,
        Ink::Gray => 7,
        Ink::DarkGray => 8,
        Ink::LightRed => 9,
        Ink::LightGreen => 10,
        Ink::LightYellow => 11,
        Ink::LightBlue => 12,
        Ink::LightMagenta => 13,
        Ink::LightCyan => 14,
        Ink::White => 15,
    };
    Some(indexed(index))
}

/// The 256 colours as most terminals have them.
fn indexed(index: u8) -> Color {
    const BASE: [u32; 16] = [
        0x000000, 0xcd3131, 0x0dbc79, 0xe5e510, 0x2472c8, 0xbc3fbc, 0x11a8cd, 0xcccccc, 0x666666,
        0xf14c4c, 0x23d18b, 0xf5f543, 0x3b8eea, 0xd670d6, 0x29b8db, 0xf2f2f2,
    ];
    const STEPS: [u8; 6] = [0, 95, 135, 175, 215, 255];
    match index {
        0..=15 => Color::hex(BASE[usize::from(index)]),
        16..=231 => {
            let cube = usize::from(index - 16);
            Color::rgb(STEPS[cube / 36], STEPS[cube / 6 % 6], STEPS[cube % 6])
        }
        _ => {
            let gray = 8 + (index - 232) * 10;
            Color::rgb(gray, gray, gray)
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_formats::{EgoSelection, bundled};

    #[test]
    fn the_workbench_is_a_picture_of_its_cells() {
        let wanted = ScreenRequest {
            entry: bundled().remove(2),
            ego: EgoSelection::Beside,
            size: (120, 40),
            step: None,
            obstacle: None,
            measure: None,
            theme: "dark".into(),
        };
        let (painted, step) = screen(&wanted).unwrap();
        assert_eq!(step, 59, "the contact");
        assert_eq!(painted.cells.len(), 120 * 40);
        let words: String = painted.cells.iter().map(|c| c.symbol.as_str()).collect();
        assert!(words.contains("ZAM_RedLight-1_1_T-1") && words.contains("contact"));
        // The map is made of cells that a picture can draw, and the list knows its scenario.
        let blocks = words.chars().filter_map(Blocks::of_symbol);
        let octants = blocks.filter(|(blocks, _)| *blocks == Blocks::Octants);
        assert!(octants.count() > 10, "{words}");
        assert!(words.contains("0X") && !words.contains(" … "), "{words}");
        let unknown = ScreenRequest {
            obstacle: Some(-7),
            ..wanted
        };
        assert!(screen(&unknown).unwrap_err().contains("no obstacle -7"));
    }

    #[test]
    fn colours_of_terminals() {
        assert_eq!(indexed(196), Color::rgb(255, 0, 0));
        assert_eq!(indexed(244), Color::rgb(128, 128, 128));
        assert_eq!(ink(Ink::Reset), None);
    }
}

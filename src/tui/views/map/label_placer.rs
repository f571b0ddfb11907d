//! Places labels and symbols on the map without overlap, in order of priority.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use unicode_width::UnicodeWidthStr;

use super::CellView;

/// Cells that no screen has.
const FAR: i32 = 1_000_000;

/// A box of cells, the ends not in it.
#[derive(Clone, Copy)]
pub struct Area {
    x: (i32, i32),
    y: (i32, i32),
}

impl Area {
    fn meets(&self, other: &Self) -> bool {
        self.x.0 < other.x.1 && other.x.0 < self.x.1 && self.y.0 < other.y.1 && other.y.0 < self.y.1
    }
}

/// An area covered on the canvas, metres from the middle.
#[derive(Clone, Copy)]
pub struct Body {
    /// From left to right.
    pub x: (f64, f64),
    /// From below to above.
    pub y: (f64, f64),
}

impl Body {
    /// Around points of the canvas; nothing around none.
    pub fn around(points: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let mut points = points.into_iter();
        let (x, y) = points.next()?;
        let first = Self {
            x: (x, x),
            y: (y, y),
        };
        Some(points.fold(first, |b, (x, y)| Self {
            x: (b.x.0.min(x), b.x.1.max(x)),
            y: (b.y.0.min(y), b.y.1.max(y)),
        }))
    }
}

/// The cells of the map that can be written into.
pub struct LabelPlacer<'a> {
    buffer: &'a mut Buffer,
    area: Rect,
    /// Metres of a column and of a row.
    size: (f64, f64),
    half: (f64, f64),
    taken: Vec<Area>,
}

/// The part of the map's width that a long label may take: a third.
const SHARE: i32 = 3;

impl<'a> LabelPlacer<'a> {
    pub fn new(buffer: &'a mut Buffer, area: Rect, view: &CellView) -> Self {
        Self {
            buffer,
            area,
            size: view.cell,
            half: view.half,
            taken: Vec::new(),
        }
    }

    /// The cells of a body.
    pub fn cells(&self, body: &Body) -> Area {
        let cell = |metres: f64, size: f64| {
            let far = f64::from(FAR);
            (metres / size).floor().clamp(-far, far) as i32
        };
        let column = |x: f64| cell(x + self.half.0, self.size.0);
        let row = |y: f64| cell(self.half.1 - y, self.size.1);
        Area {
            x: (column(body.x.0), column(body.x.1) + 1),
            y: (row(body.y.1), row(body.y.0) + 1),
        }
    }

    /// Keeps words away from here.
    pub fn reserve(&mut self, area: Area) {
        self.taken.push(area);
    }

    fn inside(&self, area: &Area) -> bool {
        let (columns, rows) = (i32::from(self.area.width), i32::from(self.area.height));
        area.x.0 >= 0 && area.x.1 <= columns && area.y.0 >= 0 && area.y.1 <= rows
    }

    /// Writes words with their middle at a point of the canvas, over anything; they are not covered any more. Says
    /// whether there is room on the map.
    pub fn put(&mut self, at: (f64, f64), words: &str, style: Style) -> bool {
        let area = self.centered(at, words);
        let inside = self.inside(&area);
        if inside {
            self.write(area, words, style);
        }
        inside
    }

    /// The same, where nothing else is.
    pub fn put_if_free(&mut self, at: (f64, f64), words: &str, style: Style) -> bool {
        let area = self.centered(at, words);
        self.is_free(&area) && self.put(at, words, style)
    }

    fn centered(&self, (x, y): (f64, f64), words: &str) -> Area {
        let cell = self.cells(&Body {
            x: (x, x),
            y: (y, y),
        });
        let width = columns(words);
        let left = cell.x.0 - (width - 1) / 2;
        Area {
            x: (left, left + width),
            y: cell.y,
        }
    }

    /// Whether words are short beside the map: longer ones would hide what they stand on.
    pub fn has_room(&self, words: &str) -> bool {
        columns(words) * SHARE <= i32::from(self.area.width)
    }

    /// Writes words beside a body, where they cover neither anything written nor anything reserved; says whether there
    /// was room.
    pub fn beside(&mut self, body: &Area, words: &str, style: Style) -> bool {
        self.beside_clear_of(&[], body, words, style)
    }

    /// The same, where they do not cover what is in `others` either.
    pub fn beside_clear_of(
        &mut self,
        others: &[Area],
        body: &Area,
        words: &str,
        style: Style,
    ) -> bool {
        let width = columns(words);
        let (right, left) = (body.x.1 + 1, body.x.0 - 1 - width);
        let (middle, over, under) = ((body.y.0 + body.y.1 - 1) / 2, body.y.0 - 1, body.y.1);
        let centered = (body.x.0 + body.x.1 - width) / 2;
        let spots = [
            (right, middle),
            (left, middle),
            (centered, over),
            (centered, under),
            (right, over),
            (right, under),
            (left, over),
            (left, under),
        ];
        let areas = spots.map(|(x, y)| Area {
            x: (x, x + width),
            y: (y, y + 1),
        });
        let clear = |area: &Area| !others.iter().any(|other| other.meets(area));
        let mut areas = areas.into_iter();
        let free = areas.find(|area| self.is_free(area) && clear(area));
        if let Some(area) = free {
            self.write(area, words, style);
        }
        free.is_some()
    }

    fn is_free(&self, area: &Area) -> bool {
        // A column stays free between two labels, so that they do not read as one.
        let wider = Area {
            x: (area.x.0 - 1, area.x.1 + 1),
            ..*area
        };
        self.inside(area) && !self.taken.iter().any(|other| other.meets(&wider))
    }

    fn write(&mut self, area: Area, words: &str, style: Style) {
        let at = |from: u16, cell: i32| from + u16::try_from(cell).unwrap_or(0);
        let (x, y) = (at(self.area.x, area.x.0), at(self.area.y, area.y.0));
        let width = u16::try_from(area.x.1 - area.x.0).unwrap_or(0);
        for cell in Rect::new(x, y, width, 1)
            .intersection(self.area)
            .positions()
        {
            // What lies below may be dim or reversed; words are as their style says, and no more.
            self.buffer[cell].modifier = Modifier::empty();
        }
        self.buffer.set_string(x, y, words, style);
        self.taken.push(area);
    }
}

fn columns(words: &str) -> i32 {
    i32::try_from(words.width()).unwrap_or(FAR)
}

//! A picture as a list of things to draw, in points (1/72 inch), x to the right and y down: what every format is
//! made from; and the formats by their names.

use std::path::Path;

use strum::{IntoStaticStr, VariantArray};

use super::{Color, RasterError, png, svg};

/// A point on the page, in points.
pub type Spot = (f64, f64);

/// A box on the page, in points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Left end.
    pub x: f64,
    /// Upper end.
    pub y: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

impl Area {
    /// The right end.
    #[must_use]
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    /// The lower end.
    #[must_use]
    pub fn bottom(&self) -> f64 {
        self.y + self.height
    }

    /// The middle.
    #[must_use]
    pub fn center(&self) -> Spot {
        (self.x + self.width / 2.0, self.y + self.height / 2.0)
    }

    /// The box around some points; `None` for none.
    #[must_use]
    pub fn around(spots: &[Spot]) -> Option<Self> {
        let range = |value: fn(&Spot) -> f64| {
            let low = spots.iter().map(value).reduce(f64::min)?;
            Some((low, spots.iter().map(value).reduce(f64::max)?))
        };
        let ((left, right), (top, bottom)) = (range(|s| s.0)?, range(|s| s.1)?);
        Some(Self {
            x: left,
            y: top,
            width: right - left,
            height: bottom - top,
        })
    }

    /// The same box with a margin around it; a negative one makes it smaller.
    #[must_use]
    pub fn grown(&self, by: f64) -> Self {
        Self {
            x: self.x - by,
            y: self.y - by,
            width: self.width + 2.0 * by,
            height: self.height + 2.0 * by,
        }
    }

    /// Whether two boxes have a point in common that is on no edge.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        self.x < other.right()
            && other.x < self.right()
            && self.y < other.bottom()
            && other.y < self.bottom()
    }

    /// Whether the other box lies within this one.
    #[must_use]
    pub fn holds(&self, other: &Self) -> bool {
        self.x <= other.x
            && self.y <= other.y
            && other.right() <= self.right()
            && other.bottom() <= self.bottom()
    }
}

/// A piece of an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Segment {
    /// Begins at a point.
    Move(Spot),
    /// A straight line to a point.
    Line(Spot),
    /// A cubic Bézier curve: two control points and its end.
    Curve(Spot, Spot, Spot),
    /// Back to where it began.
    Close,
}

/// How a line is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    /// Its colour.
    pub color: Color,
    /// Its width, points.
    pub width: f64,
    /// Lengths of dashes and gaps in turn, points; empty for an unbroken line.
    pub dashes: Vec<f64>,
    /// How far into the dashes and gaps it begins, points.
    pub phase: f64,
    /// Whether its ends are round.
    pub round: bool,
}

impl Stroke {
    /// An unbroken line.
    #[must_use]
    pub fn new(color: Color, width: f64) -> Self {
        Self {
            color,
            width,
            dashes: Vec::new(),
            phase: 0.0,
            round: false,
        }
    }

    /// The same line, dashed.
    #[must_use]
    pub fn dashed(mut self, dashes: &[f64]) -> Self {
        self.dashes = dashes.to_vec();
        self
    }

    /// The same line with round ends and corners.
    #[must_use]
    pub fn rounded(mut self) -> Self {
        self.round = true;
        self
    }
}

/// Where a text has the point at which it stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// At its beginning.
    Start,
    /// In its middle.
    Middle,
    /// At its end.
    End,
}

/// A line of text.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    /// Where it stands, on its base line.
    pub at: Spot,
    /// What it says.
    pub words: String,
    /// Size of the letters, points.
    pub size: f64,
    /// Their colour.
    pub color: Color,
    /// Whether they are bold.
    pub bold: bool,
    /// Where `at` is in it.
    pub anchor: Anchor,
    /// Whether it is turned to be read from below to above.
    pub upwards: bool,
    /// The colour around the letters that keeps them readable over lines.
    pub halo: Option<Color>,
    /// The width of every letter, points, where letters stand in columns.
    pub pitch: Option<f64>,
}

impl Text {
    /// A line of text that begins at a point.
    #[must_use]
    pub fn new(at: Spot, words: impl Into<String>, size: f64, color: Color) -> Self {
        Self {
            at,
            words: words.into(),
            size,
            color,
            bold: false,
            anchor: Anchor::Start,
            upwards: false,
            halo: None,
            pitch: None,
        }
    }

    /// The same with its point elsewhere.
    #[must_use]
    pub fn anchored(mut self, anchor: Anchor) -> Self {
        self.anchor = anchor;
        self
    }

    /// The same in bold.
    #[must_use]
    pub fn in_bold(mut self, bold: bool) -> Self {
        self.bold = bold;
        self
    }

    /// The same with a halo.
    #[must_use]
    pub fn with_halo(mut self, color: Color) -> Self {
        self.halo = Some(color);
        self
    }

    /// How wide text is taken to be, points: fonts differ, and every one that is likely is narrower.
    #[must_use]
    pub fn width(words: &str, size: f64) -> f64 {
        words.chars().map(letter).sum::<f64>() * size
    }
}

/// Width of a letter in parts of its size, as wide as it is in Helvetica and in PNG.
fn letter(c: char) -> f64 {
    match c {
        ' ' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' => 0.3,
        'i' | 'j' | 'l' | 'f' | 't' | 'r' | 'I' | '(' | ')' | '-' | '/' => 0.42,
        'm' | 'w' | 'M' | 'W' | '%' => 0.85,
        'A'..='Z' => 0.7,
        _ => 0.57,
    }
}

/// Something to draw; what comes later lies over what came before.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// An outline, filled or stroked or both.
    Path {
        /// The outline.
        path: Vec<Segment>,
        /// Its inside.
        fill: Option<Color>,
        /// Its line.
        stroke: Option<Stroke>,
    },
    /// A line of text.
    Text(Text),
    /// From here on things belong together, under a name, and are cut off outside an area if there is one.
    Begin {
        /// What they are.
        name: &'static str,
        /// Where they are seen.
        clip: Option<Area>,
    },
    /// The end of what began last.
    End,
}

/// Where a picture comes from: stands in its file, not on it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Provenance {
    /// A title.
    pub title: String,
    /// What is to be seen, in a sentence or two.
    pub description: String,
    /// Names and values: program, scenario, hash, step and so on.
    pub facts: Vec<(&'static str, String)>,
}

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Width and height, points.
    pub size: (f64, f64),
    /// What is behind everything.
    pub background: Color,
    /// What is drawn, in order.
    pub items: Vec<Item>,
    /// Where it comes from.
    pub provenance: Provenance,
}

impl Picture {
    /// An empty one.
    #[must_use]
    pub fn new(size: (f64, f64), background: Color) -> Self {
        Self {
            size,
            background,
            items: Vec::new(),
            provenance: Provenance::default(),
        }
    }

    /// Fills a ring of points.
    pub fn polygon(&mut self, ring: &[Spot], fill: Option<Color>, stroke: Option<Stroke>) {
        let path = closed(ring);
        self.items.push(Item::Path { path, fill, stroke });
    }

    /// Draws an open line.
    pub fn line(&mut self, points: &[Spot], stroke: Stroke) {
        if points.len() > 1 {
            self.items.push(Item::Path {
                path: line(points),
                fill: None,
                stroke: Some(stroke),
            });
        }
    }

    /// Draws a box.
    pub fn rectangle(&mut self, area: &Area, fill: Option<Color>, stroke: Option<Stroke>) {
        let (right, bottom) = (area.right(), area.bottom());
        let ring = [
            (area.x, area.y),
            (right, area.y),
            (right, bottom),
            (area.x, bottom),
        ];
        self.polygon(&ring, fill, stroke);
    }

    /// Draws a circle.
    pub fn circle(
        &mut self,
        center: Spot,
        radius: f64,
        fill: Option<Color>,
        stroke: Option<Stroke>,
    ) {
        let path = circle(center, radius);
        self.items.push(Item::Path { path, fill, stroke });
    }

    /// Writes a line of text.
    pub fn text(&mut self, text: Text) {
        self.items.push(Item::Text(text));
    }

    /// Draws things that belong together.
    pub fn group(&mut self, name: &'static str, clip: Option<Area>, draw: impl FnOnce(&mut Self)) {
        self.items.push(Item::Begin { name, clip });
        let before = self.items.len();
        draw(self);
        if self.items.len() == before {
            // Nothing in it: no empty group in the file.
            self.items.pop();
        } else {
            self.items.push(Item::End);
        }
    }
}

fn line(points: &[Spot]) -> Vec<Segment> {
    let mut path: Vec<Segment> = points.iter().copied().map(Segment::Line).collect();
    if let Some(first) = points.first() {
        path[0] = Segment::Move(*first);
    }
    path
}

/// The outline of a ring of points.
pub(super) fn closed(ring: &[Spot]) -> Vec<Segment> {
    let mut path = line(ring);
    path.push(Segment::Close);
    path
}

/// Four curves that are a circle to the eye.
pub(super) fn circle((x, y): Spot, r: f64) -> Vec<Segment> {
    let k = r * 0.552_284_75;
    vec![
        Segment::Move((x + r, y)),
        Segment::Curve((x + r, y + k), (x + k, y + r), (x, y + r)),
        Segment::Curve((x - k, y + r), (x - r, y + k), (x - r, y)),
        Segment::Curve((x - r, y - k), (x - k, y - r), (x, y - r)),
        Segment::Curve((x + k, y - r), (x + r, y - k), (x + r, y)),
        Segment::Close,
    ]
}

/// How a picture is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Format {
    /// Shapes and text, for print.
    Svg,
    /// Pixels.
    Png,
    /// Pixels that move.
    Gif,
    /// The same as a film, where ffmpeg is.
    Mp4,
    /// A page that plays a scenario in a browser.
    Html,
}

nearmiss_record::named!(Format);

impl Format {
    /// The one that a file's ending asks for.
    #[must_use]
    pub fn of_file(path: &Path) -> Option<Self> {
        Self::parse(&path.extension()?.to_str()?.to_ascii_lowercase())
    }

    /// Pixels of an inch unless something else is asked for: as printers want them, or as screens have them.
    #[must_use]
    pub fn usual_dpi(self) -> f64 {
        match self {
            Self::Gif => 150.0,
            _ => 300.0,
        }
    }

    /// Whether it shows several pictures one after the other.
    #[must_use]
    pub fn is_film(self) -> bool {
        matches!(self, Self::Gif | Self::Mp4)
    }

    /// Whether it shows one picture.
    #[must_use]
    pub fn is_picture(self) -> bool {
        matches!(self, Self::Svg | Self::Png)
    }

    /// One picture as a file, SVG or PNG.
    ///
    /// # Errors
    /// It would have too many pixels.
    pub fn encode(self, picture: &Picture, dpi: f64) -> Result<Vec<u8>, RasterError> {
        match self {
            Self::Svg => Ok(svg(picture).into_bytes()),
            _ => png(picture, dpi),
        }
    }
}

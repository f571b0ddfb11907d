//! Roads as OpenDRIVE tells them: reference line, lane sections, lanes, links, signs and lights.

use nearmiss_base::geometry::{Point, Pose};

use super::geometry::{Cubic, Offset, Piece, pose, value};
use super::lane::{Lane, Section, sections, speed};
use super::tree::Node;
use crate::commonroad::ReadError;

/// A road.
pub struct Road {
    pub id: String,
    /// Metres.
    pub length: f64,
    pub pieces: Vec<Piece>,
    pub offset: Vec<Cubic>,
    pub sections: Vec<Section>,
    /// What the links name: before and behind.
    pub links: [Option<RoadLink>; 2],
    pub is_connecting: bool,
    /// Vehicles drive on the left.
    pub left_hand: bool,
    /// From the beginning on.
    pub types: Vec<Type>,
    pub signals: Vec<Signal>,
    pub has_heights: bool,
    pub is_tilted: bool,
}

/// The type of a road from a place on.
#[derive(Default)]
pub struct Type {
    /// Metres.
    pub from: f64,
    pub kind: String,
    /// m/s.
    pub limit: Option<f64>,
}

/// The end of a road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum End {
    Start,
    End,
}

/// What a road is linked to.
pub enum RoadLink {
    Road(String, End),
    Junction(String),
}

/// The end of a road that a link names.
pub fn contact(node: &Node) -> End {
    match node.text("contactPoint") {
        Some("end") => End::End,
        _ => End::Start,
    }
}

/// Reads a `<road>`.
pub fn read(node: &Node, moved: &Offset) -> Result<Road, ReadError> {
    let mut pieces = Vec::new();
    for geometry in node
        .child("planView")
        .iter()
        .flat_map(|p| p.all("geometry"))
    {
        pieces.push(Piece::read(geometry, moved)?);
    }
    if pieces.is_empty() {
        return Err(node.fail("no <geometry> in its <planView>"));
    }
    pieces.sort_by(|a, b| a.s.total_cmp(&b.s));
    let length = node.needed_number("length")?;
    if !(length > 0.0 && length <= 1e6) {
        return Err(node.fail(format!("length=\"{length}\" is not from 0 to 1000000")));
    }
    let lanes = node
        .child("lanes")
        .ok_or_else(|| node.fail("no <lanes> in it"))?;
    let mut offset = Vec::new();
    for cubic in lanes.all("laneOffset") {
        offset.push(Cubic::read(cubic, "s")?);
    }
    offset.sort_by(|a, b| a.from.total_cmp(&b.from));
    let link = |name: &str| -> Result<Option<RoadLink>, ReadError> {
        let Some(link) = node.at(&["link", name]) else {
            return Ok(None);
        };
        if link.text("elementType") == Some("junction") {
            let id = link.text("elementId").unwrap_or_default();
            return Ok(Some(RoadLink::Junction(id.to_string())));
        }
        let id = link.needed("elementId")?.to_string();
        Ok(Some(RoadLink::Road(id, contact(link))))
    };
    let mut signals = Vec::new();
    for signal in node.child("signals").iter().flat_map(|s| s.all("signal")) {
        signals.push(read_signal(signal)?);
    }
    let is_flat = |profile: &str, of: &str| -> Result<bool, ReadError> {
        let mut all = node
            .child(profile)
            .into_iter()
            .flat_map(|p| p.all(of))
            .map(|of| Cubic::read(of, "s"));
        all.try_fold(true, |flat, of| Ok(flat && of?.of == [0.0; 4]))
    };
    Ok(Road {
        id: node.needed("id")?.to_string(),
        length,
        pieces,
        offset,
        sections: sections(lanes, length)?,
        links: [link("predecessor")?, link("successor")?],
        is_connecting: node
            .text("junction")
            .is_some_and(|j| j != "-1" && !j.is_empty()),
        left_hand: node.text("rule") == Some("LHT"),
        types: types(node)?,
        signals,
        has_heights: !is_flat("elevationProfile", "elevation")?,
        is_tilted: !is_flat("lateralProfile", "superelevation")?,
    })
}

fn types(node: &Node) -> Result<Vec<Type>, ReadError> {
    let mut all = Vec::new();
    for of in node.all("type") {
        let limit = of.child("speed").map(|s| speed(s, "max", "unit"));
        all.push(Type {
            from: of.or_zero("s")?,
            kind: of.text("type").unwrap_or_default().to_string(),
            limit: limit.transpose()?.flatten(),
        });
    }
    all.sort_by(|a, b| a.from.total_cmp(&b.from));
    Ok(all)
}

impl Road {
    /// Its type at a place: the first one before it begins.
    pub fn kind(&self, s: f64) -> Option<&Type> {
        let begun = self.types.iter().rfind(|t| t.from <= s + 1e-9);
        begun.or(self.types.first())
    }

    /// Whether a lane is driven the way its road runs.
    pub fn is_along(&self, lane: &Lane) -> bool {
        ((lane.id < 0) != self.left_hand) != lane.is_reversed
    }

    /// The pose of its reference line.
    pub fn pose(&self, s: f64) -> Pose {
        pose(&self.pieces, s)
    }

    /// A place beside its reference line.
    pub fn point(&self, s: f64, t: f64) -> Point {
        self.pose(s).to_world(&Point::new(0.0, t))
    }

    /// How far to the left the borders of the lanes of a section are, from the left to the right: one more than lanes.
    pub fn borders(&self, section: &Section, s: f64) -> Vec<f64> {
        let middle = value(&self.offset, s);
        let side = |lanes: &mut dyn Iterator<Item = &Lane>, sign: f64| -> Vec<f64> {
            let mut reached = 0.0;
            let all = lanes.map(|lane| {
                reached = lane.reaches(reached, s);
                middle + sign * reached
            });
            all.collect()
        };
        let mut left = side(&mut section.lanes.iter().rev().filter(|l| l.id > 0), 1.0);
        left.reverse();
        left.push(middle);
        left.extend(side(&mut section.lanes.iter().filter(|l| l.id < 0), -1.0));
        left
    }

    /// The places at which borders of a section have points: where something begins, and so close that straight lines
    /// between them are within `tolerance` metres; and whether they are, or would need too many points.
    pub fn places(&self, section: &Section, tolerance: f64) -> (Vec<f64>, bool) {
        let mut fixed = vec![section.from, section.to];
        fixed.extend(self.pieces.iter().map(|p| p.s));
        fixed.extend(self.offset.iter().map(|c| c.from));
        fixed.extend(section.lanes.iter().flat_map(Lane::changes));
        fixed.retain(|s| (section.from..=section.to).contains(s));
        fixed.sort_by(f64::total_cmp);
        fixed.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let mut all = Vec::new();
        let mut is_exact = true;
        for pair in fixed.windows(2) {
            all.push(pair[0]);
            is_exact &= self.between(section, (pair[0], pair[1]), tolerance, MAX_DEPTH, &mut all);
        }
        all.extend(fixed.last());
        (all, is_exact)
    }

    /// The points across the road at a place, without the jump to what begins there.
    fn across(&self, section: &Section, s: f64) -> Vec<Point> {
        let all = self.borders(section, s).into_iter();
        all.map(|t| self.point(s, t)).collect()
    }

    /// Adds the places between two; whether they are enough.
    fn between(
        &self,
        section: &Section,
        (from, to): (f64, f64),
        tolerance: f64,
        deeper: usize,
        all: &mut Vec<f64>,
    ) -> bool {
        if to - from < SHORTEST {
            return true;
        }
        let middle = f64::midpoint(from, to);
        let quarter = f64::midpoint(from, middle);
        let (a, b) = (self.across(section, from), self.across(section, to - 1e-7));
        let off = |s: f64| {
            let points = self.across(section, s);
            let each = points.iter().zip(a.iter().zip(&b));
            let away =
                each.map(|(p, (a, b))| nearmiss_base::geometry::distance_to_segment(p, a, b));
            away.fold(0.0, f64::max)
        };
        if off(middle).max(off(quarter)) <= tolerance {
            return true;
        }
        if deeper == 0 {
            return false;
        }
        let before = self.between(section, (from, middle), tolerance, deeper - 1, all);
        all.push(middle);
        self.between(section, (middle, to), tolerance, deeper - 1, all) && before
    }
}

/// No points are nearer to each other, metres.
const SHORTEST: f64 = 0.05;

/// Halvings of a stretch at most.
const MAX_DEPTH: usize = 12;

/// A sign or a light.
pub struct Signal {
    pub id: String,
    pub s: f64,
    pub t: f64,
    pub kind: String,
    pub subtype: String,
    pub is_dynamic: bool,
    /// Whether it is for those that drive along the road, and for those against it.
    pub along: bool,
    pub against: bool,
    /// In m/s where it is a speed.
    pub value: Option<f64>,
    /// Ids of lanes; all that it looks at where none is named.
    pub lanes: Vec<(i64, i64)>,
}

/// Reads a `<signal>`.
pub fn read_signal(node: &Node) -> Result<Signal, ReadError> {
    let mut lanes = Vec::new();
    for validity in node.all("validity") {
        let id = |name: &str| Ok::<i64, ReadError>(validity.or_zero(name)? as i64);
        lanes.push((id("fromLane")?, id("toLane")?));
    }
    let orientation = node.text("orientation");
    Ok(Signal {
        id: node.text("id").unwrap_or_default().to_string(),
        s: node.or_zero("s")?,
        t: node.or_zero("t")?,
        kind: node.text("type").unwrap_or_default().to_string(),
        subtype: node.text("subtype").unwrap_or_default().to_string(),
        along: orientation != Some("-"),
        against: orientation != Some("+"),
        is_dynamic: node.text("dynamic") == Some("yes"),
        value: speed(node, "value", "unit")?,
        lanes,
    })
}

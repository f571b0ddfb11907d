//! Lanes and the sections of a road with them.

use super::geometry::{Cubic, value};
use super::tree::Node;
use crate::commonroad::ReadError;
use crate::opendrive::user_data::{KeptLanelet, LANELET, PART_OF};

/// Lanes that stay the same for a while.
pub struct Section {
    /// Where it begins and ends, metres.
    pub from: f64,
    pub to: f64,
    /// From the left to the right, without the one in the middle.
    pub lanes: Vec<Lane>,
    pub middle_mark: Option<(String, String)>,
}

/// A lane.
#[derive(Clone)]
pub struct Lane {
    /// Positive to the left of the reference line.
    pub id: i64,
    pub kind: String,
    /// Whether it is driven against the direction that its side has.
    pub is_reversed: bool,
    /// Whether it is driven in both directions.
    pub is_both_ways: bool,
    /// Where its section begins as the file tells it, metres.
    begins: f64,
    widths: Vec<Cubic>,
    /// Distances of its outer border, instead of widths.
    borders: Vec<Cubic>,
    pub predecessors: Vec<i64>,
    pub successors: Vec<i64>,
    /// Type and weight of the marking of its outer border.
    pub mark: Option<(String, String)>,
    /// m/s.
    pub limit: Option<f64>,
    /// The id of the lanelet that it was.
    pub lanelet: Option<i64>,
    /// The lanelet that it was, where all of it was written.
    pub kept: Option<KeptLanelet>,
    /// The lanelet from whose lane it was cut off.
    pub part_of: Option<i64>,
}

/// A speed in m/s.
pub fn speed(node: &Node, name: &str, unit: &str) -> Result<Option<f64>, ReadError> {
    if node
        .text(name)
        .is_some_and(|t| t.trim().parse::<f64>().is_err())
    {
        // `no limit` and `undefined`.
        return Ok(None);
    }
    let value = node.number(name)?.filter(|v| *v > 0.0);
    Ok(value.map(|v| match node.text(unit) {
        Some("km/h") => v / 3.6,
        Some("mph") => v * 0.447_04,
        _ => v,
    }))
}

/// A section as the file tells it, and the sides of the road of which it tells: left and right.
struct SectionInFile {
    section: Section,
    sides: [bool; 2],
}

/// The sections of a road, in order.
///
/// Those of one side only end where the next of that side begins: sections of both sides are cut where either begins.
pub fn sections(lanes: &Node, length: f64) -> Result<Vec<Section>, ReadError> {
    let mut all = Vec::new();
    for node in lanes.all("laneSection") {
        all.push(section(node)?);
    }
    if all.is_empty() {
        return Err(lanes.fail("no <laneSection> in it"));
    }
    all.sort_by(|a, b| a.section.from.total_cmp(&b.section.from));
    let mut cuts: Vec<f64> = all.iter().map(|r| r.section.from).collect();
    cuts.dedup_by(|a, b| (*a - *b).abs() < PLACE_TOLERANCE);
    let ends = cuts.iter().skip(1).copied().chain([length]);
    let pieces = cuts
        .iter()
        .zip(ends.collect::<Vec<_>>())
        .map(|(from, to)| piece(&all, *from, to.min(length)));
    Ok(pieces.collect())
}

/// Places nearer to each other are the same, metres.
const PLACE_TOLERANCE: f64 = 1e-9;

/// What sections tell of a stretch in which none begins.
fn piece(all: &[SectionInFile], from: f64, to: f64) -> Section {
    let mut lanes = Vec::new();
    let mut middle_mark = None;
    for (side, sign) in [(0, 1), (1, -1)] {
        let at = |s: f64| {
            let tells = |r: &SectionInFile| r.sides[side] && r.section.from <= s + PLACE_TOLERANCE;
            all.iter().rposition(tells)
        };
        let Some(place) = at(from) else {
            continue;
        };
        let section = &all[place].section;
        middle_mark = middle_mark.or_else(|| section.middle_mark.clone());
        let own = section.lanes.iter().filter(|l| l.id.signum() == sign);
        lanes.extend(own.cloned().map(|mut lane| {
            // Where it goes on beyond a cut it follows itself.
            if section.from < from - PLACE_TOLERANCE {
                lane.predecessors = vec![lane.id];
            }
            if all
                .last()
                .is_some_and(|last| last.section.from >= to - PLACE_TOLERANCE)
                && at(to) == Some(place)
            {
                lane.successors = vec![lane.id];
            }
            lane
        }));
    }
    Section {
        from,
        to,
        lanes,
        middle_mark,
    }
}

fn section(node: &Node) -> Result<SectionInFile, ReadError> {
    let mut lanes = Vec::new();
    let from = node.needed_number("s")?;
    let both = node.text("singleSide") != Some("true");
    let mut sides = [both; 2];
    for (name, tells) in ["left", "right"].into_iter().zip(&mut sides) {
        let side = node.child(name);
        *tells |= side.is_some();
        for lane in side.iter().flat_map(|s| s.all("lane")) {
            lanes.push(self::lane(lane, from)?);
        }
    }
    lanes.retain(|lane| lane.id != 0);
    lanes.sort_by_key(|lane| std::cmp::Reverse(lane.id));
    lanes.dedup_by_key(|lane| lane.id);
    let middle = node.at(&["center", "lane"]);
    if let Some(middle) = middle {
        // It is the line between both sides, whatever its type.
        middle.skip_attributes(&["id", "type"]);
    }
    let section = Section {
        from,
        to: from,
        lanes,
        middle_mark: middle.and_then(mark),
    };
    Ok(SectionInFile { section, sides })
}

fn mark(lane: &Node) -> Option<(String, String)> {
    let mark = lane.child("roadMark")?;
    let text = |name: &str| mark.text(name).unwrap_or_default().to_string();
    Some((text("type"), text("weight")))
}

fn lane(node: &Node, begins: f64) -> Result<Lane, ReadError> {
    let id = node.needed("id")?;
    let id: i64 = id
        .trim()
        .parse()
        .ok()
        .filter(|id: &i64| id.abs() < 1000)
        .ok_or_else(|| node.fail(format!("id=\"{id}\" is not a small whole number")))?;
    let cubics = |name: &str| -> Result<Vec<Cubic>, ReadError> {
        let all: Result<Vec<Cubic>, ReadError> =
            node.all(name).map(|c| Cubic::read(c, "sOffset")).collect();
        let mut all = all?;
        all.sort_by(|a, b| a.from.total_cmp(&b.from));
        Ok(all)
    };
    let links = |name: &str| -> Result<Vec<i64>, ReadError> {
        let all = node.child("link").into_iter().flat_map(|l| l.all(name));
        all.map(|l| Ok(l.needed_number("id")? as i64)).collect()
    };
    let limit = node
        .child("speed")
        .map(|s| speed(s, "max", "unit"))
        .transpose()?;
    let user_data = |code: &str| {
        let mut all = node.all("userData");
        all.find(|d| d.text("code") == Some(code))?.text("value")
    };
    let direction = node.text("direction");
    Ok(Lane {
        id,
        kind: node.text("type").unwrap_or_default().to_string(),
        is_reversed: direction == Some("reversed"),
        is_both_ways: direction == Some("both"),
        begins,
        widths: cubics("width")?,
        borders: cubics("border")?,
        predecessors: links("predecessor")?,
        successors: links("successor")?,
        mark: mark(node),
        limit: limit.flatten(),
        lanelet: user_data(LANELET).and_then(|id| id.parse().ok()),
        kept: KeptLanelet::read(user_data),
        part_of: user_data(PART_OF).and_then(|id| id.parse().ok()),
    })
}

impl Lane {
    /// How far its outer border is from the middle of the road at a place, where its inner one is as far as this, metres.
    pub fn reaches(&self, inner: f64, s: f64) -> f64 {
        let at = s - self.begins;
        match (&self.widths[..], &self.borders[..]) {
            ([], [_, ..]) => value(&self.borders, at).abs(),
            _ => inner + value(&self.widths, at).max(0.0),
        }
    }

    /// Places at which the shape of its borders changes, metres.
    pub fn changes(&self) -> impl Iterator<Item = f64> {
        let all = self.widths.iter().chain(&self.borders);
        all.map(|c| self.begins + c.from)
    }
}

//! The table of lanes: a row a lanelet, its borders as lines in WKT.

use std::fmt::Write;

use nearmiss_base::geometry::Point;
use nearmiss_record::{Cell, Column, Kind, Row, Table};
use nearmiss_scene::scenario::{Adjacent, Lanelet, RoadUser, Scenario};

use super::{integer, text};

/// The lanelets of a scenario. Borders are in metres, in the driving direction.
#[must_use]
pub fn lane_table(scenario: &Scenario) -> (Table, Vec<Row>) {
    let columns = vec![
        integer("lanelet", "id in the scenario"),
        text("types", "kinds of road that it is part of"),
        text(
            "users_one_way",
            "road users that may drive in its direction",
        ),
        text(
            "users_bidirectional",
            "road users that may drive either way",
        ),
        text("predecessors", "lanelets that end where it begins"),
        text("successors", "lanelets that begin where it ends"),
        integer("adjacent_left", "neighbour on the left").optional(),
        integer("adjacent_right", "neighbour on the right").optional(),
        line("left", "border on the left, WKT"),
        line("right", "border on the right, WKT"),
    ];
    let lanelets = scenario.network.lanelets.iter();
    (Table::new("lanes", columns), lanelets.map(row).collect())
}

const fn line(name: &'static str, source: &'static str) -> Column {
    Column::new(name, Kind::Text, "m", source)
}

fn row(lanelet: &Lanelet) -> Row {
    let ids = |all: &[i64]| joined(all.iter().map(i64::to_string));
    let users = |all: &[RoadUser]| joined(all.iter().map(|user| user.name().to_string()));
    let beside = |adjacent: &Option<Adjacent>| {
        adjacent
            .as_ref()
            .map_or(Cell::None(""), |found| Cell::Integer(found.id))
    };
    vec![
        Cell::Integer(lanelet.id),
        joined(lanelet.types.iter().map(|kind| kind.name().to_string())),
        users(&lanelet.users_one_way),
        users(&lanelet.users_bidirectional),
        ids(&lanelet.predecessors),
        ids(&lanelet.successors),
        beside(&lanelet.adjacent_left),
        beside(&lanelet.adjacent_right),
        wkt(&lanelet.left.points).into(),
        wkt(&lanelet.right.points).into(),
    ]
}

fn joined(words: impl Iterator<Item = String>) -> Cell {
    words.collect::<Vec<_>>().join(" ").into()
}

fn wkt(points: &[Point]) -> String {
    let mut text = String::from("LINESTRING (");
    for (place, point) in points.iter().enumerate() {
        let comma = if place > 0 { ", " } else { "" };
        // Writing to a string does not fail.
        let _ = write!(text, "{comma}{} {}", point.x + 0.0, point.y + 0.0);
    }
    text.push(')');
    text
}

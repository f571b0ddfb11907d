//! Writes scenarios as CommonRoad XML: elements, leaves, references, numbers, points.

use std::borrow::Cow;
use std::collections::BTreeMap;

use nearmiss_base::geometry::{Point, Shape};
use nearmiss_base::system;
use nearmiss_scene::scenario::{
    Adjacent, Bound, Goal, Intersection, Lanelet, LineMarking, Location, Obstacle, ObstacleRole,
    Position, Prediction, Quantity, Scenario, Sign, SignalState, State, StateField, Steps,
    TrafficLight,
};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};

use super::elements::{UNKNOWN_DEGREES, UNKNOWN_ID};
use super::obstacles;

/// Why a scenario was not written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write the scenario: {}", system::error_text(.0))]
pub struct WriteError(#[from] std::io::Error);

/// The scenario as an XML file of version 2020a, in UTF-8. The same scenario gives the same bytes.
///
/// # Errors
/// None in practice: writing goes to memory.
pub fn write(scenario: &Scenario) -> Result<Vec<u8>, WriteError> {
    written(scenario, &Version::V2020a)
}

/// What is written differently in the versions of the format.
pub(super) enum Version {
    V2020a,
    V2018b {
        /// Speed limits by lanelet, m/s; later versions have signs.
        limits: BTreeMap<i64, f64>,
    },
}

/// The scenario as an XML file of a version, which has a place for all that is in it.
pub(super) fn written(scenario: &Scenario, version: &Version) -> Result<Vec<u8>, WriteError> {
    let mut out = XmlWriter::begun()?;
    let header = &scenario.header;
    let name = match version {
        Version::V2020a => "2020a",
        Version::V2018b { .. } => "2018b",
    };
    let mut root = vec![
        ("commonRoadVersion", name.to_string()),
        ("benchmarkID", header.benchmark_id.clone()),
        ("timeStepSize", number(header.time_step_size)),
    ];
    root.extend(
        header
            .attributes
            .iter()
            .map(|(k, v)| (k.as_str(), v.clone())),
    );
    if matches!(version, Version::V2018b { .. }) {
        root.push(("tags", scenario.tags.join(" ")));
    }
    out.element("commonRoad", &root, |out| {
        if matches!(version, Version::V2020a) {
            about(out, scenario)?;
        }
        let network = &scenario.network;
        network
            .lanelets
            .iter()
            .try_for_each(|l| lanelet(out, l, version))?;
        network.signs.iter().try_for_each(|s| sign(out, s))?;
        network.lights.iter().try_for_each(|l| light(out, l))?;
        network
            .intersections
            .iter()
            .try_for_each(|i| intersection(out, i))?;
        for role in ObstacleRole::ALL {
            let of_role = scenario.obstacles.iter().filter(|o| o.role == role);
            of_role
                .into_iter()
                .try_for_each(|o| obstacle(out, o, version))?;
        }
        scenario.planning_problems.iter().try_for_each(|problem| {
            out.element("planningProblem", &id(problem.id), |out| {
                state(out, "initialState", &problem.initial)?;
                problem.goals.iter().try_for_each(|g| goal(out, g))
            })
        })
    })?;
    Ok(out.finished())
}

/// Where it is and what it is tagged with.
fn about(out: &mut XmlWriter, scenario: &Scenario) -> Result<(), WriteError> {
    if let Some(location) = &scenario.location {
        out.element("location", &[], |out| write_location(out, location))?;
    }
    out.element("scenarioTags", &[], |out| {
        scenario.tags.iter().try_for_each(|tag| out.empty(tag, &[]))
    })
}

fn lanelet(out: &mut XmlWriter, lanelet: &Lanelet, version: &Version) -> Result<(), WriteError> {
    out.element("lanelet", &id(lanelet.id), |out| {
        bound(out, "leftBound", &lanelet.left, version)?;
        bound(out, "rightBound", &lanelet.right, version)?;
        out.references("predecessor", &lanelet.predecessors)?;
        out.references("successor", &lanelet.successors)?;
        adjacent(out, "adjacentLeft", lanelet.adjacent_left)?;
        adjacent(out, "adjacentRight", lanelet.adjacent_right)?;
        if let Version::V2018b { limits } = version
            && let Some(limit) = limits.get(&lanelet.id)
        {
            out.leaf("speedLimit", &number(*limit))?;
        }
        if let Some(line) = &lanelet.stop_line {
            out.element("stopLine", &[], |out| {
                if let Some((from, to)) = &line.points {
                    point(out, from, None)?;
                    point(out, to, None)?;
                }
                out.leaf("lineMarking", line.marking.name())?;
                out.references("trafficSignRef", &line.signs)?;
                out.references("trafficLightRef", &line.lights)
            })?;
        }
        lanelet
            .types
            .iter()
            .try_for_each(|t| out.leaf("laneletType", t.name()))?;
        lanelet
            .users_one_way
            .iter()
            .try_for_each(|u| out.leaf("userOneWay", u.name()))?;
        let both = &lanelet.users_bidirectional;
        both.iter()
            .try_for_each(|u| out.leaf("userBidirectional", u.name()))?;
        out.references("trafficSignRef", &lanelet.signs)?;
        out.references("trafficLightRef", &lanelet.lights)
    })
}

fn bound(
    out: &mut XmlWriter,
    name: &str,
    bound: &Bound,
    version: &Version,
) -> Result<(), WriteError> {
    out.element(name, &[], |out| {
        for (i, at) in bound.points.iter().enumerate() {
            point(out, at, bound.heights.get(i).copied())?;
        }
        // Before 2020a there is no word for one that is not known.
        if bound.marking == LineMarking::Unknown && matches!(version, Version::V2018b { .. }) {
            return Ok(());
        }
        out.leaf("lineMarking", bound.marking.name())
    })
}

fn adjacent(out: &mut XmlWriter, name: &str, adjacent: Option<Adjacent>) -> Result<(), WriteError> {
    let Some(adjacent) = adjacent else {
        return Ok(());
    };
    let direction = if adjacent.same_direction {
        "same"
    } else {
        "opposite"
    };
    let attributes = [
        ("ref", adjacent.id.to_string()),
        ("drivingDir", direction.to_string()),
    ];
    out.empty(name, &attributes)
}

fn sign(out: &mut XmlWriter, sign: &Sign) -> Result<(), WriteError> {
    out.element("trafficSign", &id(sign.id), |out| {
        for element in &sign.elements {
            out.element("trafficSignElement", &[], |out| {
                out.leaf("trafficSignID", &element.id)?;
                element
                    .values
                    .iter()
                    .try_for_each(|v| out.leaf("additionalValue", v))
            })?;
        }
        place(out, sign.position.as_ref())?;
        out.leaf("virtual", if sign.is_virtual { "true" } else { "false" })
    })
}

fn place(out: &mut XmlWriter, position: Option<&Point>) -> Result<(), WriteError> {
    position.map_or(Ok(()), |at| {
        out.element("position", &[], |out| point(out, at, None))
    })
}

fn light(out: &mut XmlWriter, light: &TrafficLight) -> Result<(), WriteError> {
    out.element("trafficLight", &id(light.id), |out| {
        out.element("cycle", &[], |out| {
            for phase in &light.cycle {
                out.element("cycleElement", &[], |out| {
                    out.leaf("duration", &phase.duration.to_string())?;
                    out.leaf("color", phase.color.name())
                })?;
            }
            // The schema has positive offsets only, and none means 0.
            if light.offset == 0 {
                return Ok(());
            }
            out.leaf("timeOffset", &light.offset.to_string())
        })?;
        place(out, light.position.as_ref())?;
        if let Some(direction) = light.direction {
            out.leaf("direction", direction.name())?;
        }
        out.leaf("active", if light.active { "true" } else { "false" })
    })
}

fn intersection(out: &mut XmlWriter, intersection: &Intersection) -> Result<(), WriteError> {
    out.element("intersection", &id(intersection.id), |out| {
        for road in &intersection.incomings {
            out.element("incoming", &id(road.id), |out| {
                out.references("incomingLanelet", &road.lanelets)?;
                out.references("successorsRight", &road.right)?;
                out.references("successorsStraight", &road.straight)?;
                out.references("successorsLeft", &road.left)?;
                road.is_left_of
                    .map_or(Ok(()), |id| out.references("isLeftOf", &[id]))
            })?;
        }
        if intersection.crossings.is_empty() {
            return Ok(());
        }
        out.element("crossing", &[], |out| {
            out.references("crossingLanelet", &intersection.crossings)
        })
    })
}

fn obstacle(out: &mut XmlWriter, obstacle: &Obstacle, version: &Version) -> Result<(), WriteError> {
    let name = match version {
        Version::V2020a => format!("{}Obstacle", obstacle.role.name()),
        Version::V2018b { .. } => "obstacle".into(),
    };
    out.element(&name, &id(obstacle.id), |out| {
        if matches!(version, Version::V2018b { .. }) {
            out.leaf("role", obstacle.role.name())?;
        }
        if obstacle.role != ObstacleRole::Phantom {
            out.leaf("type", obstacle.kind.name())?;
        }
        if let Some(body) = &obstacle.footprint {
            out.element("shape", &[], |out| shape(out, body.shape()))?;
        }
        if let Some(initial) = &obstacle.initial {
            state(out, "initialState", initial)?;
        }
        // The first signal state belongs to the initial state where both are of the same time.
        let start = obstacle.initial.as_ref().map(|s| s.time);
        let first = obstacle
            .signals
            .iter()
            .take_while(|s| Some(s.time) == start)
            .take(1)
            .count();
        let (now, later) = obstacle.signals.split_at(first);
        now.iter()
            .try_for_each(|s| signals(out, "initialSignalState", s))?;
        prediction(out, &obstacle.prediction)?;
        if later.is_empty() {
            return Ok(());
        }
        out.element("signalSeries", &[], |out| {
            later
                .iter()
                .try_for_each(|s| signals(out, "signalState", s))
        })
    })
}

fn signals(out: &mut XmlWriter, name: &str, state: &SignalState) -> Result<(), WriteError> {
    out.element(name, &[], |out| {
        time(out, state.time)?;
        let mut all = state.signals.iter();
        all.try_for_each(|(signal, on)| out.leaf(signal.name(), if *on { "true" } else { "false" }))
    })
}

fn prediction(out: &mut XmlWriter, prediction: &Prediction) -> Result<(), WriteError> {
    match prediction {
        Prediction::None => Ok(()),
        Prediction::Trajectory(states) => out.element("trajectory", &[], |out| {
            states.iter().try_for_each(|s| state(out, "state", s))
        }),
        Prediction::Occupancies(occupancies) => out.element("occupancySet", &[], |out| {
            occupancies.iter().try_for_each(|occupancy| {
                out.element("occupancy", &[], |out| {
                    out.element("shape", &[], |out| shape(out, &occupancy.region))?;
                    time(out, occupancy.time)
                })
            })
        }),
    }
}

fn shape(out: &mut XmlWriter, what: &Shape) -> Result<(), WriteError> {
    match what {
        Shape::Rectangle {
            length,
            width,
            center,
            orientation,
            origin_x_shift,
        } => out.element("rectangle", &[], |out| {
            out.leaf("length", &number(*length))?;
            out.leaf("width", &number(*width))?;
            if *orientation != 0.0 {
                out.leaf("orientation", &number(*orientation))?;
            }
            centre(out, center)?;
            if *origin_x_shift == 0.0 {
                return Ok(());
            }
            out.leaf("originXShift", &number(*origin_x_shift))
        }),
        Shape::Truck(truck) => obstacles::write_truck(out, truck),
        Shape::SemiTrailerTruck {
            tractor, trailer, ..
        } => obstacles::write_semi_trailer_truck(out, tractor, trailer),
        Shape::Circle { radius, center } => out.element("circle", &[], |out| {
            out.leaf("radius", &number(*radius))?;
            centre(out, center)
        }),
        Shape::Polygon { vertices } => out.element("polygon", &[], |out| {
            vertices.iter().try_for_each(|v| point(out, v, None))
        }),
        Shape::Group(members) => members.iter().try_for_each(|m| shape(out, m)),
    }
}

fn centre(out: &mut XmlWriter, center: &Point) -> Result<(), WriteError> {
    if *center == Point::origin() {
        return Ok(());
    }
    out.element("center", &[], |out| {
        out.leaf("x", &number(center.x))?;
        out.leaf("y", &number(center.y))
    })
}

fn state(out: &mut XmlWriter, name: &str, state: &State) -> Result<(), WriteError> {
    out.element(name, &[], |out| {
        position(out, state.position.as_ref())?;
        quantity(out, StateField::Orientation, state.orientation)?;
        time(out, state.time)?;
        quantity(out, StateField::Velocity, state.velocity)?;
        quantity(out, StateField::Acceleration, state.acceleration)?;
        state
            .more
            .iter()
            .try_for_each(|(field, value)| quantity(out, *field, Some(*value)))
    })
}

fn goal(out: &mut XmlWriter, goal: &Goal) -> Result<(), WriteError> {
    out.element("goalState", &[], |out| {
        // An interval also where it is one step: the schema has nothing else for goals.
        out.element("time", &[], |out| interval(out, goal.time))?;
        goal.positions
            .iter()
            .try_for_each(|p| position(out, Some(p)))?;
        quantity(out, StateField::Orientation, goal.orientation)?;
        quantity(out, StateField::Velocity, goal.velocity)
    })
}

fn position(out: &mut XmlWriter, position: Option<&Position>) -> Result<(), WriteError> {
    let Some(position) = position else {
        return Ok(());
    };
    out.element("position", &[], |out| match position {
        Position::Point(at) => point(out, at, None),
        Position::Region(region) => shape(out, region),
        Position::Lanelets(ids) => out.references("lanelet", ids),
    })
}

fn time(out: &mut XmlWriter, steps: Steps) -> Result<(), WriteError> {
    out.element("time", &[], |out| {
        if steps.from == steps.to {
            return out.leaf("exact", &steps.from.to_string());
        }
        interval(out, steps)
    })
}

fn interval(out: &mut XmlWriter, steps: Steps) -> Result<(), WriteError> {
    out.leaf("intervalStart", &steps.from.to_string())?;
    out.leaf("intervalEnd", &steps.to.to_string())
}

fn quantity(
    out: &mut XmlWriter,
    field: StateField,
    value: Option<Quantity>,
) -> Result<(), WriteError> {
    match value {
        None => Ok(()),
        Some(Quantity::Exact(value)) => {
            out.element(field.name(), &[], |out| out.leaf("exact", &number(value)))
        }
        Some(Quantity::Interval(from, to)) => out.element(field.name(), &[], |out| {
            out.leaf("intervalStart", &number(from))?;
            out.leaf("intervalEnd", &number(to))
        }),
    }
}

pub(crate) type Attributes<'a> = [(&'a str, String)];

/// The XML being written.
pub(crate) struct XmlWriter {
    pub xml: Writer<Vec<u8>>,
}

impl XmlWriter {
    /// A document in UTF-8 that begins with its declaration.
    pub fn begun() -> Result<Self, WriteError> {
        let mut out = Self {
            xml: Writer::new_with_indent(Vec::new(), b' ', 2),
        };
        out.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        Ok(out)
    }

    /// The document.
    pub fn finished(self) -> Vec<u8> {
        let mut bytes = self.xml.into_inner();
        bytes.push(b'\n');
        bytes
    }

    /// A remark; it must not have `--` in it.
    pub fn comment(&mut self, text: &str) -> Result<(), WriteError> {
        self.event(Event::Comment(BytesText::new(text)))
    }

    pub fn event(&mut self, event: Event<'_>) -> Result<(), WriteError> {
        Ok(self.xml.write_event(event)?)
    }

    pub fn start<'a>(name: &'a str, attributes: &'a Attributes<'a>) -> BytesStart<'a> {
        let mut start = BytesStart::new(name);
        for (key, value) in attributes {
            start.push_attribute((*key, &*allowed(value)));
        }
        start
    }

    pub fn element(
        &mut self,
        name: &str,
        attributes: &Attributes<'_>,
        inside: impl FnOnce(&mut Self) -> Result<(), WriteError>,
    ) -> Result<(), WriteError> {
        self.event(Event::Start(Self::start(name, attributes)))?;
        inside(self)?;
        self.event(Event::End(BytesEnd::new(name)))
    }

    pub fn empty(&mut self, name: &str, attributes: &Attributes<'_>) -> Result<(), WriteError> {
        self.event(Event::Empty(Self::start(name, attributes)))
    }

    pub fn leaf(&mut self, name: &str, text: &str) -> Result<(), WriteError> {
        self.event(Event::Start(BytesStart::new(name)))?;
        self.event(Event::Text(BytesText::new(&allowed(text))))?;
        self.event(Event::End(BytesEnd::new(name)))
    }

    pub fn references(&mut self, name: &str, ids: &[i64]) -> Result<(), WriteError> {
        ids.iter()
            .try_for_each(|id| self.empty(name, &[("ref", id.to_string())]))
    }
}

/// Text with the characters that XML has no place for, not even escaped, replaced.
pub(crate) fn allowed(text: &str) -> Cow<'_, str> {
    let forbidden = |c: char| {
        (c < ' ' && !matches!(c, '\t' | '\n' | '\r')) || matches!(c, '\u{fffe}' | '\u{ffff}')
    };
    if text.contains(forbidden) {
        Cow::Owned(text.replace(forbidden, "\u{fffd}"))
    } else {
        Cow::Borrowed(text)
    }
}

/// The shortest text that reads back as the same number; plain decimals, as the schema wants them.
pub(crate) fn number(value: f64) -> String {
    let text = value.to_string();
    if text.contains('.') {
        text
    } else {
        format!("{text}.0")
    }
}

fn id(id: i64) -> [(&'static str, String); 1] {
    [("id", id.to_string())]
}

fn point(out: &mut XmlWriter, at: &Point, height: Option<f64>) -> Result<(), WriteError> {
    out.element("point", &[], |out| {
        out.leaf("x", &number(at.x))?;
        out.leaf("y", &number(at.y))?;
        height.map_or(Ok(()), |z| out.leaf("z", &number(z)))
    })
}

/// The children of a location.
fn write_location(out: &mut XmlWriter, location: &Location) -> Result<(), WriteError> {
    let id = location.geo_name_id.unwrap_or(UNKNOWN_ID);
    let degrees = |known: Option<f64>| number(known.unwrap_or(UNKNOWN_DEGREES));
    out.leaf("geoNameId", &id.to_string())?;
    out.leaf("gpsLatitude", &degrees(location.latitude))?;
    out.leaf("gpsLongitude", &degrees(location.longitude))?;
    if let Some(transformation) = &location.transformation {
        out.element("geoTransformation", &[], |out| {
            if let Some(reference) = &transformation.reference {
                out.leaf("geoReference", reference)?;
            }
            let parts = [
                ("xTranslation", transformation.x),
                ("yTranslation", transformation.y),
                ("zRotation", transformation.rotation),
                ("scaling", transformation.scaling),
            ];
            if parts.iter().all(|(_, value)| value.is_none()) {
                return Ok(());
            }
            out.element("additionalTransformation", &[], |out| {
                let mut said = parts
                    .iter()
                    .filter_map(|(name, value)| Some((name, (*value)?)));
                said.try_for_each(|(name, value)| out.leaf(name, &number(value)))
            })
        })?;
    }
    let Some(environment) = &location.environment else {
        return Ok(());
    };
    out.element("environment", &[], |out| {
        let words = [
            ("time", &environment.time),
            ("timeOfDay", &environment.time_of_day),
            ("weather", &environment.weather),
            ("underground", &environment.underground),
        ];
        let mut said = words
            .iter()
            .filter_map(|(name, word)| Some((name, word.as_ref()?)));
        said.try_for_each(|(name, word)| out.leaf(name, word))
    })
}

//! Entities of a scenario: what takes part, where it is when, and what of it is written beside.

use super::entities;
use super::varied::VariedVertex;
use nearmiss_base::geometry::{Point, Pose, Shape};
use nearmiss_scene::scenario::{
    Ego, Motion, Obstacle, ObstacleRole, ObstacleType, Prediction, Scenario, StateField,
};

/// An entity.
#[derive(Debug, Clone)]
pub struct Actor {
    /// Its name: the obstacle's id, or `ego`.
    pub name: String,
    /// What it is.
    pub kind: ObstacleType,
    /// Its body.
    pub body: Body,
    /// Unbroken stretches of its motion, by step; one that stands for ever has a single state.
    pub stretches: Vec<Vec<(i64, Motion)>>,
    /// Whether it stands at its place at all times.
    pub stands: bool,
    /// Whether nothing drives it.
    pub is_free: bool,
    /// Names and values.
    pub properties: Vec<(String, String)>,
    /// Where it is instead, where that follows from parameters.
    pub varied: Vec<VariedVertex>,
}

/// The property with velocities.
const VELOCITY: &str = "commonroad_velocity";

/// The property with accelerations.
const ACCELERATION: &str = "commonroad_acceleration";

impl Actor {
    /// It moves as parameters say, and has the speeds that follow.
    pub fn vary(&mut self, vertices: &[VariedVertex]) {
        self.varied = vertices.to_vec();
        let recorded = [VELOCITY, ACCELERATION];
        self.properties
            .retain(|(name, _)| !recorded.contains(&&**name));
    }
}

/// The box around a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Its centre, from the entity's position, metres.
    pub center: Point,
    /// Metres.
    pub length: f64,
    /// Metres.
    pub width: f64,
    /// Whether the body is that box.
    pub is_exact: bool,
}

/// A turn of a box by less than this is none, radians.
const HEADING_TOLERANCE: f64 = 1e-6;

impl Body {
    /// The box around a shape, in line with its object.
    pub fn from_shape(shape: &Shape) -> Self {
        let plain = shape.plain();
        let mut is_exact = matches!(&*plain, Shape::Rectangle { .. });
        if let Shape::Rectangle { orientation, .. } = &*plain {
            let quarter = (orientation / std::f64::consts::FRAC_PI_2).round();
            is_exact =
                (orientation - quarter * std::f64::consts::FRAC_PI_2).abs() < HEADING_TOLERANCE;
        }
        if let Shape::Circle { radius, center } = &*plain {
            return Self {
                center: *center,
                length: 2.0 * radius,
                width: 2.0 * radius,
                is_exact,
            };
        }
        let outlines = plain.outlines();
        let bounds = nearmiss_base::geometry::Bounds::from_points(outlines.iter().flatten());
        let Some(bounds) = bounds else {
            return Self {
                center: Point::origin(),
                length: 1.0,
                width: 1.0,
                is_exact: false,
            };
        };
        let (length, width) = shape.size();
        let center = nalgebra::center(&bounds.min, &bounds.max);
        // Rounding of a corner is no offset.
        let exact = |v: f64| if v.abs() < 1e-9 { 0.0 } else { v };
        Self {
            center: Point::new(exact(center.x), exact(center.y)),
            length,
            width,
            is_exact,
        }
    }
}

/// The ego as it is written.
#[derive(Debug, Clone, Copy)]
pub enum ExportedEgo<'a> {
    /// None.
    Missing,
    /// It follows this motion.
    Follows(&'a Ego),
    /// It begins like this one, and a driver under test drives it.
    Free(&'a Ego),
}

/// All entities: the ego first, then the obstacles that have a body and a place.
pub fn actors(scenario: &Scenario, ego: ExportedEgo<'_>, notes: &mut Notes) -> Vec<Actor> {
    let mut all = Vec::new();
    let mut taken = None;
    if let ExportedEgo::Follows(driven) | ExportedEgo::Free(driven) = ego {
        if let nearmiss_scene::scenario::EgoSource::Obstacle(id) = driven.source {
            taken = Some(id);
        }
        all.push(of_ego(
            driven,
            matches!(ego, ExportedEgo::Free(_)),
            scenario,
            notes,
        ));
    }
    for obstacle in &scenario.obstacles {
        if Some(obstacle.id) == taken {
            continue;
        }
        match of_obstacle(obstacle, notes) {
            Some(actor) => all.push(actor),
            None => notes.left_out(obstacle),
        }
    }
    all
}

fn of_ego(ego: &Ego, is_free: bool, scenario: &Scenario, notes: &mut Notes) -> Actor {
    let body = Body::from_shape(ego.footprint.shape());
    if !body.is_exact {
        notes.boxes.push("ego".into());
    }
    let taken = match ego.source {
        nearmiss_scene::scenario::EgoSource::Obstacle(id) => scenario.obstacle(id),
        _ => None,
    };
    let recorded = scenario.recorded_ego.as_ref().map(|own| &own.obstacle);
    let own = recorded.filter(|own| own.id == ego.id);
    let mut motion = stretches(ego.track.iter());
    if is_free {
        motion.truncate(1);
        motion.iter_mut().for_each(|m| m.truncate(1));
    }
    let mut properties = vec![("commonroad_ego".to_string(), ego.to_string())];
    let id = ego.id.to_string();
    properties.push(("commonroad_id".to_string(), id));
    let has_accelerations = match taken {
        Some(obstacle) => obstacle.states().any(|s| s.acceleration.is_some()),
        None => ego.recorded.is_empty() || ego.recorded.iter().any(|s| s.acceleration.is_some()),
    };
    properties.extend(speeds(&motion, has_accelerations));
    Actor {
        name: "ego".into(),
        kind: taken.or(own).map_or(ObstacleType::Car, |o| o.kind),
        body,
        stretches: motion,
        stands: false,
        is_free,
        properties,
        varied: Vec::new(),
    }
}

fn of_obstacle(obstacle: &Obstacle, notes: &mut Notes) -> Option<Actor> {
    let solid = matches!(obstacle.role, ObstacleRole::Static | ObstacleRole::Dynamic);
    if !solid {
        return None;
    }
    let shape = obstacle.footprint.as_ref()?.shape();
    let body = Body::from_shape(shape);
    let stands = obstacle.role == ObstacleRole::Static;
    let mut motion = stretches(obstacle.track().iter());
    if stands {
        motion.truncate(1);
        motion.iter_mut().for_each(|m| m.truncate(1));
    }
    motion.first()?.first()?;
    if !body.is_exact {
        notes.boxes.push(obstacle.id.to_string());
    }
    if !obstacle.signals.is_empty() {
        notes.signals += 1;
    }
    let bends = |s: &nearmiss_scene::scenario::State| s.quantity(StateField::HitchAngle).is_some();
    if obstacle.states().any(bends) {
        notes.trailers += 1;
    }
    if matches!(obstacle.prediction, Prediction::Occupancies(_)) {
        notes.regions += 1;
    }
    let mut properties = vec![
        (
            "commonroad_type".to_string(),
            obstacle.kind.name().to_string(),
        ),
        (
            "commonroad_role".to_string(),
            obstacle.role.name().to_string(),
        ),
        (
            "commonroad_shape".to_string(),
            shape_name(shape).to_string(),
        ),
    ];
    if !body.is_exact {
        let exact = entities::written(&shape.plain());
        properties.extend(exact.map(|words| (entities::BODY.to_string(), words)));
    }
    let has_accelerations = obstacle.states().any(|s| s.acceleration.is_some());
    properties.extend(speeds(&motion, has_accelerations));
    Some(Actor {
        name: obstacle.id.to_string(),
        kind: obstacle.kind,
        body,
        stretches: motion,
        stands,
        is_free: false,
        properties,
        varied: Vec::new(),
    })
}

fn shape_name(shape: &Shape) -> &'static str {
    match shape {
        Shape::Rectangle { .. } => "rectangle",
        Shape::Circle { .. } => "circle",
        Shape::Polygon { .. } => "polygon",
        Shape::Truck(_) => "truck",
        Shape::SemiTrailerTruck { .. } => "semiTrailerTruck",
        Shape::Group(_) => "group",
    }
}

/// The property with states before and after which the entity is away, which no trajectory has: step, x, y, heading of
/// each.
pub const SINGLE_STATES: &str = "commonroad_single_states";

fn single_states(stretches: &[Vec<(i64, Motion)>]) -> Option<(String, String)> {
    if stretches.len() < 2 {
        return None;
    }
    let single = stretches.iter().filter_map(|stretch| match &stretch[..] {
        [(step, motion)] => {
            let Pose { position, heading } = motion.pose;
            Some(format!("{step} {} {} {heading}", position.x, position.y))
        }
        _ => None,
    });
    let all: Vec<String> = single.collect();
    (!all.is_empty()).then(|| (SINGLE_STATES.to_string(), all.join(" ")))
}

/// Velocities and recorded accelerations, which trajectories have no place for. Others follow from the velocities.
fn speeds(stretches: &[Vec<(i64, Motion)>], has_accelerations: bool) -> Vec<(String, String)> {
    let list = |of: fn(&Motion) -> f64| {
        let all = stretches.iter().flatten().map(|(_, m)| of(m).to_string());
        all.collect::<Vec<_>>().join(" ")
    };
    let mut all = vec![(VELOCITY.to_string(), list(|m| m.velocity))];
    if has_accelerations {
        let accelerations = list(|m| m.acceleration);
        all.push((ACCELERATION.to_string(), accelerations));
    }
    all.extend(single_states(stretches));
    all
}

fn stretches<'a>(motion: impl Iterator<Item = (i64, &'a Motion)>) -> Vec<Vec<(i64, Motion)>> {
    let mut all: Vec<Vec<(i64, Motion)>> = Vec::new();
    for (step, motion) in motion {
        match all.last_mut() {
            Some(last) if last.last().is_some_and(|(s, _)| s + 1 == step) => {
                last.push((step, *motion));
            }
            _ => all.push(vec![(step, *motion)]),
        }
    }
    all
}

/// What the format cannot say, gathered.
#[derive(Debug, Default)]
pub struct Notes {
    /// Entities whose body is not the box around it.
    pub boxes: Vec<String>,
    /// Obstacles with signals.
    pub signals: usize,
    /// Obstacles whose trailer turns.
    pub trailers: usize,
    /// Obstacles whose future is told as regions.
    pub regions: usize,
    /// Whether it ends with the ego's recording, in contact.
    pub ended: bool,
    /// Obstacles that are not written.
    lost: Vec<String>,
}

impl Notes {
    fn left_out(&mut self, obstacle: &Obstacle) {
        let why = match obstacle.role {
            ObstacleRole::Phantom => "phantom",
            ObstacleRole::Environment => "environment",
            _ if obstacle.footprint.is_none() => "no shape",
            _ => "no position",
        };
        self.lost.push(format!("{} ({why})", obstacle.id));
    }

    /// The notes, a sentence each.
    pub fn sentences(&self) -> Vec<String> {
        let mut all = Vec::new();
        if !self.lost.is_empty() {
            all.push(format!("obstacles left out: {}", few(&self.lost)));
        }
        if !self.boxes.is_empty() {
            all.push(format!(
                "bodies that are no boxes, written as the boxes around them: {}",
                few(&self.boxes)
            ));
        }
        if self.signals > 0 {
            all.push(format!(
                "signals of {} obstacles (indicators, brake lights) left out",
                self.signals
            ));
        }
        if self.regions > 0 {
            all.push(format!(
                "occupancy sets of {} obstacles left out",
                self.regions
            ));
        }
        if self.ended {
            all.push("players stop at the ego's last step, which ends in contact; later motion of obstacles stays in their trajectories".into());
        }
        if self.trailers > 0 {
            all.push(format!(
                "{} trailers written as straight behind their trucks",
                self.trailers
            ));
        }
        all
    }
}

fn few(all: &[String]) -> String {
    const NAMED: usize = 12;
    let more = match all.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("{}{more}", all[..all.len().min(NAMED)].join(", "))
}

/// A pose a little ahead: players find a place on a trajectory by the distance travelled, so that two headings at one
/// place need places apart.
pub fn nudged(pose: &Pose, by: f64) -> Pose {
    Pose {
        position: pose.position + pose.forward() * by,
        heading: pose.heading,
    }
}

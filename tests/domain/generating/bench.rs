//! A bundled scenario with its baseline, a server that plays the model, and answers for it to give.

use std::sync::{Arc, Mutex, OnceLock};

use nearmiss::evaluation::generating::{Author, AuthorError, Authored, Method, Progress, write};
use nearmiss::evaluation::{Judge, ModelJudge, Settings, default_planning};
use nearmiss::formats::bundled;
use nearmiss::generation::{AttackContext, AttackSetup, ClosedLoop, Gate, admit};
use nearmiss::geometry::{Footprint, Point, Shape};
use nearmiss::llm::{Client, Endpoint, Parameters, Price, PriceEntry, Prices};
use nearmiss::metrics::Thresholds;
use nearmiss::planner::Cancel;
use nearmiss::prompts::Library;
use nearmiss::scenario::{
    Motion as State, Obstacle, ObstacleParts, ObstacleRole, ObstacleType, Position, Prediction,
    Quantity, Scenario, Scene, Steps,
};
use nearmiss::store::Store;
use nearmiss::verdict::{Manoeuvre, ManoeuvreKind, Motion};
use serde_json::{Value, json};

use super::support::server::{Recorded, Script, Server};

/// Who can attack in the scenario, by the reference: 301 is its first.
pub const ATTACKER: i64 = 301;

/// Another one who is there.
pub const OTHER: i64 = 304;

/// One who is parked.
pub const PARKED: i64 = 900;

const USAGE: &str =
    "data: {\"choices\":[],\"usage\":{\"prompt_tokens\":9000,\"completion_tokens\":100}}\n\n";

/// What an answer costs with the prices of the bench, US dollars.
pub const COST: f64 = 9000.0 * 2e-6 + 100.0 * 8e-6;

/// The ego's drive in the bundled cut-in, made once for all tests.
pub fn closed_loop() -> &'static ClosedLoop {
    static CLOSED: OnceLock<ClosedLoop> = OnceLock::new();
    CLOSED.get_or_init(|| {
        let all = bundled();
        let entry = all.iter().find(|e| e.name.contains("CutIn")).unwrap();
        let mut scenario = Scenario::clone(&entry.read().unwrap());
        scenario.obstacles.push(parked(scenario.dt()));
        // Few samples: this is about who writes attacks, and not about how well is driven.
        let mut settings = default_planning();
        let few = &mut settings.planner.sampling;
        (few.durations, few.speeds, few.offsets) = (2, 5, 5);
        (few.changes, few.refinements) = (1, 1);
        let problem = scenario.planning_problems[0].clone();
        ClosedLoop::watched(
            Arc::new(scenario),
            &problem,
            &settings,
            &Cancel::default(),
            &mut |_, _| true,
        )
        .unwrap()
    })
}

/// A parked car, far away from the road.
fn parked(dt: f64) -> Obstacle {
    let parts = ObstacleParts {
        id: PARKED,
        role: ObstacleRole::Static,
        kind: ObstacleType::ParkedVehicle,
        footprint: Some(Footprint::new(Shape::rectangle(4.5, 1.8)).unwrap()),
        initial: Some(nearmiss::scenario::State {
            position: Some(Position::Point(Point::new(0.0, 0.0))),
            orientation: Some(Quantity::Exact(0.0)),
            ..nearmiss::scenario::State::at(Steps::exact(0))
        }),
        prediction: Prediction::None,
        signals: Vec::new(),
    };
    Obstacle::new(parts, dt)
}

pub fn scenario() -> &'static Scenario {
    closed_loop().scenario()
}

/// The baseline as a scene.
pub fn scene() -> Arc<Scene> {
    let (closed, driver) = (closed_loop(), closed_loop().driver());
    let ego = closed.baseline().drive();
    let ego = ego.ego(driver.problem(), driver.settings());
    Arc::new(Scene::new(Arc::clone(closed.scenario()), ego))
}

/// Does something on the ground of the scene.
pub fn on_ground<T>(scene: &Scene, with: impl FnOnce(&AttackSetup<'_>) -> T) -> T {
    let ego = &scene.ego;
    let stage = AttackContext::new(&scene.scenario, &ego.footprint, &ego.track).unwrap();
    let gate = Gate::new(&scene.scenario).with_ego(ego);
    with(&AttackSetup {
        stage: &stage,
        gate: &gate,
        closed_loop: closed_loop(),
    })
}

/// An answer as a server streams it.
pub fn says(answer: &str) -> Script {
    let delta = json!({"model": "tiny", "choices": [{"index": 0, "delta": {"content": answer}}]});
    let end = json!({"choices": [{"index": 0, "delta": {}, "finish_reason": "stop"}]});
    Script::chunked_events()
        .chunk(format!("data: {delta}\n\n"))
        .chunk(format!("data: {end}\n\n"))
        .chunk(USAGE)
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
}

pub fn chooses(attacker: Value) -> Script {
    let answer = json!({
        "attacker": attacker,
        "obstacles": [{"id": ATTACKER, "risk_score": 3, "reason": "near"}],
        "justification": "It is the nearest.",
    });
    says(&answer.to_string())
}

/// An answer with waypoints for an obstacle.
pub fn through(obstacle: i64, waypoints: &Value) -> Script {
    let answer = json!({
        "obstacle": obstacle,
        "waypoints": waypoints,
        "manoeuvre": null,
        "justification": "It leaves no room.",
    });
    says(&answer.to_string())
}

/// An answer with a manoeuvre of the attacker.
pub fn does(manoeuvre: &Value) -> Script {
    let answer = json!({
        "obstacle": ATTACKER,
        "waypoints": null,
        "manoeuvre": manoeuvre,
        "justification": "It cuts in.",
    });
    says(&answer.to_string())
}

/// A cut-in that the ego does not get away from.
pub fn cut_in() -> Value {
    json!({"kind": "cut-in", "start": 7.5, "duration": 1.6, "gap": 1.0, "speed": null})
}

/// The recorded state of an obstacle.
pub fn recorded(obstacle: i64, step: i64) -> State {
    let obstacle = scenario().obstacle(obstacle).unwrap();
    *obstacle.track().at(step).unwrap()
}

/// Half a second apart, with so many decimals, and one more for headings.
pub fn waypoints(decimals: i32, states: impl Fn(i64) -> State) -> Value {
    let places = (45..=90).step_by(5).map(|step| {
        let state = states(step);
        let at = state.pose.position;
        let to = 10.0_f64.powi(decimals);
        let round = |x: f64, to: f64| (x * to).round() / to;
        json!({
            "step": step, "time": null, "x": round(at.x, to), "y": round(at.y, to),
            "heading": round(state.pose.heading, 10.0 * to), "velocity": round(state.velocity, to),
        })
    });
    places.collect()
}

/// The cut-in of [`cut_in`] as waypoints: what a model that knows its physics would write.
pub fn driven(decimals: i32) -> Value {
    let scene = scene();
    let manoeuvre = Motion::Manoeuvre(Manoeuvre {
        kind: ManoeuvreKind::CutIn,
        start: 7.5,
        duration: 1.6,
        gap: Some(1.0),
        speed: None,
    });
    let change = on_ground(&scene, |ground| admit(ground, ATTACKER, &manoeuvre));
    let motions = change.unwrap().attack.change.changes()[0].motions.clone();
    waypoints(decimals, |step| {
        let changed = motions.iter().find(|(s, _)| *s == step);
        changed.map_or_else(|| recorded(ATTACKER, step), |(_, motion)| *motion)
    })
}

/// The recorded motion with a jump of 10.7 m to the side in one step, as in the published example.
pub fn jumping() -> Value {
    let mut points = waypoints(2, |step| recorded(ATTACKER, step));
    let list = points.as_array_mut().unwrap();
    let mut second = list[0].clone();
    second["step"] = json!(46);
    second["y"] = json!(second["y"].as_f64().unwrap() + 10.7);
    list.insert(1, second);
    points
}

/// What a model wrote, and what it was asked.
pub struct Written {
    pub author: Author,
    pub outcome: Result<Authored, AuthorError>,
    pub requests: Vec<Recorded>,
    pub progress: Vec<Progress>,
}

impl Written {
    pub fn authored(&self) -> &Authored {
        self.outcome.as_ref().unwrap()
    }

    /// All refusals of an answer to the request for a motion, as they are said.
    pub fn words(&self, place: usize) -> String {
        let refusals = &self.authored().declined[place].refusals;
        assert!(!refusals.is_empty());
        let words: Vec<String> = refusals.iter().map(ToString::to_string).collect();
        words.join("\n")
    }

    /// Why the choice of the attacker was refused.
    pub fn choice_refused(&self) -> String {
        let proposal = self.authored().choice.proposal.as_ref().unwrap();
        proposal.refused.as_ref().unwrap().to_string()
    }
}

/// Runs an author against a server with these scripts; `with` changes how it is asked.
pub async fn written(scripts: Vec<Script>, with: impl FnOnce(&mut Author)) -> Written {
    let server = Server::start(scripts).await;
    let mut author = author(server.base_url());
    with(&mut author);
    let (outcome, progress) = ask(&author).await;
    Written {
        outcome,
        requests: server.requests(),
        progress,
        author,
    }
}

/// The same against a server that answers by what it is asked.
pub async fn written_by(
    answering: impl Fn(usize, &Recorded) -> Option<Script> + Send + Sync + 'static,
    with: impl FnOnce(&mut Author),
) -> Written {
    let server = Server::answering(answering).await;
    let mut author = author(server.base_url());
    with(&mut author);
    let (outcome, progress) = ask(&author).await;
    Written {
        outcome,
        requests: server.requests(),
        progress,
        author,
    }
}

/// Runs the same author again, whose server is gone by now.
pub async fn again(before: &Written) -> Written {
    let (outcome, progress) = ask(&before.author).await;
    Written {
        author: before.author.clone(),
        outcome,
        requests: Vec::new(),
        progress,
    }
}

async fn ask(author: &Author) -> (Result<Authored, AuthorError>, Vec<Progress>) {
    let progress = Mutex::new(Vec::new());
    let hear = |event: Progress| progress.lock().unwrap().push(event);
    let scene = scene();
    let stage =
        AttackContext::new(&scene.scenario, &scene.ego.footprint, &scene.ego.track).unwrap();
    let gate = Gate::new(&scene.scenario).with_ego(&scene.ego);
    let ground = AttackSetup {
        stage: &stage,
        gate: &gate,
        closed_loop: closed_loop(),
    };
    let writing = write(author, &ground, &scene, 0.5, &hear);
    let outcome = sendable(writing).await;
    if let Ok(authored) = &outcome {
        // Whatever its author: what comes out has passed.
        for attack in &authored.attacks {
            let change = &attack.admitted.attack.change.changes()[0];
            assert!(gate.check(change, None).is_ok());
            let first = &change.motions[0];
            let recorded = recorded(change.obstacle, first.0);
            assert_eq!(first.1.pose, recorded.pose);
        }
        assert!(authored.spent.requests <= author.method.requests(author.attacker));
    }
    (outcome, progress.into_inner().unwrap())
}

/// The workbench runs it on other threads.
fn sendable<T>(future: impl Future<Output = T> + Send) -> impl Future<Output = T> + Send {
    future
}

/// One vote, one conversation, no news of the drive, no grades.
fn as_before() -> Method {
    Method {
        votes: 1,
        samples: 1,
        feedback: false,
        grades: false,
        ..Method::default()
    }
}

pub fn author(url: &str) -> Author {
    let price = PriceEntry {
        model: "tiny*".into(),
        from: None,
        to: None,
        up_to: None,
        price: Price {
            input: 2.0,
            output: 8.0,
            cached: None,
            cache_write: None,
        },
        as_of: None,
        source: None,
    };
    let endpoint = Endpoint {
        key: Some("sk-test-generating".into()),
        prices: Prices {
            entries: vec![price],
            peak: None,
            batch_factor: None,
        },
        ..Endpoint::new("lab", url)
    };
    Author {
        name: "ZAM_CutIn-1_1_T-1".into(),
        judge: Judge::Model(Box::new(ModelJudge {
            id: "lab/tiny".into(),
            name: "tiny".into(),
            endpoint,
            client: Client::direct(),
            parameters: Parameters::default(),
        })),
        store: Some(Arc::new(Store::in_memory().unwrap())),
        library: Library::load(None),
        thresholds: Arc::new(Thresholds::shipped().clone()),
        settings: Settings::default(),
        frame: None,
        method: as_before(),
        at_once: 1,
        attacker: None,
        obey: false,
        fresh: false,
        batch: None,
    }
}

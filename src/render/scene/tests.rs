//! Scenes of bundled scenarios: who and what is seen, and as what.
#![allow(clippy::unwrap_used)]

use super::*;
use nearmiss_base::geometry::{Bounds, Pose};
use nearmiss_formats::{EgoSelection, bundled};
use nearmiss_scene::scenario::Scene;

fn scene(name: &str) -> Scene {
    let mut all = bundled().into_iter();
    let entry = all.find(|e| e.name.contains(name)).unwrap();
    let scenario = entry.read().unwrap();
    let ego = EgoSelection::Beside.resolve(&entry, &scenario).unwrap();
    Scene::new(scenario, ego.unwrap())
}

fn request<'a>(scene: &'a Scene, basemap: &'a Basemap, step: i64, half: f64) -> MapRequest<'a> {
    let ego = scene.ego.track.at(step).unwrap().pose;
    MapRequest {
        subject: Subject::with_ego(scene),
        basemap,
        step,
        viewport: Viewport::new(
            Pose {
                heading: 0.7,
                ..ego
            },
            (half, half),
        ),
        highlighted: &[301],
        series: None,
        variations: Variations::default(),
        trails: [TrailSpan::WHOLE; 2],
    }
}

#[test]
fn what_is_far_away_is_left_out() {
    let scene = scene("RedLight");
    let basemap = Basemap::new(&scene.scenario);
    let map = |half| MapScene::new(&request(&scene, &basemap, 30, half));
    let (near, all) = (map(15.0), map(10_000.0));
    assert_eq!(all.surfaces.len(), scene.scenario.network.lanelets.len());
    assert_eq!(all.borders.len(), basemap.borders.len());
    assert_eq!(all.lights.len(), scene.scenario.network.lights.len());
    let there = |o: &&nearmiss_scene::scenario::Obstacle| o.placed_at(30).is_some();
    let others = Subject::with_ego(&scene).others();
    assert_eq!(all.bodies.len(), others.filter(|o| there(o)).count());
    assert!(near.surfaces.len() < all.surfaces.len() && !near.surfaces.is_empty());
    assert!(near.bodies.len() < all.bodies.len() && near.ego.is_some());
}

#[test]
fn neighbours_share_their_border() {
    let scene = scene("RedLight");
    let basemap = Basemap::new(&scene.scenario);
    let crossing = SurfaceKind::Crossing;
    let driven = basemap.surfaces.iter().filter(|s| s.kind != crossing);
    assert!(basemap.borders.len() < 2 * driven.count());
    for surface in &basemap.surfaces {
        assert_eq!(Bounds::from_points(&surface.ring), Some(surface.bounds));
    }
}

#[test]
fn the_ego_and_those_pointed_out_are_named_first() {
    let scene = scene("RedLight");
    let basemap = Basemap::new(&scene.scenario);
    let map = MapScene::new(&request(&scene, &basemap, 30, 10_000.0));
    let owners = |most| -> Vec<Owner> { map.named(most).iter().map(|b| b.owner).collect() };
    assert_eq!(owners(0), [Owner::Ego, Owner::Obstacle(301)]);
    assert_eq!(owners(2)[..2], owners(0));
    assert_eq!(owners(2).len(), 4);
    let last = map.bodies.last().unwrap();
    assert_eq!(
        (last.owner, last.role),
        (Owner::Obstacle(301), Role::Highlighted(0))
    );
    let trail = map.trails.last().unwrap();
    assert_eq!(trail.owner, Owner::Ego);
    assert_eq!(trail.past.last(), trail.future.first());
}

#[test]
fn a_contact_lies_on_both_bodies() {
    let scene = scene("RedLight");
    let basemap = Basemap::new(&scene.scenario);
    let map = |step| MapScene::new(&request(&scene, &basemap, step, 50.0));
    let first = scene.steps().map(map).find(|map| !map.contacts.is_empty());
    let map = first.unwrap();
    let contact = &map.contacts[0];
    assert_eq!(contact.obstacle, 301);
    let other = map.bodies.iter().find(|b| b.owner == Owner::Obstacle(301));
    for body in [other.unwrap(), map.ego.as_ref().unwrap()] {
        let bounds = Bounds::from_points(body.rings.iter().flatten()).unwrap();
        assert!(bounds.squared_distance(&contact.at) < 0.01, "{contact:?}");
    }
}

#[test]
fn each_attacker_of_a_variant_has_a_role_of_its_own() {
    use super::super::view::Variation;
    let scene = scene("RedLight");
    let basemap = Basemap::new(&scene.scenario);
    let there = |o: &&nearmiss_scene::scenario::Obstacle| o.placed_at(30).is_some();
    let two: Vec<_> = Subject::with_ego(&scene)
        .others()
        .filter(there)
        .take(2)
        .collect();
    let varied = |obstacle| Variation {
        recorded: obstacle,
        changed: obstacle,
        from: 10,
        shows_changed: true,
    };
    let request = MapRequest {
        variations: two.iter().map(|obstacle| varied(*obstacle)).collect(),
        ..request(&scene, &basemap, 30, 10_000.0)
    };
    let map = MapScene::new(&request);
    for (place, obstacle) in two.iter().enumerate() {
        let owner = Owner::Obstacle(obstacle.id);
        assert_eq!(map.attacker_place(owner), Some(place));
        let body = map.bodies.iter().find(|body| body.owner == owner).unwrap();
        assert_eq!(body.role, Role::Attacker(place));
        let has_way = |overlay: &Overlay| matches!(overlay, Overlay::Path(path) if path.role == Role::Attacker(place));
        assert!(map.variation.iter().any(has_way), "{place}");
    }
}

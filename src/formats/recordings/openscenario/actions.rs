//! Actions of a storyboard: which move an entity, and how.

use crate::recordings::opendrive::tree::Node;

/// Actions that do not move an entity by themselves.
const HARMLESS: [&str; 4] = [
    "ControllerAction",
    "VisibilityAction",
    "ActivateControllerAction",
    "AppearanceAction",
];

/// Controllers, visibility, lights and the like do not move an entity by themselves.
pub fn is_harmless(action: &Node) -> bool {
    HARMLESS.iter().any(|name| action.has(name))
}

/// Whether an action makes a controller active, which may move the entity then.
pub fn activates(action: &Node) -> bool {
    const SWITCHES: [&str; 4] = [
        "lateral",
        "longitudinal",
        "activateLateral",
        "activateLongitudinal",
    ];
    let all =
        ["ActivateControllerAction", "AssignControllerAction"].map(|name| action.within(name));
    let mut any = false;
    for node in all.into_iter().flatten() {
        for switch in SWITCHES {
            any |= node.text(switch) == Some("true");
        }
    }
    let overrides = action.within("OverrideControllerValueAction");
    let active = |o: &&Node| o.children().any(|v| v.text("active") == Some("true"));
    any || overrides.iter().any(active)
}

/// How an action moves an entity, in words.
pub fn moves_by(action: &Node) -> String {
    let mut node = action;
    while let Some(child) = node.children().next() {
        node = child;
        if node.name != "RoutingAction"
            && node.name != "LongitudinalAction"
            && node.name != "LateralAction"
        {
            break;
        }
    }
    format!("moves by <{}>", node.name)
}

//! Contacts of the published recordings: with the ways between two steps they are those at the steps, also in
//! BEL_Antwerp-30_1_T-1, where the bodies graze by millimetres between two.

use nearmiss::judge::judge;
use nearmiss::metrics::{Contact, Context};
use nearmiss::scenario::Window;
use nearmiss::verdict::Task;

use super::scenes::{none, recorded};

#[test]
fn published_contacts_are_those_at_the_steps() {
    let Some(scenes) = recorded(1) else { return };
    let mut found = Vec::new();
    let mut count = 0;
    for (name, scene) in scenes {
        let context = Context::new(&scene);
        for (place, other) in scene.participants().enumerate() {
            let at_steps = scene.steps().find(|step| {
                let encounter = context.encounter(place, *step);
                encounter.is_some_and(|encounter| encounter.distance() == 0.0)
            });
            let first = Contact::first(&scene, &other);
            count += usize::from(first.is_some());
            if first.map(|contact| contact.step) != at_steps
                || first != context.contacts(place).first().copied()
            {
                found.push(format!("{name}: at step {at_steps:?}, {first:?}"));
            }
        }
        if name.contains("BEL_Antwerp-30_1_T-1") {
            let verdict = judge(&scene, Task::Collision, &Window::full(&scene)).verdict;
            let said = &verdict.justification;
            assert!(said.ends_with("uncertain there: no contact."), "{said}");
        }
    }
    println!("{count} contacts");
    none(&found);
}

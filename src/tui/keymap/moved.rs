//! Keys of the version before that do something else now: pressing one says where its action went.
//!
//! The table is for one version. A key that a keymap file binds has a meaning and never gets here.

use super::{Key, Keymap};
use crate::action::{ACTIONS, Action};

/// The old key of an action, where no pane has it now.
const MOVED: &[(&str, Action)] = &[
    ("%", Action::Results),
    ("!", Action::Generate),
    ("@", Action::GenerateWith),
    ("&", Action::ModelAttacks),
    ("#", Action::EditTags),
    (";", Action::Loop),
    ("backspace", Action::RecordedEgo),
    ("a", Action::FitMap),
    ("b", Action::Mark),
    ("d", Action::CloseAnswer),
    ("f", Action::ToggleFrame),
    ("i", Action::About),
    ("o", Action::SavePicture),
    ("s", Action::SortScenarios),
    ("t", Action::ToggleTask),
    ("u", Action::EgoUp),
    ("v", Action::PromptView),
    ("w", Action::Follow),
    ("shift-a", Action::AskMarked),
    ("shift-b", Action::BlindMode),
    ("shift-c", Action::CompareScreen),
    ("shift-d", Action::NextDisagreement),
    ("shift-e", Action::TakeAsEgo),
    ("shift-f", Action::NextForecast),
    ("shift-h", Action::HeatStrips),
    ("shift-i", Action::Details),
    ("shift-j", Action::TaskList),
    ("shift-k", Action::VariantPanel),
    ("shift-l", Action::Layers),
    ("shift-m", Action::MinimumStep),
    ("shift-o", Action::PlotDrives),
    ("shift-p", Action::NextPaths),
    ("shift-s", Action::GroupScenarios),
    ("shift-t", Action::TakeTape),
    ("shift-u", Action::SwitchVariant),
    ("shift-v", Action::Values),
    ("shift-w", Action::DrivePlanner),
    ("shift-x", Action::Source),
    ("shift-y", Action::PlannerCycle),
];

impl Keymap {
    /// Where the action of an old key went, such as `results moved: Space o r`.
    #[must_use]
    pub fn moved(&self, key: Key) -> Option<String> {
        let name = key.name();
        let (_, action) = MOVED.iter().find(|(old, _)| *old == name)?;
        let entry = ACTIONS.iter().find(|entry| entry.action == *action)?;
        Some(format!("{} moved: {}", entry.id, self.key_of(*action)))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::action::Scope;
    use crate::keymap::{KeyMeaning, Preset};

    #[test]
    fn old_keys_are_free_on_the_main_screen_and_say_where_they_went() {
        let map = Keymap::from_preset(Preset::Default);
        for (old, action) in MOVED {
            let key = Key::parse(old).unwrap();
            assert_eq!(key.name(), *old);
            for scope in [Scope::Scenarios, Scope::Map, Scope::Text, Scope::Plot] {
                assert_eq!(map.meaning(&[key], scope), KeyMeaning::Nothing, "{old}");
            }
            let said = map.moved(key).unwrap();
            assert!(said.ends_with(&map.key_of(*action)), "{said}");
        }
        let percent = Key::parse("%").unwrap();
        assert_eq!(
            map.moved(percent).as_deref(),
            Some("results moved: Space o r")
        );
        assert_eq!(map.moved(Key::parse("shift-z").unwrap()), None);
    }
}

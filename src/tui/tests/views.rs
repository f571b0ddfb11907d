//! Saved views of the list: saved, chosen and deleted; what an older version does not know.

use super::bench::Bench;
use super::editing::said;
use crate::features::scenarios::saved_views::ListViews;
use crate::message::Msg;
use crate::model::{Grouping, Order};
use nearmiss_settings::{Folders, SavedView, SavedViews};

/// Does on the disk what was asked for, in a folder of its own.
fn kept(bench: &mut Bench, folders: &Folders) {
    for effect in std::mem::take(&mut bench.effects) {
        let path = folders.views();
        let views = match effect.into_request() {
            Ok(ListViews::Read) => SavedViews::read(&path),
            Ok(ListViews::Change(name, view)) => SavedViews::change(&path, &name, view),
            Err(_) => continue,
        };
        bench.send(Msg::reply::<ListViews>(views));
    }
}

#[test]
fn a_view_is_saved_chosen_again_and_deleted() {
    let folder = tempfile::tempdir().unwrap();
    let folders = Folders {
        config: folder.path().join("config"),
        data: folder.path().join("data"),
    };
    let mut bench = Bench::bundled();
    bench.model.list.sort_by(Order::Name);
    bench.model.list.sort_by(Order::Name);
    bench.model.list.group_by(Grouping::Country);
    bench.model.list.set_filter("mer".into());
    let shown = bench.model.list.lines.clone();
    bench.perform("saved-views");
    kept(&mut bench, &folders);
    let frame = bench.frame(80, 24);
    let now = "type a name to save the list as it is: mer · sorted by name reversed · by country";
    assert!(frame.contains(&now[..60]), "{frame}");
    bench.type_text("merging, by name");
    assert!(bench.frame(80, 24).contains("save as `merging, by name`"));
    bench.press("enter");
    kept(&mut bench, &folders);

    let mut later = Bench::bundled();
    assert_ne!(later.model.list.lines, shown);
    later.perform("saved-views");
    kept(&mut later, &folders);
    insta::assert_snapshot!("saved_views_at_80_by_24", later.frame(80, 24));
    later.press("enter");
    assert_eq!(later.model.list.view(), bench.model.list.view());
    assert_eq!(later.model.list.lines, shown);
    assert!(later.model.screens.is_empty());

    later.perform("saved-views");
    later.press("ctrl-d");
    kept(&mut later, &folders);
    let there = |bench: &Bench| bench.model.list.views.iter().count();
    assert_eq!(there(&later), 1, "one press deletes nothing");
    assert!(later.frame(80, 24).contains("Ctrl-D again deletes"));
    later.press("ctrl-d");
    kept(&mut later, &folders);
    assert_eq!(there(&later), 0);
}

#[test]
fn what_is_not_known_of_a_view_is_named_and_the_rest_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("views.toml");
    let view = SavedView::new("mer", "sparkle", true, "mood");
    let views = SavedViews::change(&path, "newer", Some(view)).unwrap();
    let mut bench = Bench::bundled();
    bench.send(Msg::reply::<ListViews>(Ok(views)));
    bench.perform("saved-views");
    bench.press("enter");
    assert!(said(&bench).contains("the order `sparkle` and the grouping `mood`"));
    assert_eq!(bench.model.list.filter, "mer");
    assert_eq!(bench.model.list.order, Order::Found);
    bench.send(Msg::reply::<ListViews>(Err(
        "views.toml: line 2: broken".into()
    )));
    assert!(said(&bench).contains("line 2"));
    assert_eq!(bench.model.list.views.iter().count(), 1);
}

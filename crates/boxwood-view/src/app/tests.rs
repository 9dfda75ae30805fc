//! The viewer without a window, by its keys and files.

use std::{fs, path::Path};

use boxwood::STRUCTURES;

use super::*;
use crate::{
    Aim, Button, Matter,
    keys::{Action, BINDINGS, Binding},
};

const SIZE: [u32; 2] = [160, 90];

fn options(file: &str, folder: &Path) -> Options {
    Options {
        file: file.to_owned(),
        open: Arc::new(crate::open),
        structure: Structure::named("bvh2").unwrap(),
        build: BuildOptions::default(),
        aim: Aim::default(),
        look: SUN.to_owned(),
        log: false,
        size: SIZE,
        remembered: State::default(),
        folder: folder.to_owned(),
        camera_flags: |camera| format!("--fov {}", camera.fov),
        wake: Arc::new(|| {}),
        stop: || false,
    }
}

/// A viewer of a small bush, with all there is to see.
fn viewer(folder: &Path) -> App {
    let mut app = App::new(options("builtin:bush?n=3000", folder));
    settle(&mut app);
    assert!(app.subject.is_some(), "{:?}", app.message());
    app
}

/// Until nothing changes by itself.
fn settle(app: &mut App) {
    let start = Instant::now();
    loop {
        app.advance(Duration::from_millis(5));
        app.draw();
        if app.is_settled() {
            return;
        }
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "{app:?} does not settle"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn press(app: &mut App, key: Key) -> Image {
    app.handle(Event::Press(key));
    app.handle(Event::Release(key));
    settle(app);
    app.draw().clone()
}

#[test]
fn a_scene_is_opened_at_once_and_gets_finer() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = App::new(options("builtin:bush?n=3000", folder.path()));
    let before = app.draw().clone();
    assert_eq!([before.width, before.height], SIZE);
    settle(&mut app);
    assert!(app.first_picture().is_some());
    assert_eq!(app.painted.as_ref().map(|painted| painted.samples), Some(4));
    assert!(app.counted.is_some_and(|(counts, _)| counts.boxes > 0));
    assert_ne!(*app.draw(), before);
    assert!(
        app.title().starts_with("builtin:bush?n=3000 - bvh2"),
        "{}",
        app.title()
    );
}

/// One test for all of them, so that a new key cannot be forgotten: the match is over all actions.
#[test]
fn every_key_does_what_the_cheat_sheet_says() {
    for binding in BINDINGS {
        for place in 0..binding.keys.len() {
            check_key(binding, place);
        }
    }
}

fn check_key(binding: &Binding, place: usize) {
    let folder = tempfile::tempdir().unwrap();
    let mut app = viewer(folder.path());
    app.handle(Event::Pointer([80.0, 50.0]));
    let key = binding.keys[place];
    let before = (app.draw().clone(), app.camera, app.shown);
    let prepare = match binding.action {
        Action::Step => Some(Key::Char('p')),
        Action::Logarithm => Some(Key::F(11)),
        _ => None,
    };
    let before_key = prepare.map_or(before.0.clone(), |key| press(&mut app, key));
    if (binding.action, place) == (Action::Step, 0) {
        app.picked.as_mut().unwrap().step(5);
    }
    let steps = app.picked.as_ref().map(Picked::place);
    let image = press(&mut app, key);
    let picture_changed = image != before_key;
    let wishes = app.wishes();
    match binding.action {
        Action::Look(looks) => {
            // The look that is shown already goes on to the next of its key.
            let expected = looks[usize::from(looks[0] == SUN)];
            assert_eq!(app.look, expected);
            assert!(picture_changed, "{key:?}");
            for step in 1..=looks.len() {
                app.handle(Event::Press(key));
                let first = usize::from(looks[0] == SUN);
                assert_eq!(app.look, looks[(first + step) % looks.len()]);
            }
        }
        Action::Benchmark => assert!(app.message().unwrap().starts_with("16 frames of 160 x 90")),
        Action::Brightness => {
            assert_eq!(app.look, "heat-tests");
            let top = app.scale.top.unwrap();
            press(&mut app, key);
            assert_eq!(app.scale.top, Some(top * [2.0, 0.5][place]));
        }
        Action::Logarithm => assert!(app.scale.log && picture_changed),
        Action::Fly | Action::Turn => check_motion(&mut app, key, binding.action, place),
        Action::Structure => {
            let shown = app.built.last().unwrap().structure;
            assert_eq!(shown, STRUCTURES.get(place).map_or("bvh2", |s| s.name));
        }
        Action::Split => {
            assert!(app.look.starts_with("heat") && app.painted.unwrap().scales.len() == 2);
        }
        Action::Boxes => assert!(app.shown.boxes && picture_changed),
        Action::Depth => assert!(app.shown.boxes && app.shown.depth == [2, 4][place]),
        Action::Pick => {
            assert!(app.picked.is_some() && picture_changed);
            press(&mut app, key);
            assert!(app.picked.is_none());
        }
        Action::Step => {
            let words = steps.unwrap();
            let number = |words: &str| words.split(' ').nth(1).unwrap().parse::<i32>().unwrap();
            let now = app.picked.as_ref().unwrap().place();
            assert_eq!(number(&now) - number(&words), [-1, 1][place]);
            assert!(picture_changed);
        }
        Action::Camera => assert_eq!(wishes, [Wish::Print(format!("--fov {}", app.camera.fov))]),
        Action::Screenshot => {
            let path = folder.path().join("boxwood-view-1.png");
            assert!(fs::read(path).unwrap().starts_with(b"\x89PNG"));
        }
        Action::Reset => {
            app.handle(Event::Wheel(3.0));
            assert_ne!(app.camera, before.1);
            press(&mut app, key);
            assert_eq!(app.camera, before.1);
        }
        Action::Numbers => assert!(app.shown.numbers != before.2.numbers && picture_changed),
        Action::Graph => assert!(app.shown.graph && picture_changed),
        Action::Help => assert!(app.shown.help == 1 && picture_changed),
        Action::FullScreen => assert_eq!(wishes, [Wish::ToggleFullScreen]),
        Action::Quit => assert_eq!(wishes, [Wish::Quit]),
    }
}

/// Held keys move; the way is that of the sheet.
fn check_motion(app: &mut App, key: Key, action: Action, place: usize) {
    let before = crate::navigate::Frame::of(&app.camera);
    app.handle(Event::Press(key));
    app.advance(Duration::from_millis(100));
    app.handle(Event::Release(key));
    let after = crate::navigate::Frame::of(&app.camera);
    let moved = after.eye - before.eye;
    let turned = after.ahead - before.ahead;
    let up = before.right.cross(before.ahead);
    let way = match (action, place) {
        (Action::Fly, 0) => moved.dot(before.ahead),
        (Action::Fly, 1) => -moved.dot(before.right),
        (Action::Fly, 2) => -moved.dot(before.ahead),
        (Action::Fly, _) => moved.dot(before.right),
        (_, 0) => -turned.dot(before.right),
        (_, 1) => turned.dot(before.right),
        (_, 2) => turned.dot(up),
        _ => -turned.dot(up),
    };
    assert!(way > 1e-3, "{key:?} moves {way}");
    let there = app.camera;
    app.advance(Duration::from_millis(100));
    assert_eq!(app.camera, there, "{key:?} is no longer held");
}

#[test]
fn dragging_moves_the_camera_and_a_free_pointer_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = viewer(folder.path());
    let start = app.camera;
    app.handle(Event::Pointer([30.0, 30.0]));
    assert_eq!(app.camera, start);
    for (button, shift, keeps_target) in [
        (Button::Left, false, true),
        (Button::Left, true, false),
        (Button::Other, false, false),
    ] {
        let before = app.camera;
        app.handle(Event::Shift(shift));
        app.handle(Event::ButtonDown(button));
        let [x, y] = app.hands.pointer;
        app.handle(Event::Pointer([x + 10.0, y + 5.0]));
        app.handle(Event::ButtonsUp);
        assert_ne!(app.camera, before);
        assert_eq!(
            app.camera.target == before.target,
            keeps_target,
            "{button:?} {shift}"
        );
    }
    let near = app.camera;
    app.handle(Event::Wheel(1.0));
    let distance = |camera: &Camera| glam::Vec3::from(camera.eye).distance(camera.target.into());
    assert!(distance(&app.camera) < distance(&near));
}

#[test]
fn a_broken_file_leaves_a_message_and_the_old_scene() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.obj");
    fs::write(&broken, "v 0 0 0\nf 1 2 9\n").unwrap();
    let mut app = viewer(folder.path());
    let name = app.subject.as_ref().unwrap().name.clone();
    app.handle(Event::Drop(broken.clone()));
    settle(&mut app);
    assert!(
        app.message().unwrap().contains("broken.obj:2"),
        "{:?}",
        app.message()
    );
    assert_eq!(app.subject.as_ref().unwrap().name, name);
    assert!(matches!(&app.wishes()[..], [Wish::Warn(_)]));
    press(&mut app, Key::Char('i'));
    assert_eq!(app.message(), None);
}

#[test]
fn a_dropped_file_is_shown_and_read_again_when_it_changes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.obj");
    let triangle = "v 0 0 0\nv 2 0 0\nv 0 3 0.5\nf 1 2 3\n";
    fs::write(&path, triangle).unwrap();
    let mut app = viewer(folder.path());
    app.handle(Event::Drop(path.clone()));
    settle(&mut app);
    assert_eq!(app.built.last().unwrap().scene.len(), 1);
    app.handle(Event::Wheel(2.0));
    settle(&mut app);
    let camera = app.camera;
    fs::write(&path, format!("{triangle}v 5 5 5\nf 1 2 4\n")).unwrap();
    for _ in 0..3 {
        app.advance(watch::INTERVAL);
    }
    settle(&mut app);
    assert_eq!(app.built.last().unwrap().scene.len(), 2);
    assert_eq!(app.camera, camera);
}

#[test]
fn a_window_can_be_resized_down_to_nothing_and_up_to_4k() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = viewer(folder.path());
    for size in [[0, 0], [1, 1], [7, 3], [3840, 2160], [200, 120]] {
        app.handle(Event::Resize(size));
        app.advance(Duration::from_millis(5));
        let frame = app.draw();
        assert_eq!([frame.width, frame.height], size.map(|side| side.max(1)));
        assert_eq!(frame.rgb.len(), (frame.width * frame.height) as usize);
    }
    settle(&mut app);
    assert_eq!(app.painted.unwrap().image.width, 200);
}

#[test]
fn every_structure_shows_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = viewer(folder.path());
    app.shown.numbers = false;
    let first = press(&mut app, Key::Char('1'));
    for number in 2..=STRUCTURES.len() {
        let key = char::from_digit(number as u32, 10).unwrap();
        assert!(
            press(&mut app, Key::Char(key)) == first,
            "structure {number}"
        );
    }
}

#[test]
fn a_scene_that_cannot_be_read_leaves_an_empty_window_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = App::new(options("no/such/file.obj", folder.path()));
    settle(&mut app);
    assert!(app.message().unwrap().contains("no/such/file.obj"));
    for binding in BINDINGS {
        for &key in binding.keys {
            app.handle(Event::Press(key));
            app.handle(Event::Release(key));
        }
    }
    settle(&mut app);
    assert_eq!(app.state().file, None);
}

#[test]
fn what_was_remembered_stays_where_nothing_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let remembered = State {
        file: Some("bunny.obj".to_owned()),
        structure: Some("grid".to_owned()),
        vp: Some([1.0, 2.0, 3.0]),
        vi: Some([0.0; 3]),
        vu: Some([0.0, 0.0, 1.0]),
        fov: Some(20.0),
        size: Some(SIZE),
        look: Some(SUN.to_owned()),
        ..State::default()
    };
    for name in ["bunny.obj", "another.obj"] {
        let mut app = App::new(Options {
            remembered: remembered.clone(),
            ..options(name, folder.path())
        });
        assert_eq!(app.state(), remembered, "before it is read");
        settle(&mut app);
        press(&mut app, Key::Char('q'));
        assert_eq!(app.state(), remembered);
    }
}

#[test]
fn a_scene_that_is_broken_or_missing_is_shown_once_it_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    for broken in [None, Some("v 0 0 0\nf 1 2 9\n")] {
        let path = folder.path().join("mesh.obj");
        let _ = fs::remove_file(&path);
        if let Some(text) = broken {
            fs::write(&path, text).unwrap();
        }
        let aim = Aim {
            fov: Some(21.0),
            ..Aim::default()
        };
        let mut app = App::new(Options {
            aim,
            ..options(path.to_str().unwrap(), folder.path())
        });
        settle(&mut app);
        let failure = app.failure().unwrap();
        assert_eq!(failure.kind, Matter::Scene, "{failure}");
        fs::write(&path, "v 0 0 0\nv 2 0 0\nv 0 3 0.5\nf 1 2 3\n").unwrap();
        for _ in 0..3 {
            app.advance(watch::INTERVAL);
        }
        settle(&mut app);
        assert_eq!(app.built.last().unwrap().scene.len(), 1);
        assert_eq!((app.failure(), app.message()), (None, None));
        assert_eq!(app.camera.fov, 21.0, "the first aim still holds");
    }
}

#[test]
fn beside_a_broken_file_the_scene_that_is_shown_is_still_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh, broken] = ["mesh.obj", "broken.obj"].map(|name| folder.path().join(name));
    let triangle = "v 0 0 0\nv 2 0 0\nv 0 3 0.5\nf 1 2 3\n";
    fs::write(&mesh, triangle).unwrap();
    fs::write(&broken, "f 1 2 9\n").unwrap();
    let mut app = App::new(options(mesh.to_str().unwrap(), folder.path()));
    settle(&mut app);
    app.handle(Event::Drop(broken.clone()));
    settle(&mut app);
    assert!(app.failure().is_some());
    fs::write(&mesh, format!("{triangle}v 5 5 5\nf 1 2 4\n")).unwrap();
    for _ in 0..3 {
        app.advance(watch::INTERVAL);
    }
    settle(&mut app);
    assert_eq!(app.built.last().unwrap().scene.len(), 2);
}

#[test]
fn a_camera_that_shows_nothing_is_the_matter_of_who_aimed_it() {
    let folder = tempfile::tempdir().unwrap();
    let point = Some([1.0, 2.0, 3.0]);
    let both = Aim {
        eye: point,
        target: point,
        ..Aim::default()
    };
    let number = Aim {
        number: Some(99),
        ..Aim::default()
    };
    for (aim, remedy) in [(both, "--vi"), (number, "counted from 0")] {
        let mut app = App::new(Options {
            aim,
            ..options("builtin:cornell", folder.path())
        });
        settle(&mut app);
        let failure = app.failure().unwrap();
        assert_eq!(failure.kind, Matter::Camera, "{failure}");
        assert!(failure.remedy.as_ref().unwrap().contains(remedy));
    }
}

#[test]
fn a_viewer_that_is_to_stop_wishes_to_quit() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = App::new(Options {
        stop: || true,
        ..options("builtin:cornell", folder.path())
    });
    app.advance(Duration::ZERO);
    assert_eq!(app.wishes(), [Wish::Quit]);
}

#[test]
fn a_window_larger_than_memory_shows_its_upper_part() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = App::new(Options {
        size: [65_535, 65_535],
        ..options("no/such/file.obj", folder.path())
    });
    assert_eq!(app.state().size, Some([65_535, 1024]));
    app.handle(Event::Resize([u32::MAX, u32::MAX]));
    assert_eq!(app.state().size, Some([65_535, 1024]));
    assert_eq!(app.draw().rgb.len(), 65_535 * 1024);
}

#[test]
fn a_state_brings_back_what_was_seen() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = viewer(folder.path());
    app.handle(Event::Wheel(4.0));
    press(&mut app, Key::F(5));
    let (state, image) = (app.state(), app.draw().clone());
    let mut again = App::new(Options {
        aim: state.aim(),
        look: state.look.clone().unwrap(),
        ..options(state.file.as_deref().unwrap(), folder.path())
    });
    settle(&mut again);
    assert_eq!(again.state(), state);
    app.shown.numbers = false;
    again.shown.numbers = false;
    assert_ne!(image.rgb, app.draw().rgb);
    assert!(app.draw().rgb == again.draw().rgb);
}

#[test]
fn a_slow_structure_never_keeps_the_window_waiting_for_long() {
    let folder = tempfile::tempdir().unwrap();
    let file = "builtin:bush?n=3000";
    let mut app = App::new(Options {
        structure: Structure::named("list").unwrap(),
        size: [1280, 720],
        ..options(file, folder.path())
    });
    while app.first_picture().is_none() {
        app.advance(Duration::from_millis(5));
        app.draw();
    }
    for _ in 0..12 {
        app.handle(Event::Wheel(0.1));
        app.advance(Duration::from_millis(5));
        app.draw();
    }
    // No assertion on time, which a busy machine would break: a full frame would be 64 times as many rays.
    assert!(app.share() < 0.2, "{}", app.share());
}

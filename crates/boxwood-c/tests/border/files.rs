//! Scenes in files.

use crate::handle::{Handle, bits, last, plate, rays, soup};
use boxwood::Transform;
use boxwood_c::*;
use std::ffi::CString;
use std::path::Path;
use std::ptr::{null, null_mut};

fn name(path: &Path) -> CString {
    CString::new(path.to_str().unwrap()).unwrap()
}

#[test]
fn a_scene_goes_to_a_file_and_comes_back_with_the_same_bits_and_can_be_built_on() {
    let folder = tempfile::tempdir().unwrap();
    let at = name(&folder.path().join("a.bwx"));
    let (a, b) = (soup(15, 600), soup(16, 200));
    let built = Handle::committed(&[&a, &b]);
    let rays = rays(17, 3000);
    let expected: Vec<_> = built.intersect(&rays).iter().map(bits).collect();
    let opened = || {
        // SAFETY: C strings.
        [unsafe { bw_scene_open(at.as_ptr()) }, unsafe {
            bw_scene_read(at.as_ptr())
        }]
    };
    assert_eq!(opened(), [null_mut(); 2]);
    let (code, message) = last();
    assert_eq!(code, BwError::File);
    assert!(message.contains("a.bwx: "), "{message}");
    // SAFETY: a scene and a C string.
    let save = |handle: &Handle| unsafe { bw_scene_save(handle.0, at.as_ptr()) };
    assert_eq!(save(&built), BwError::None);
    let [mapped, copied] = opened().map(Handle);
    // Saved over, while one is mapped.
    assert_eq!(save(&Handle::committed(&[&plate(1.0)])), BwError::None);
    for handle in [&mapped, &copied] {
        let found: Vec<_> = handle.intersect(&rays).iter().map(bits).collect();
        assert_eq!(found, expected);
        assert_eq!(handle.set(0, &(vec![], vec![])), BwError::None);
        assert_eq!(handle.attach(&plate(-20.0)), 2);
        assert_eq!(handle.commit(), BwError::None);
        assert_eq!(handle.stats().triangles, 201);
    }
    let [new, _] = opened().map(Handle);
    assert_eq!(new.stats().triangles, 1);
    let files = folder.path().read_dir().unwrap().count();
    assert_eq!(files, 1, "nothing stays beside it");
}

#[test]
fn what_cannot_be_saved_or_opened_says_why_and_changes_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bwx");
    std::fs::write(&path, "dear").unwrap();
    let (at, within) = (name(&path), name(folder.path()));
    let (plate, world, empty) = (
        Handle::committed(&[&plate(1.0)]),
        Handle::new(),
        Handle::new(),
    );
    world.place(&plate, &Transform::IDENTITY);
    assert_eq!(world.commit(), BwError::None);
    let nowhere = name(&folder.path().join("no/a.bwx"));
    // SAFETY: scenes, and NULL or C strings.
    unsafe {
        assert_eq!(bw_scene_save(world.0, at.as_ptr()), BwError::Unsupported);
        assert!(
            last()
                .1
                .contains("a.bwx: a scene of instances is not saved"),
            "{}",
            last().1
        );
        assert_eq!(bw_scene_save(empty.0, at.as_ptr()), BwError::NotCommitted);
        assert_eq!(bw_scene_save(plate.0, null()), BwError::NullPointer);
        assert_eq!(
            bw_scene_save(plate.0, c"".as_ptr()),
            BwError::InvalidArgument
        );
        assert_eq!(bw_scene_save(plate.0, within.as_ptr()), BwError::File);
        assert_eq!(bw_scene_save(plate.0, nowhere.as_ptr()), BwError::File);
        for open in [bw_scene_open, bw_scene_read] {
            assert!(open(at.as_ptr()).is_null());
            assert_eq!(last().0, BwError::BadFile);
            assert!(
                last().1.contains("a.bwx: is no saved scene"),
                "{}",
                last().1
            );
            assert!(open(null()).is_null());
            assert_eq!(last(), (BwError::NullPointer, "path is NULL".into()));
        }
    }
    assert_eq!(std::fs::read(&path).unwrap(), b"dear");
    assert_eq!(folder.path().read_dir().unwrap().count(), 1);
}

//! The door opens nothing but regular files beside the scene, whatever they are called.

use std::fs;
use std::path::{Path, PathBuf};

use boxwood_scene::{Door, Limits, load, load_bytes, load_with};

/// A folder of the test's own, gone with the value: `scene/` with files in it, `secret` outside.
struct Playground(PathBuf);

impl Playground {
    fn new(name: &str) -> Self {
        let root = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
            .join(format!("door-{name}-{}", std::process::id()));
        fs::create_dir_all(root.join("scene/sub")).unwrap();
        fs::write(root.join("secret"), "secret").unwrap();
        fs::write(root.join("scene/a b.bin"), "inside").unwrap();
        fs::write(root.join("scene/sub/c.bin"), "below").unwrap();
        Self(root)
    }

    fn door(&self) -> Door {
        Door::for_file(&self.0.join("scene/main.gltf"), Limits::default())
    }
}

impl Drop for Playground {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn files_beside_and_below_are_read() {
    let playground = Playground::new("good");
    let mut door = playground.door();
    for (uri, content) in [
        ("a%20b.bin", "inside"),
        ("a b.bin", "inside"),
        ("./a%20b.bin", "inside"),
        ("sub/c.bin", "below"),
        ("sub\\c.bin", "below"),
        (".//sub/./c.bin", "below"),
    ] {
        assert_eq!(door.beside(uri).unwrap(), content.as_bytes(), "{uri}");
    }
}

#[test]
fn evil_names_are_refused_and_named() {
    let playground = Playground::new("evil");
    let mut door = playground.door();
    let absolute = playground.0.join("secret").display().to_string();
    for uri in [
        "../secret",
        "..\\secret",
        "sub/../../secret",
        "sub\\..\\..\\secret",
        "./../secret",
        "%2e%2e/secret",
        "%2E%2e%2fsecret",
        "..%2fsecret",
        "..%5csecret",
        "%2e./secret",
        "%252e%252e/secret",
        "..;/secret",
        "....//secret",
        "/etc/passwd",
        "//etc/passwd",
        "%2fetc%2fpasswd",
        "\\etc\\passwd",
        "\\\\server\\share\\secret",
        "//server/share/secret",
        "\\\\?\\C:\\secret",
        "\\\\.\\pipe\\secret",
        "C:\\secret",
        "c:secret",
        "C%3a%5csecret",
        "file:///etc/passwd",
        "file://localhost/etc/passwd",
        "FILE:/etc/passwd",
        "http://example.org/secret",
        "https:secret",
        "ftp://example.org/secret",
        "data:,secret",
        "a b.bin:stream",
        "a b.bin\0",
        "a%20b.bin%00.png",
        "%00",
        "%",
        "%4",
        "%zz",
        "%+1",
        "%ff%fe",
        "%c0%ae%c0%ae/secret",
        "",
        ".",
        "./",
        "..",
        "../",
        "sub",
        "sub/",
        "~/secret",
        "$HOME/secret",
        "nothing.bin",
        "a b.bin/c",
        absolute.as_str(),
    ] {
        let error = door.beside(uri).expect_err(uri);
        assert!(error.to_string().contains("main.gltf"), "{error}");
    }
    let long = "a".repeat(100_000);
    assert!(door.beside(&long).is_err());
}

#[test]
fn a_name_of_an_obj_file_is_not_percent_decoded() {
    let playground = Playground::new("plain");
    fs::write(playground.0.join("scene/100%25.png"), "kept").unwrap();
    assert_eq!(
        playground.door().beside_named("100%25.png").unwrap(),
        b"kept"
    );
    assert!(playground.door().beside_named("%2e%2e/secret").is_err());
    assert!(playground.door().beside_named("../secret").is_err());
}

#[cfg(unix)]
#[test]
fn links_may_not_lead_out_and_devices_are_not_opened() {
    use std::os::unix::fs::symlink;

    let playground = Playground::new("links");
    let scene = playground.0.join("scene");
    symlink("a b.bin", scene.join("inside.lnk")).unwrap();
    symlink("../secret", scene.join("outside.lnk")).unwrap();
    symlink("/dev/zero", scene.join("zero.lnk")).unwrap();
    symlink("..", scene.join("up")).unwrap();
    symlink("loop.lnk", scene.join("loop.lnk")).unwrap();
    let fifo = scene.join("fifo");
    // Where there is no mkfifo the name is merely missing, which is refused too.
    let _ = std::process::Command::new("mkfifo").arg(&fifo).status();

    let mut door = playground.door();
    assert_eq!(door.beside("inside.lnk").unwrap(), b"inside");
    for uri in [
        "outside.lnk",
        "zero.lnk",
        "up/secret",
        "loop.lnk",
        "fifo",
        "up/scene/../secret",
    ] {
        assert!(door.beside(uri).is_err(), "{uri}");
    }
    // `up` leads out of the folder and back in again, so the file is one beside the scene after all.
    assert_eq!(door.beside("up/scene/sub/c.bin").unwrap(), b"below");
    for (path, cause) in [
        (Path::new("/dev/zero"), "is not a regular file"),
        (&fifo, "is not a regular file"),
        (&scene, "is a folder: name a file in it"),
    ] {
        let error = load(path).unwrap_err().to_string();
        assert!(error.contains(cause), "{}: {error}", path.display());
    }
}

#[test]
fn a_file_over_the_limit_is_refused_before_it_is_read() {
    let playground = Playground::new("limit");
    let path = playground.0.join("scene/big.obj");
    fs::File::create(&path).unwrap().set_len(9 << 30).unwrap();
    let error = load(&path).unwrap_err().to_string();
    assert!(error.contains("too large"), "{error}");

    let limits = Limits {
        max_file_bytes: 10,
        ..Limits::default()
    };
    assert!(
        load_with(&playground.0.join("secret"), limits)
            .unwrap_err()
            .to_string()
            .contains("format")
    );
    assert!(load_bytes("a.obj", None, b"v 0 0 0 0 0 0", limits).is_err());
    // The limit is for the scene with all that it brings along.
    let mut door = Door::for_file(&path, limits);
    assert!(door.beside("a b.bin").is_ok());
    assert!(
        door.beside("sub/c.bin")
            .unwrap_err()
            .to_string()
            .contains("limit")
    );
}

#[test]
fn bytes_without_a_file_open_nothing() {
    let mut door = Door::without_files("<stdin>", Limits::default());
    let error = door.beside("Cargo.toml").unwrap_err().to_string();
    assert!(error.starts_with("<stdin>: \"Cargo.toml\""), "{error}");
    let model = load_bytes(
        "-",
        Some("OBJ"),
        b"mtllib a.mtl\nv 0 0 0\nf 1 1 1",
        Limits::default(),
    )
    .unwrap();
    assert_eq!(model.triangle_count(), 1);
    assert!(model.warnings[0].contains("a.mtl"), "{:?}", model.warnings);
}

#[test]
fn the_format_is_told_by_name_then_extension_then_content() {
    let limits = Limits::default();
    let obj = b"# made by hand\nv 0 0 0\nf 1 1 1\n";
    let ply = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
                element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n3 0 0 0\n";
    let stl = b"solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nendloop\nendfacet\nendsolid";
    for bytes in [&obj[..], ply, stl] {
        assert_eq!(
            load_bytes("<stdin>", None, bytes, limits)
                .unwrap()
                .triangle_count(),
            1
        );
    }
    assert_eq!(
        load_bytes("A.OBJ", None, obj, limits)
            .unwrap()
            .triangle_count(),
        1
    );
    assert!(load_bytes("a.ply", None, obj, limits).is_err());
    assert_eq!(
        load_bytes("a.ply", Some("obj"), obj, limits)
            .unwrap()
            .triangle_count(),
        1
    );
    let unknown = load_bytes("a.xyz", None, b"what?", limits)
        .unwrap_err()
        .to_string();
    assert!(
        unknown.contains("obj, ") || unknown.contains(", obj"),
        "{unknown}"
    );
    assert!(
        load_bytes("a", Some("fbx"), obj, limits)
            .unwrap_err()
            .to_string()
            .contains("fbx")
    );
}

//! Shards, and their merge.

use crate::common::{command, expect, folder, json, text};
use crate::help::{LOOKS, names, refusal, spawn, words};
use std::fs;
use std::process::Child;

#[test]
fn four_processes_and_a_merge_give_the_bytes_of_one() {
    for (scene, look) in LOOKS {
        let folder = folder();
        let at = folder.path();
        for output in ["one.png", "one.exr"] {
            expect(at, &words(scene, look, output), 0);
        }
        let shards = ["--shard=1/4", "--shard=2/4", "--shard=3/4", "--shard=4/4"];
        let children: Vec<Child> = shards
            .iter()
            .map(|shard| spawn(at, &[&words(scene, look, "p.png")[..], &[shard]].concat()))
            .collect();
        for mut child in children {
            assert!(child.wait().unwrap().success(), "{scene} {look}");
        }
        let parts = [
            "p.png.3of4.part",
            "p.png.1of4.part",
            "p.png.4of4.part",
            "p.png.2of4.part",
        ];
        for (output, one) in [("p.png", "one.png"), ("p.exr", "one.exr")] {
            expect(at, &[&["merge"][..], &parts, &["-o", output]].concat(), 0);
            let [merged, one] = [output, one].map(|name| fs::read(at.join(name)).unwrap());
            assert!(merged == one, "{scene} {look} {output}");
        }
        assert_eq!(names(at).len(), 8, "no other files: {:?}", names(at));
    }
}

#[test]
fn a_shard_that_is_done_is_done_and_one_that_is_damaged_is_mended() {
    let folder = folder();
    let at = folder.path();
    let args = [
        &words("builtin:cornell", "--shading=normal", "a.png")[..],
        &["--shard=2/2"],
    ]
    .concat();
    let first = json(at, &args, 0);
    assert_eq!(
        (&first["shard"], &first["resumed_tiles"]),
        (&"2/2".into(), &0.into())
    );
    let part = at.join("a.png.2of2.part");
    let bytes = fs::read(&part).unwrap();
    assert!(
        !text(&bytes).contains("instructions"),
        "machines may differ"
    );
    let again = json(at, &args, 0);
    // 7 x 5 tiles.
    assert_eq!(again["resumed_tiles"], 17);
    assert!(fs::read(&part).unwrap() == bytes);
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 1;
    fs::write(&part, &damaged).unwrap();
    let said = text(&expect(at, &args, 0).stderr);
    assert!(said.contains("1 damaged tile passed over"), "{said}");
    // The rest stands where it stood, and the tile behind it.
    let mended = fs::read(&part).unwrap();
    assert!(mended.starts_with(&damaged) && mended.len() > bytes.len());
    assert_eq!(json(at, &args, 0)["resumed_tiles"], 17);
    assert_eq!(names(at), ["a.png.2of2.part"]);
    let other = [&args[..args.len() - 1], &["--shard=1/2"]].concat();
    expect(at, &other, 0);
    let parts = ["a.png.1of2.part", "a.png.2of2.part"];
    expect(at, &[&["merge"][..], &parts, &["-o", "m.png"]].concat(), 0);
    expect(at, &args[..args.len() - 1], 0);
    assert!(fs::read(at.join("m.png")).unwrap() == fs::read(at.join("a.png")).unwrap());

    // Where no size can be read, nothing is thrown away.
    let mut lost = bytes.clone();
    let header = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize + 20;
    lost[header + 8] ^= 1;
    fs::write(&part, &lost).unwrap();
    let error = refusal(at, &args, 3);
    assert!(
        error.contains(&format!("is damaged at byte {header}")),
        "{error}"
    );
    assert!(fs::read(&part).unwrap() == lost);
}

#[test]
fn merge_refuses_what_does_not_go_together() {
    let folder = folder();
    let at = folder.path();
    let shard = |output: &str, look: &str, shard: &str| {
        let args = [
            &words("builtin:cornell", look, output)[..],
            &["--shard", shard],
        ]
        .concat();
        expect(at, &args, 0);
    };
    shard("a.png", "--shading=normal --spp=1", "1/3");
    shard("a.png", "--shading=normal --spp=1", "3/3");
    shard("b.png", "--shading=normal --spp=2", "2/3");
    let merge =
        |parts: &[&str]| refusal(at, &[&["merge"][..], parts, &["-o", "m.png"]].concat(), 3);
    let error = merge(&["a.png.1of3.part", "a.png.3of3.part"]);
    // 7 x 5 tiles, of which every third is missing.
    assert!(
        error.contains("12 of the picture's 35 tiles are missing: 1, 4, 7,"),
        "{error}"
    );
    let help = "boxwood render builtin:cornell --size=109x67 -o a.png --shading=normal --spp=1 --shard 2/3";
    assert!(error.contains(help), "{error}");
    let error = merge(&["a.png.1of3.part", "b.png.2of3.part"]);
    let what = "b.png.2of3.part: --spp is 2 here and 1 in a.png.1of3.part";
    assert!(error.contains(what), "{error}");
    let error = merge(&["a.png.1of3.part", "a.png.1of3.part"]);
    // Whichever was done first.
    assert!(error.contains(" is in a.png.1of3.part too"), "{error}");

    let bytes = fs::read(at.join("a.png.1of3.part")).unwrap();
    let mut damaged = bytes.clone();
    damaged[bytes.len() - 3000] ^= 4;
    fs::write(at.join("damaged"), &damaged).unwrap();
    assert!(merge(&["damaged"]).contains("is damaged at byte "));
    let mut other = bytes.clone();
    other[20] ^= 1;
    fs::write(at.join("other"), &other).unwrap();
    assert!(merge(&["other"]).contains("its header is damaged"));
    fs::write(at.join("torn"), &bytes[..bytes.len() - 1]).unwrap();
    assert!(merge(&["torn", "a.png.3of3.part"]).contains("13 of the picture's 35"));
    fs::write(at.join("short"), &bytes[..100]).unwrap();
    assert!(merge(&["short"]).contains("ends before its first tile"));
    fs::write(at.join("foreign"), "P6 1 1").unwrap();
    assert!(merge(&["foreign"]).contains("is not a file of tiles"));
    assert!(merge(&["none"]).contains("none: "));
    assert!(merge(&["."]).contains("is not a plain file"));
    assert!(!at.join("m.png").exists());
}

#[test]
fn the_schedulers_say_which_shard_it_is() {
    let folder = folder();
    let at = folder.path();
    let auto = |variables: &[(&str, &str)]| {
        let mut command = command(at);
        command.args([
            "render",
            "builtin:cornell",
            "--turntable=8",
            "--shard=auto",
            "--dry-run",
        ]);
        let output = command.envs(variables.iter().copied()).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let slurm = auto(&[
        ("SLURM_ARRAY_TASK_ID", "7"),
        ("SLURM_ARRAY_TASK_MIN", "5"),
        ("SLURM_ARRAY_TASK_MAX", "8"),
        ("SLURM_ARRAY_TASK_COUNT", "4"),
    ]);
    assert_eq!(
        slurm,
        "cornell.0003.png, frame 3 would be made\ncornell.0007.png, frame 7 would be made\n"
    );
    let kubernetes = auto(&[("JOB_COMPLETION_INDEX", "7"), ("JOB_COMPLETIONS", "8")]);
    assert_eq!(kubernetes, "cornell.0008.png, frame 8 would be made\n");
}

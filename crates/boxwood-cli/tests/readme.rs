//! The commands that README.md and `--help` show, run as they stand there, but for smaller pictures.
#![cfg(unix)]

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

const README: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../README.md");

/// Runs a line by the shell, in `folder`, where `boxwood` is the binary under test.
fn shell(folder: &Path, line: &str) -> std::process::Output {
    let binary = Path::new(env!("CARGO_BIN_EXE_boxwood"));
    let path = format!(
        "{}:{}",
        binary.parent().unwrap().display(),
        std::env::var("PATH").unwrap_or_default()
    );
    let mut command = Command::new("sh");
    command
        .args(["-c", line])
        .current_dir(folder)
        .env("PATH", path)
        .env("HOME", folder)
        .stdin(Stdio::null());
    command.output().expect("there is a shell")
}

/// The lines that run boxwood, in fenced blocks marked `console` or `sh`; a `$ ` before them is the prompt.
fn commands_of_markdown(text: &str) -> Vec<String> {
    let mut inside = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        if let Some(mark) = line.trim_start().strip_prefix("```") {
            inside = !inside && matches!(mark.trim(), "console" | "sh");
        } else if inside {
            let line = line.trim();
            lines.push(line.strip_prefix("$ ").unwrap_or(line).to_owned());
        }
    }
    lines.retain(|line| is_command(line));
    lines
}

/// The lines under `Examples:` of a help text.
fn commands_of_help(text: &str) -> Vec<String> {
    let (_, examples) = text.split_once("Examples:\n").unwrap_or_default();
    // Two blanks end the command: a remark follows.
    let lines = examples.lines().map(|line| {
        line.trim()
            .split("   ")
            .next()
            .unwrap_or_default()
            .trim()
            .to_owned()
    });
    lines.filter(|line| is_command(line)).collect()
}

/// One that ends: the page is served until Ctrl+C, and tried by its own tests.
fn is_command(line: &str) -> bool {
    (line == "boxwood" || line.starts_with("boxwood ")) && !line.contains(" --web")
}

/// Flags that make a command quick; said last, they win.
fn quick(line: &str) -> String {
    let extra = match line.split_whitespace().nth(1).unwrap_or("demo") {
        "render" => "--size 48x27 --spp 1",
        "demo" => "--size 48x27",
        "race" => "--size 48x27",
        "view" => "--headless --size 48x27",
        "check" => "--rays 300",
        // Who is compared with an earlier run must not fail here because the machine is busy.
        "bench" => "--size 16 --rounds 1 --tolerance 10000",
        _ => "",
    };
    if line == "boxwood" {
        return format!("boxwood demo {extra}");
    }
    // A # within a word is a digit of a frame.
    let ends = [line.find([';', '|', '<', '>', '&']), line.find(" #")];
    let end = ends.into_iter().flatten().min().unwrap_or(line.len());
    let (command, rest) = line.split_at(end);
    // The crop of an example is for a picture of the usual size.
    let extra = if command.contains("--crop") {
        extra.replace("--size 48x27", "")
    } else {
        extra.to_owned()
    };
    format!("{} {extra} {rest}", command.trim_end())
        .trim_end()
        .to_owned()
}

/// A folder with the files that examples name.
fn stage(commands: &[String]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for place in [
        ".zfunc",
        ".local/share/bash-completion/completions",
        ".config/fish/completions",
    ] {
        fs::create_dir_all(at(place)).unwrap();
    }
    let run = |line: &str| {
        let output = shell(folder.path(), line);
        assert!(
            output.status.success(),
            "{line}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    };
    run("boxwood simplify 'builtin:terrain?n=2000' --triangles 600 -o mesh.obj");
    run("boxwood simplify 'builtin:terrain?n=2000' --triangles 600 -o mesh.ply");
    run("boxwood render mesh.obj --size 24x16 -o picture.png");
    for shard in ["1/2", "2/2"] {
        run(&format!(
            "boxwood render builtin:bush --size 48x27 --spp 1 --shard {shard} -o bush.png"
        ));
    }
    let words = commands.iter().flat_map(|line| line.split_whitespace());
    for word in words.filter(|word| !word.contains(['/', ':', '*'])) {
        let kind = Path::new(word)
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let source = match &*kind {
            "obj" => "mesh.obj",
            // The loaders go by content where the name says nothing; a glTF must be one.
            "ply" => "mesh.ply",
            "png" => "picture.png",
            "gltf" | "glb" => {
                fs::write(at(word), tiny_gltf()).unwrap();
                continue;
            }
            "json" => {
                fs::write(at(word), CAMERA_PATH).unwrap();
                continue;
            }
            _ => continue,
        };
        if !at(word).exists() {
            fs::copy(at(source), at(word)).unwrap();
        }
    }
    folder
}

const CAMERA_PATH: &str = r#"{"boxwood-path": 1, "keys": [
    {"frame": 1, "eye": [278, 273, -800], "target": [278, 273, 0]},
    {"frame": 48, "eye": [400, 300, 60], "target": [150, 150, 400], "fov": 60}
]}"#;

/// One triangle, its data within.
fn tiny_gltf() -> &'static str {
    r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#
}

#[track_caller]
fn run_all(source: &str, commands: &[String]) {
    let folder = stage(commands);
    for line in commands {
        let line = quick(line);
        let output = shell(folder.path(), &line);
        let error = String::from_utf8_lossy(&output.stderr);
        // 1 is an answer too: a difference was found.
        assert!(
            matches!(output.status.code(), Some(0 | 1)),
            "{source}: {line}\n{error}"
        );
    }
    println!("{source}: {} commands", commands.len());
}

#[test]
fn the_commands_of_the_readme_run() {
    let Ok(text) = fs::read_to_string(PathBuf::from(README)) else {
        println!("skipped: there is no {README}");
        return;
    };
    run_all("README.md", &commands_of_markdown(&text));
}

#[test]
fn the_commands_of_the_farm_page_run() {
    let page = Path::new(README).with_file_name("docs/farm/README.md");
    let Ok(text) = fs::read_to_string(&page) else {
        println!("skipped: there is no {}", page.display());
        return;
    };
    run_all("docs/farm/README.md", &commands_of_markdown(&text));
}

#[test]
fn the_examples_of_every_help_run() {
    let folder = tempfile::tempdir().unwrap();
    let help =
        |line: &str| String::from_utf8_lossy(&shell(folder.path(), line).stdout).into_owned();
    let root = help("boxwood --help");
    let (_, list) = root
        .split_once("Commands:\n")
        .expect("help lists the commands");
    let names = list
        .lines()
        .take_while(|line| line.starts_with("  "))
        .filter(|line| !line.starts_with("   "));
    let mut commands = commands_of_help(&root);
    for name in names.filter_map(|line| line.split_whitespace().next()) {
        let examples = commands_of_help(&help(&format!("boxwood {name} --help")));
        assert!(!examples.is_empty(), "{name} has no examples");
        commands.extend(examples);
    }
    commands.sort();
    commands.dedup();
    run_all("--help", &commands);
}

#[test]
fn commands_are_found_where_they_stand() {
    let markdown = "```sh\ncargo run --release\nboxwood list\n```\nboxwood no\n```console\n$ boxwood doctor\nthreads 2\n```\n\
                    ```rust\nboxwood no\n```\n";
    assert_eq!(
        commands_of_markdown(markdown),
        ["boxwood list", "boxwood doctor"]
    );
    let help = "Usage: x\n\nExamples:\n  boxwood                 the demonstration\n  boxwood render a.obj > b.png\n";
    assert_eq!(
        commands_of_help(help),
        ["boxwood", "boxwood render a.obj > b.png"]
    );
    assert_eq!(quick("boxwood"), "boxwood demo --size 48x27");
    assert_eq!(
        quick("boxwood render - -o - < a.ply > b.png"),
        "boxwood render - -o - --size 48x27 --spp 1 < a.ply > b.png"
    );
}

//! Every odd, broken and hostile file of the test scenes ends as its manifest says.

mod support;

use boxwood_scene::{LoadError, Model, load};
use support::{Manifest, scenes};

#[test]
fn every_bad_file_ends_as_its_manifest_says() {
    let Some(folder) = scenes() else { return };
    let mut failures = Vec::new();
    let mut files = 0;
    Manifest::read(folder.join("bad/MANIFEST.tsv")).for_each_row(|cell| {
        files += 1;
        let file = cell("file");
        let outcome = load(&folder.join(&file));
        if let Err(failure) = judge(&outcome, &cell("expect"), &cell("triangles")) {
            failures.push(format!("{file}: {failure}"));
        }
    });
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(files > 15, "only {files} files in the manifest");
}

fn judge(outcome: &Result<Model, LoadError>, expect: &str, triangles: &str) -> Result<(), String> {
    match (outcome, expect) {
        (Ok(model), "accept" | "either") => {
            let got = model.triangle_count();
            let is_silent = got == 0 && model.warnings.is_empty();
            (got.to_string() == triangles && !is_silent)
                .then_some(())
                .ok_or(format!("{got} triangles"))
        }
        (Ok(model), _) => Err(format!(
            "accepted with {} triangles",
            model.triangle_count()
        )),
        (Err(error), "refuse" | "either") => {
            let names_file = !error.file.is_empty() && !error.cause.is_empty();
            names_file
                .then_some(())
                .ok_or(format!("an error that says nothing: {error}"))
        }
        (Err(error), _) => Err(format!("refused: {error}")),
    }
}

#[test]
fn errors_name_the_place_and_the_culprit() {
    let Some(folder) = scenes() else { return };
    for (file, words) in [
        ("index_out_of_range.obj", &[":", "vertex 9 of 8"][..]),
        ("nan_coords.obj", &["obj:", "nan"]),
        ("four_billion_faces.ply", &["4294967295"]),
        ("short_vertex_data.ply", &["ply:", "header"]),
        ("wrong_count_binary.stl", &["1000000", "684"]),
        ("uri_traversal.gltf", &["etc/passwd"]),
        ("accessor_out_of_bounds.gltf", &["accessor", "3600"]),
        ("node_cycle.gltf", &["node"]),
        ("meshopt_required/scene.gltf", &["EXT_meshopt_compression"]),
    ] {
        let error = load(&folder.join("bad").join(file))
            .unwrap_err()
            .to_string();
        println!("{error}");
        for word in words {
            assert!(error.contains(word), "\"{word}\" is missing in: {error}");
        }
    }
}

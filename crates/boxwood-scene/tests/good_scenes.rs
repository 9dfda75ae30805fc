//! Every good file of the test scenes loads with the counts and bounds that its manifest gives.

mod support;

use boxwood_scene::load;
use support::{Manifest, scenes};

#[test]
fn every_good_file_has_the_measured_counts_and_bounds() {
    let Some(folder) = scenes() else { return };
    let mut failures = Vec::new();
    let mut files = 0;
    Manifest::read(folder.join("MANIFEST.tsv")).for_each_row(|cell| {
        let file = cell("file");
        if file.starts_with("generate:") {
            return;
        }
        files += 1;
        if let Err(failure) = agrees(&folder.join(&file), cell) {
            failures.push(format!("{file}: {failure}"));
        }
    });
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(files > 20, "only {files} files in the manifest");
}

fn agrees(path: &std::path::Path, cell: &dyn Fn(&str) -> String) -> Result<(), String> {
    let model = load(path).map_err(|error| error.to_string())?;
    let same = |what: &str, got: u64, wanted: &str| {
        (got.to_string() == wanted)
            .then_some(())
            .ok_or(format!("{got} {what} instead of {wanted}"))
    };
    same("triangles", model.triangle_count(), &cell("triangles"))?;
    same(
        "unique triangles",
        model.unique_triangle_count(),
        &cell("unique_triangles"),
    )?;

    let flat = model.flatten().map_err(|error| error.to_string())?;
    same(
        "flat triangles",
        flat.indices.len() as u64,
        &cell("triangles"),
    )?;
    let bounds = flat.bounds().ok_or("no bounds")?;
    for (got, wanted) in [(bounds.0, cell("bbox_min")), (bounds.1, cell("bbox_max"))] {
        let wanted: Vec<f32> = wanted.split(',').map(|x| x.parse().unwrap()).collect();
        let size = wanted.iter().fold(0.0f32, |size, x| size.max(x.abs()));
        if (0..3).any(|k| (got[k] - wanted[k]).abs() > 1e-4 * size) {
            return Err(format!("bounds {got:?} instead of {wanted:?}"));
        }
    }
    Ok(())
}

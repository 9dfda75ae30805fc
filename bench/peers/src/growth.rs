//! What more triangles cost: rays per second from a thousand triangles to millions.

use crate::measure::{Bench, Settings, measure};
use anyhow::Result;
use boxwood_measure::{html::Section, plot::Lines};

/// One contender asked in one way, over all sizes.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    /// `boxwood, batch`.
    pub(crate) who: String,
    /// The set of rays.
    pub(crate) set: String,
    /// Triangles and million rays per second.
    pub(crate) points: Vec<[f64; 2]>,
}

/// The scene that grows: surfaces as they are scanned, seen from outside.
pub(crate) const SCENE: &str = "builtin:terrain";
/// Who is measured.
const WHO: [&str; 2] = ["boxwood", "embree"];

/// Sizes of powers of ten, from a thousand to `limit`, on one thread.
pub(crate) fn curves(limit: u64, settings: &Settings, bench: &Bench) -> Result<Vec<Curve>> {
    let settings = Settings {
        only: WHO.map(str::to_owned).to_vec(),
        threads: 1,
        ..settings.clone()
    };
    let mut curves: Vec<Curve> = Vec::new();
    for n in (3..8)
        .map(|power| 10_u64.pow(power))
        .filter(|n| *n <= limit)
    {
        let name = format!("{SCENE}?n={n}");
        let mesh = boxwood_scene::open(&name)?.flatten()?;
        let measured = measure(&name, &mesh, None, &settings, bench)?;
        for row in &measured.report.rows {
            for cell in &row.cells {
                let who = format!("{}, {}", row.name, cell.mode.name());
                let point = [mesh.indices.len() as f64, cell.mrays];
                match curves
                    .iter_mut()
                    .find(|curve| curve.who == who && curve.set == cell.set)
                {
                    Some(curve) => curve.points.push(point),
                    None => curves.push(Curve {
                        who,
                        set: cell.set.clone(),
                        points: vec![point],
                    }),
                }
            }
        }
    }
    Ok(curves)
}

/// A plot for each set of rays.
pub(crate) fn section(curves: &[Curve]) -> Result<Section> {
    let mut sets: Vec<&str> = curves.iter().map(|curve| &*curve.set).collect();
    sets.sort_unstable();
    sets.dedup();
    let plot = |set: &str| {
        let of_set = curves.iter().filter(|curve| curve.set == set);
        Lines {
            title: set.to_owned(),
            axes: ["triangles", "million rays per second"].map(str::to_owned),
            series: of_set
                .map(|curve| (curve.who.clone(), curve.points.clone()))
                .collect(),
        }
        .svg()
    };
    Ok(Section {
        title: "The cost of growth".to_owned(),
        text: vec![format!(
            "{SCENE} from a thousand triangles on, seen from outside, one thread."
        )],
        plots: sets.into_iter().map(plot).collect::<Result<_, _>>()?,
        ..Section::default()
    })
}

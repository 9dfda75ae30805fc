//! The check for scenes of instances: structures around structures.

use super::run::{Check, is_closed};
use super::variants::{ORACLE, Variant, choices, name_of};
use super::{Options, Progress, Report};
use crate::build::BuildOptions;
use crate::error::BuildError;
use crate::geom::{Transform, Triangle};
use crate::prims::{Geometry, Triangles};
use crate::query::Query;
use crate::scene::{Instance, Scene};
use crate::tables::{STRUCTURES, Structure};
use std::sync::Arc;

/// Meshes, and where they stand.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// Each in its own space.
    pub meshes: Vec<Vec<Triangle>>,
    /// Which mesh, and where. Numbers beyond the meshes are left out.
    pub instances: Vec<(u32, Transform)>,
}

type Choice = (Structure, BuildOptions);

/// [`run`](super::run) for instances: every structure of the tables, in all its forms, around the default one and the default one around every
/// other, and each structure around each. The truth is `list` around `list`.
///
/// Parity is tested if every mesh is closed. Memory: besides the structures, all triangles multiplied out, at which the rays are aimed.
///
/// # Errors
/// As [`run`](super::run).
pub fn run_instances(
    layout: &Layout,
    options: &Options,
    progress: &mut dyn FnMut(&Progress<'_>),
) -> Result<Report, BuildError> {
    let layout = Arc::new(layout.clone());
    let list = (Structure::named(ORACLE)?, BuildOptions::default());
    let oracle = layout.build(&list, &list)?;
    let is_closed = layout.meshes.iter().all(|mesh| is_closed(mesh));
    let variants: Vec<Variant> = pairs()
        .into_iter()
        .map(|(outside, inside)| {
            let name = format!("{} around {}", name(&outside), name(&inside));
            let layout = Arc::clone(&layout);
            Variant::new(name, move |_| layout.build(&outside, &inside))
        })
        .collect();
    let world = layout.flattened();
    Check::against(oracle, is_closed, &world, &variants, options, progress)?.run()
}

fn name((structure, options): &Choice) -> String {
    name_of(structure, options)
}

/// Outside and inside, each pair once; that of the defaults comes first.
fn pairs() -> Vec<(Choice, Choice)> {
    let all = choices();
    let Some(default) = all.first().cloned() else {
        return Vec::new();
    };
    let around_default = all.iter().map(|c| (c.clone(), default.clone()));
    let inside_default = all.iter().map(|c| (default.clone(), c.clone()));
    let usual = STRUCTURES.iter().map(|s| (*s, BuildOptions::default()));
    let each = usual
        .clone()
        .flat_map(|outside| usual.clone().map(move |inside| (outside.clone(), inside)));
    let mut names = std::collections::HashSet::new();
    let is_truth = |pair: &(Choice, Choice)| pair.0.0.name == ORACLE && pair.1.0.name == ORACLE;
    around_default
        .chain(inside_default)
        .chain(each)
        .filter(|pair| !is_truth(pair) && names.insert((name(&pair.0), name(&pair.1))))
        .collect()
}

impl Layout {
    fn build(&self, outside: &Choice, inside: &Choice) -> Result<Box<dyn Query>, BuildError> {
        let (structure, options) = inside;
        let part = |mesh: &Vec<Triangle>| {
            let geometry = Geometry::Triangles(Triangles::new(mesh.clone()));
            Scene::of(geometry, vec![0], structure.name, options, None).map(Arc::new)
        };
        let parts: Vec<Arc<Scene>> = self.meshes.iter().map(part).collect::<Result<_, _>>()?;
        let (structure, options) = outside;
        let scene = Scene::builder()
            .instances(self.uses(&parts).map(|(part, at)| Instance::new(part, at)))
            .structure(structure.name)
            .options(options.clone());
        Ok(scene.build()?.into_query())
    }

    /// Every triangle of every instance in the world, rounded.
    fn flattened(&self) -> Vec<Triangle> {
        let placed = |(mesh, at): (&Vec<Triangle>, Transform)| -> Vec<Triangle> {
            mesh.iter()
                .map(|t| Triangle(t.0.map(|corner| at.point(corner))))
                .collect()
        };
        self.uses(&self.meshes).flat_map(placed).collect()
    }

    /// The instances with what they show, out of one for each mesh.
    fn uses<'a, T>(&'a self, shown: &'a [T]) -> impl Iterator<Item = (&'a T, Transform)> {
        self.instances
            .iter()
            .filter_map(|(mesh, at)| Some((shown.get(*mesh as usize)?, *at)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_structure_stands_around_every_other_once() {
        let names: Vec<_> = pairs().iter().map(|(o, i)| (name(o), name(i))).collect();
        for outside in STRUCTURES {
            for inside in STRUCTURES {
                let is_there = names
                    .iter()
                    .any(|(o, i)| o.starts_with(outside.name) && i.starts_with(inside.name));
                let is_truth = outside.name == ORACLE && inside.name == ORACLE;
                assert!(
                    is_there != is_truth,
                    "{} around {}",
                    outside.name,
                    inside.name
                );
            }
        }
        let unique: std::collections::HashSet<_> = names.iter().collect();
        assert_eq!(unique.len(), names.len());
    }

    #[test]
    fn instances_of_a_closed_mesh_are_clean_and_even() {
        let p = [
            [0.0, 0.0, 0.0],
            [3.0, 0.5, 0.0],
            [0.0, 2.0, 1.0],
            [1.0, 1.0, 4.0],
        ];
        let faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        let mesh = faces.map(|f| Triangle(f.map(|i: usize| p[i])));
        let turn = Transform([
            [0.6, -0.8, 0.0, 2.0],
            [0.8, 0.6, 0.0, -1.0],
            [0.0, 0.0, -3.0, 0.5],
        ]);
        let layout = Layout {
            meshes: vec![mesh.to_vec()],
            instances: vec![
                (0, Transform::IDENTITY),
                (0, turn),
                (0, turn.after(&turn)),
                (7, turn),
            ],
        };
        let options = Options {
            rays: 2000,
            ..Options::default()
        };
        let report = run_instances(&layout, &options, &mut |_| {}).unwrap();
        assert!(
            report.is_clean() && report.is_closed,
            "{:?}",
            report.failures.first()
        );
        assert!(report.parity_rays > 1900 && report.hits > 500);
    }
}

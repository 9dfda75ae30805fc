//! The node tree, walked into a list of instances and cameras.

use glam::{DMat4, DQuat, DVec3};

use super::Source;
use super::json::{InstancingAttributes, Node};
use crate::{Camera, Door, Instance, LoadError};

/// Deepest chain of nodes. Real scenes have a few dozen; a chain of a million is an attack.
const MAX_DEPTH: u32 = 1024;

/// Most instances in a scene.
const MAX_INSTANCES: usize = 1 << 22;

/// Walks the default scene (or, where none is named, all roots): a mesh once for each node that uses it.
///
/// Transforms are multiplied in f64 and rounded once.
pub(super) fn read(
    source: &Source<'_>,
    door: &mut Door,
) -> Result<(Vec<Instance>, Vec<Camera>), LoadError> {
    let nodes = &source.document.nodes;
    let mut walk = Walk {
        source,
        instances: Vec::new(),
        cameras: Vec::new(),
    };
    let mut is_seen = vec![false; nodes.len()];
    let mut stack = Vec::new();
    push(&mut stack, &roots(source)?, DMat4::IDENTITY, 1);
    while let Some(Step {
        node: index,
        world_from_parent,
        depth,
    }) = stack.pop()
    {
        let path = format!("nodes[{index}]");
        let Some(node) = nodes.get(index as usize) else {
            return Err(source.fault(
                path,
                format!("does not exist: there are {} nodes", nodes.len()),
            ));
        };
        if std::mem::replace(&mut is_seen[index as usize], true) {
            return Err(source.fault(
                path,
                "is reached twice: nodes must form a tree, without cycles and shared children",
            ));
        }
        if depth > MAX_DEPTH {
            return Err(source.fault(
                path,
                format!("stands deeper than {MAX_DEPTH} nodes below its root"),
            ));
        }
        let world_from_node = world_from_parent * walk.local(node, &path)?;
        walk.visit(node, world_from_node, &path, door)?;
        push(&mut stack, &node.children, world_from_node, depth + 1);
    }
    Ok((walk.instances, walk.cameras))
}

/// A node that waits for its turn.
struct Step {
    node: u32,
    world_from_parent: DMat4,
    depth: u32,
}

/// In reverse, so that they come off the stack in file order.
fn push(stack: &mut Vec<Step>, nodes: &[u32], world_from_parent: DMat4, depth: u32) {
    stack.extend(nodes.iter().rev().map(|&node| Step {
        node,
        world_from_parent,
        depth,
    }));
}

fn roots(source: &Source<'_>) -> Result<Vec<u32>, LoadError> {
    let document = &source.document;
    if let Some(scene) = document.scene {
        return match document.scenes.get(scene as usize) {
            Some(scene) => Ok(scene.nodes.to_vec()),
            None => Err(source.fault(
                "scene",
                format!("refers to scene {scene} of {}", document.scenes.len()),
            )),
        };
    }
    let mut is_child = vec![false; document.nodes.len()];
    for &child in document.nodes.iter().flat_map(|node| node.children.iter()) {
        if let Some(is_child) = is_child.get_mut(child as usize) {
            *is_child = true;
        }
    }
    let roots: Vec<_> = (0..document.nodes.len() as u32)
        .filter(|&node| !is_child[node as usize])
        .collect();
    if roots.is_empty() && !document.nodes.is_empty() {
        return Err(source.fault(
            "nodes",
            "each is the child of another: nodes must form a tree, without cycles",
        ));
    }
    Ok(roots)
}

struct Walk<'a> {
    source: &'a Source<'a>,
    instances: Vec<Instance>,
    cameras: Vec<Camera>,
}

impl Walk<'_> {
    /// The node's own transform.
    fn local(&self, node: &Node, path: &str) -> Result<DMat4, LoadError> {
        if let Some(matrix) = &node.matrix {
            let matrix = DMat4::from_cols_array(matrix);
            let bottom = matrix.row(3);
            if (bottom - glam::DVec4::W).abs().max_element() > 1e-6 {
                return Err(self.source.fault(
                    path,
                    "its matrix is not affine: the last row is not 0 0 0 1",
                ));
            }
            return Ok(matrix);
        }
        let vector =
            |v: &Option<Box<[f64; 3]>>, default| v.as_deref().map_or(default, |&v| DVec3::from(v));
        let translation = vector(&node.translation, DVec3::ZERO);
        let scale = vector(&node.scale, DVec3::ONE);
        let rotation = node
            .rotation
            .as_deref()
            .map_or(DQuat::IDENTITY, |&[x, y, z, w]| {
                unit(DQuat::from_xyzw(x, y, z, w))
            });
        Ok(DMat4::from_scale_rotation_translation(
            scale,
            rotation,
            translation,
        ))
    }

    fn visit(
        &mut self,
        node: &Node,
        world_from_node: DMat4,
        path: &str,
        door: &mut Door,
    ) -> Result<(), LoadError> {
        if let Some(mesh) = node.mesh {
            let count = self.source.document.meshes.len();
            if mesh as usize >= count {
                return Err(self
                    .source
                    .fault(path, format!("refers to mesh {mesh} of {count}")));
            }
            match node
                .extensions
                .as_ref()
                .and_then(|extensions| extensions.instancing.as_ref())
            {
                Some(instancing) => {
                    self.place_many(mesh, &instancing.attributes, world_from_node, path)?;
                }
                None => self.place(mesh, world_from_node, path)?,
            }
        }
        if let Some(camera) = node.camera {
            self.camera(camera, world_from_node, path, door)?;
        }
        Ok(())
    }

    fn place(&mut self, mesh: u32, world_from_mesh: DMat4, path: &str) -> Result<(), LoadError> {
        let world_from_mesh = world_from_mesh.as_mat4();
        if !world_from_mesh.is_finite() {
            return Err(self
                .source
                .fault(path, "its place in the world is out of the range of f32"));
        }
        if self.instances.len() == MAX_INSTANCES {
            return Err(self.source.fault(
                path,
                format!("brings the scene to more than {MAX_INSTANCES} instances"),
            ));
        }
        self.instances.push(Instance {
            mesh,
            world_from_mesh,
        });
        Ok(())
    }

    /// `EXT_mesh_gpu_instancing`: one instance for each element of the attributes.
    fn place_many(
        &mut self,
        mesh: u32,
        attributes: &InstancingAttributes,
        world_from_node: DMat4,
        path: &str,
    ) -> Result<(), LoadError> {
        let source = self.source;
        let path = format!("{path}.extensions.EXT_mesh_gpu_instancing");
        let translations = attributes
            .translation
            .map(|i| source.elements::<f32, 3>(i, &path, "translations"))
            .transpose()?;
        let rotations = attributes
            .rotation
            .map(|i| source.elements::<f32, 4>(i, &path, "rotations"))
            .transpose()?;
        let scales = attributes
            .scale
            .map(|i| source.elements::<f32, 3>(i, &path, "scales"))
            .transpose()?;
        let counts = [
            translations.as_ref().map(|elements| elements.count()),
            rotations.as_ref().map(|elements| elements.count()),
            scales.as_ref().map(|elements| elements.count()),
        ];
        let count = counts.iter().flatten().copied().max().unwrap_or(0);
        if counts.iter().flatten().any(|&other| other != count) {
            return Err(source.fault(path, "its attributes have different counts"));
        }
        for i in 0..count as u32 {
            let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
            let translation = translations
                .as_ref()
                .map_or(DVec3::ZERO, |elements| vector(elements.get(i)));
            let scale = scales
                .as_ref()
                .map_or(DVec3::ONE, |elements| vector(elements.get(i)));
            let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |elements| {
                unit(DQuat::from_array(elements.get(i).map(f64::from)))
            });
            let node_from_mesh =
                DMat4::from_scale_rotation_translation(scale, rotation, translation);
            self.place(mesh, world_from_node * node_from_mesh, &path)?;
        }
        Ok(())
    }

    /// Only perspective cameras; glTF's look along their own -z axis.
    fn camera(
        &mut self,
        index: u32,
        world_from_node: DMat4,
        path: &str,
        door: &mut Door,
    ) -> Result<(), LoadError> {
        let cameras = &self.source.document.cameras;
        let Some(camera) = cameras.get(index as usize) else {
            return Err(self.source.fault(
                path,
                format!("refers to camera {index} of {}", cameras.len()),
            ));
        };
        let Some(perspective) = &camera.perspective else {
            door.warn(format!(
                "{}: cameras[{index}]: is not a perspective one and skipped",
                door.name()
            ));
            return Ok(());
        };
        let eye = world_from_node.transform_point3(DVec3::ZERO);
        let look = world_from_node
            .transform_vector3(DVec3::NEG_Z)
            .normalize_or_zero();
        let up = world_from_node
            .transform_vector3(DVec3::Y)
            .normalize_or_zero();
        let made = Camera {
            eye: eye.as_vec3().to_array(),
            target: (eye + look).as_vec3().to_array(),
            up: up.as_vec3().to_array(),
            fov: perspective.yfov.to_degrees() as f32,
        };
        let is_sane = made.fov > 0.0
            && made.fov < 180.0
            && look.cross(up).length() > 1e-6
            && eye.as_vec3().is_finite()
            && made.eye != made.target;
        if is_sane {
            self.cameras.push(made);
        } else {
            door.warn(format!(
                "{}: cameras[{index}]: is degenerate and skipped",
                door.name()
            ));
        }
        Ok(())
    }
}

/// The rotation `q` stands for; a zero one, which stands for none, leaves things as they are.
fn unit(q: DQuat) -> DQuat {
    let length = q.length();
    if length > 0.0 && length.is_finite() {
        q / length
    } else {
        DQuat::IDENTITY
    }
}

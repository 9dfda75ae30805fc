//! What a scene of instances shows, and what it stores.

use super::Scene;
use std::collections::HashMap;
use std::sync::Arc;

/// What [`Scene::census`] counts. Of a scene of primitives, `shown` and `stored` are their number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Census {
    /// Primitives with every instance multiplied out; at most `u64::MAX`.
    pub shown: u64,
    /// Primitives as stored, each scene once.
    pub stored: u64,
    /// Different scenes, this one included.
    pub scenes: usize,
    /// Memory of their structures, each once, with these structures' copies of the primitives.
    pub bytes: usize,
}

impl Census {
    pub(super) fn of(scene: &Scene) -> Self {
        let mut census = Self::default();
        census.shown = census.add(scene, &mut HashMap::new());
        census
    }

    /// Counts what is stored, once for each scene; gives what `scene` shows. Nesting is bounded, so this may recurse.
    fn add(&mut self, scene: &Scene, shown: &mut HashMap<*const Scene, u64>) -> u64 {
        self.scenes += 1;
        self.bytes += scene.query.bytes();
        if scene.instances.is_empty() {
            self.stored += scene.len() as u64;
            return scene.len() as u64;
        }
        let mut sum = 0_u64;
        for instance in &scene.instances {
            let place = Arc::as_ptr(&instance.scene);
            let inside = match shown.get(&place) {
                Some(&known) => known,
                None => {
                    let count = self.add(&instance.scene, shown);
                    shown.insert(place, count);
                    count
                }
            };
            sum = sum.saturating_add(inside);
        }
        sum
    }
}

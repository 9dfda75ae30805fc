//! What JavaScript calls. Objects go over as JSON, numbers of pixels as typed arrays, errors as exceptions with one sentence.

use serde::Serialize;
use wasm_bindgen::prelude::*;

use crate::{Lab, lesson};

/// [`Lab`] for JavaScript.
#[wasm_bindgen(js_name = Lab)]
pub struct JsLab(Lab);

#[wasm_bindgen(js_class = Lab)]
impl JsLab {
    /// [`Lab::open`].
    #[wasm_bindgen(constructor)]
    pub fn open(name: &str, bytes: Option<Vec<u8>>) -> Result<Self, JsError> {
        Lab::open(name, bytes.as_deref())
            .map(Self)
            .map_err(exception)
    }

    /// [`Lab::seen`].
    pub fn seen(&self) -> Result<String, JsError> {
        json(&self.0.seen())
    }

    /// [`Lab::build`].
    pub fn build(&mut self, structure: &str, builder: &str) -> Result<String, JsError> {
        json(&self.0.build(structure, builder).map_err(exception)?)
    }

    /// [`Lab::rebuild`].
    pub fn rebuild(&mut self, number: usize) -> Result<(), JsError> {
        self.0.rebuild(number).map_err(exception)
    }

    /// [`Lab::look`].
    pub fn look(&mut self, width: u32, height: u32) -> Result<(), JsError> {
        self.0.look(width, height).map_err(exception)
    }

    /// [`Lab::nodes`].
    pub fn nodes(&self, number: usize, depth: u32) -> Result<Vec<f32>, JsError> {
        self.0.nodes(number, depth).map_err(exception)
    }

    /// [`Lab::picture`].
    pub fn picture(&mut self, width: u32, height: u32) -> Result<Vec<u8>, JsError> {
        self.0.picture(width, height).map_err(exception)
    }

    /// [`Lab::steps`].
    pub fn steps(&self, number: usize, limit: usize) -> Result<String, JsError> {
        json(&self.0.steps(number, limit).map_err(exception)?)
    }

    /// [`Lab::heat`].
    pub fn heat(&self, number: usize, y: u32, rows: u32) -> Result<Vec<u32>, JsError> {
        self.0.heat(number, y, rows).map_err(exception)
    }

    /// [`Lab::shoot`].
    pub fn shoot(&self, number: usize, y: u32, rows: u32) -> Result<String, JsError> {
        json(&self.0.shoot(number, y, rows).map_err(exception)?)
    }

    /// [`Lab::walk`].
    pub fn walk(&self, number: usize, x: u32, y: u32) -> Result<String, JsError> {
        json(&self.0.walk(number, x, y).map_err(exception)?)
    }

    /// [`crate::hits_hash`].
    pub fn hash(&self, number: usize, rays: u32, seed: u32) -> Result<String, JsError> {
        let scene = self.0.scene(number).map_err(exception)?;
        Ok(crate::hits_hash(scene, rays.into(), seed.into()))
    }
}

/// [`lesson::price`].
#[wasm_bindgen]
pub fn price(width: u32, height: u32, triangles: u32) -> Result<String, JsError> {
    json(&lesson::price(width, height, triangles))
}

/// [`lesson::test`]: nine numbers of corners, six of the ray.
#[wasm_bindgen]
pub fn test(numbers: &[f32]) -> Result<String, JsError> {
    let [a, b, c, origin, dir] = *numbers.as_chunks::<3>().0 else {
        return Err(JsError::new("a test takes fifteen numbers"));
    };
    json(&lesson::test([a, b, c], origin, dir).map_err(exception)?)
}

/// [`lesson::grid_walk`]: four numbers a wall, four of the ray.
#[wasm_bindgen]
pub fn grid_walk(walls: &[f32], columns: u32, ray: &[f32]) -> Result<String, JsError> {
    let [ox, oy, dx, dy] = *ray else {
        return Err(JsError::new("a ray from above takes four numbers"));
    };
    let walls = walls.as_chunks::<4>().0;
    json(&lesson::grid_walk(walls, columns, [ox, oy], [dx, dy]).map_err(exception)?)
}

/// [`lesson::volumes`]: four numbers a wall.
#[wasm_bindgen]
pub fn volumes(walls: &[f32], rays: u32, reach: f32, triangles: u32) -> Result<String, JsError> {
    let walls = walls.as_chunks::<4>().0;
    json(&lesson::volumes(walls, rays, reach, triangles).map_err(exception)?)
}

/// [`crate::heat_scale`].
#[wasm_bindgen]
pub fn heat_scale(counts: &[u32]) -> Result<String, JsError> {
    json(&crate::heat_scale(counts))
}

/// [`crate::heat_codes`].
#[wasm_bindgen]
pub fn heat_codes(counts: &[u32], top: f32, log: bool) -> Vec<u8> {
    crate::heat_codes(counts, top, log)
}

/// Names of the structures and builders.
#[wasm_bindgen]
pub fn names() -> Result<String, JsError> {
    json(&crate::structure_names())
}

fn json(answer: &impl Serialize) -> Result<String, JsError> {
    serde_json::to_string(answer).map_err(exception)
}

fn exception(error: impl std::fmt::Display) -> JsError {
    JsError::new(&error.to_string())
}

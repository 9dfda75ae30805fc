//! Small glTF files, made piece by piece.

use base64::Engine;

/// A document in the making: bytes, views and accessors of one buffer; the rest is given as JSON.
#[derive(Default)]
pub(crate) struct Tiny {
    pub(crate) bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Tiny {
    /// Appends bytes and a view of them; gives its index.
    pub(crate) fn view(&mut self, bytes: &[u8], more: &str) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let view = format!(
            r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{}{more}}}"#,
            bytes.len()
        );
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds an accessor as JSON, without braces; gives its index.
    pub(crate) fn accessor(&mut self, json: &str) -> usize {
        self.accessors.push(format!("{{{json}}}"));
        self.accessors.len() - 1
    }

    pub(crate) fn floats(&mut self, shape: &str, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, "");
        let width = ["SCALAR", "VEC2", "VEC3", "VEC4"]
            .iter()
            .position(|known| *known == shape)
            .unwrap()
            + 1;
        let count = numbers.len() / width;
        self.accessor(&format!(
            r#""bufferView":{view},"componentType":5126,"count":{count},"type":"{shape}""#
        ))
    }

    pub(crate) fn shorts(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, "");
        let count = indices.len();
        self.accessor(&format!(
            r#""bufferView":{view},"componentType":5123,"count":{count},"type":"SCALAR""#
        ))
    }

    fn json(&self, buffer: &str, rest: &str) -> String {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}{buffer}}}],"bufferViews":[{}],"accessors":[{}],{rest}}}"#,
            self.bytes.len(),
            self.views.join(","),
            self.accessors.join(",")
        )
    }

    /// As `.gltf` with a data URI. `rest` is JSON without its outer braces.
    pub(crate) fn gltf(&self, rest: &str) -> Vec<u8> {
        let data = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
        self.json(
            &format!(r#","uri":"data:application/octet-stream;base64,{data}""#),
            rest,
        )
        .into_bytes()
    }

    /// As `.glb`.
    pub(crate) fn glb(&self, rest: &str) -> Vec<u8> {
        let mut json = self.json("", rest).into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut binary = self.bytes.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let length = (28 + json.len() + binary.len()) as u32;
        let mut file = [&b"glTF\x02\0\0\0"[..], &length.to_le_bytes()].concat();
        for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
        file
    }
}

/// Accessor 0: five positions; 1: indices of two triangles; 2: normals; 3: texture coordinates.
pub(crate) fn two_triangles() -> Tiny {
    let mut tiny = Tiny::default();
    let positions = [
        0., 0., 0., 1., 0., 0., 1., 1.5, 0., 0., 1., 0.25, 7., 7., 7.,
    ];
    tiny.floats("VEC3", &positions);
    tiny.shorts(&[0, 1, 2, 0, 2, 3]);
    tiny.floats("VEC3", &[[0., 0., 1.]; 5].concat());
    tiny.floats("VEC2", &[[0.25, 0.75]; 5].concat());
    tiny
}

/// About all that the loader looks at.
pub(crate) fn everything() -> (Tiny, String) {
    let mut tiny = two_triangles();
    let keys = tiny.view(&[1, 0, 3, 0], "");
    let values = tiny.view(&[0; 24], "");
    let sparse = tiny.accessor(&format!(
        r#""bufferView":0,"componentType":5126,"count":5,"type":"VEC3","sparse":{{"count":2,"indices":{{"bufferView":{keys},"componentType":5123}},"values":{{"bufferView":{values}}}}}"#
    ));
    let strided = tiny.view(&[9; 40], r#","byteStride":8"#);
    let quantised = tiny.accessor(&format!(
        r#""bufferView":{strided},"componentType":5122,"normalized":true,"count":5,"type":"VEC3""#
    ));
    let moves = tiny.floats("VEC3", &[1., 2., 3., 4., 5., 6.]);
    let turns = tiny.floats("VEC4", &[0., 0., 0., 1., 1., 0., 0., 0.]);
    let rest = format!(
        r#""extensionsRequired":["KHR_mesh_quantization"],"scene":0,"scenes":[{{"nodes":[0,2]}}],
"nodes":[{{"mesh":0,"children":[1],"translation":[1,2,3]}},{{"mesh":1,"matrix":[1,0,0,0,0,1,0,0,0,0,-1,0,3,0,0,1],"children":[3]}},
{{"mesh":1,"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":{moves},"ROTATION":{turns}}}}}}}}},{{"camera":0,"rotation":[0,1,0,1]}}],
"meshes":[{{"name":"a","primitives":[{{"attributes":{{"POSITION":0,"NORMAL":2,"TEXCOORD_0":3}},"indices":1,"material":0}},{{"attributes":{{"POSITION":{sparse}}},"mode":5}}]}},
{{"primitives":[{{"attributes":{{"POSITION":{quantised}}},"mode":6,"material":1}},{{"attributes":{{"POSITION":0}},"mode":1}}]}}],
"materials":[{{"name":"m","pbrMetallicRoughness":{{"baseColorFactor":[1,0.5,0.25,1],"baseColorTexture":{{"index":0,"extensions":{{"KHR_texture_transform":{{"offset":[0.5,0],"rotation":0.25,"scale":[2,2]}}}}}},"metallicFactor":0.5}}}},
{{"emissiveFactor":[1,1,0],"extensions":{{"KHR_materials_emissive_strength":{{"emissiveStrength":4}}}}}}],
"textures":[{{"source":0}}],"images":[{{"bufferView":0,"mimeType":"image/png"}}],
"cameras":[{{"type":"perspective","perspective":{{"yfov":0.7,"znear":0.1}}}}]"#
    );
    (tiny, rest)
}

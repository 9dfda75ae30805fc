//! glTF by small files: what each feature gives, and what each lie is answered.

#[path = "support/tiny_gltf.rs"]
mod tiny_gltf;

use boxwood_scene::{Limits, Model, load_bytes};
use tiny_gltf::{Tiny, everything, two_triangles};

/// One mesh in one node.
const PLAIN: &str =
    r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"nodes":[{"mesh":0}]"#;

fn read(bytes: &[u8]) -> Model {
    load_bytes("a.gltf", Some("gltf"), bytes, Limits::default()).unwrap()
}

fn refusal(bytes: &[u8]) -> String {
    match load_bytes("a.gltf", Some("gltf"), bytes, Limits::default()) {
        Ok(model) => panic!("{} triangles were accepted", model.triangle_count()),
        Err(error) => error.to_string(),
    }
}

fn one_mesh(primitive: &str) -> String {
    format!(r#""meshes":[{{"primitives":[{{{primitive}}}]}}],"nodes":[{{"mesh":0}}]"#)
}

#[test]
fn text_and_binary_give_the_same() {
    let tiny = two_triangles();
    for bytes in [tiny.gltf(PLAIN), tiny.glb(PLAIN)] {
        let model = read(&bytes);
        assert_eq!(model.meshes[0].indices, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(model.meshes[0].positions[3], [0.0, 1.0, 0.25]);
        assert_eq!((model.triangle_count(), model.warnings.len()), (2, 0));
        assert!(
            load_bytes("no name", None, &bytes, Limits::default()).is_ok(),
            "known by its content"
        );
    }
    let with_bom = [&b"\xef\xbb\xbf"[..], &tiny.gltf(PLAIN)].concat();
    assert_eq!(read(&with_bom).triangle_count(), 2);
}

#[test]
fn all_features_together_give_what_they_should() {
    let (tiny, rest) = everything();
    let model = read(&tiny.glb(&rest));
    // Two triangles and a strip of five vertices; a fan of five.
    assert_eq!(model.unique_triangle_count(), 2 + 3 + 3);
    assert_eq!(
        model
            .instances
            .iter()
            .map(|instance| instance.mesh)
            .collect::<Vec<_>>(),
        [0, 1, 1, 1]
    );
    assert_eq!(model.materials.len(), 3, "a default one for the strip");
    assert_eq!(model.meshes[0].material_of, [0, 0, 2, 2, 2]);
    assert_eq!(model.meshes[0].normals.len(), 10);
    assert_eq!(model.meshes[0].normals[7], [0.0; 3]);
    assert_eq!(model.materials[1].emission, [4.0, 4.0, 0.0]);
    assert_eq!(model.materials[0].base_color, [1.0, 0.5, 0.25]);
    assert_eq!(model.cameras.len(), 1);
    // A broken picture and a primitive of lines.
    assert_eq!(model.warnings.len(), 2, "{:?}", model.warnings);
    assert_eq!(model.flatten().unwrap().indices.len(), 5 + 3 * 3);
}

#[test]
fn strips_turn_every_other_triangle_and_fans_keep_their_first_corner() {
    let mut tiny = Tiny::default();
    tiny.floats("VEC3", &(0..15).map(|x| x as f32).collect::<Vec<_>>());
    let strip = read(&tiny.gltf(&one_mesh(r#""attributes":{"POSITION":0},"mode":5"#)));
    assert_eq!(strip.meshes[0].indices, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    let fan = read(&tiny.gltf(&one_mesh(r#""attributes":{"POSITION":0},"mode":6"#)));
    assert_eq!(fan.meshes[0].indices, [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
    let points = read(&tiny.gltf(&one_mesh(r#""attributes":{"POSITION":0},"mode":0"#)));
    assert_eq!(points.triangle_count(), 0);
    assert!(
        points.warnings[0].contains("points are skipped"),
        "{:?}",
        points.warnings
    );
}

#[test]
fn quantised_strided_positions_are_scaled_as_the_extension_says() {
    let mut tiny = Tiny::default();
    // i16 x 3 every 8 bytes; the smallest number stands for -1 like its neighbour.
    let numbers: [i16; 12] = [32767, -32767, -32768, 77, 0, 1, 2, 77, 16384, 3, 4, 77];
    let view = tiny.view(
        &numbers.map(i16::to_le_bytes).concat(),
        r#","byteStride":8"#,
    );
    for normalized in [true, false] {
        tiny.accessor(&format!(
            r#""bufferView":{view},"componentType":5122,"normalized":{normalized},"count":3,"type":"VEC3""#
        ));
    }
    let positions = |accessor: usize| {
        read(&tiny.gltf(&one_mesh(&format!(
            r#""attributes":{{"POSITION":{accessor}}}"#
        ))))
        .meshes[0]
            .positions
            .clone()
    };
    assert_eq!(positions(0)[0], [1.0, -1.0, -1.0]);
    assert_eq!(positions(0)[2][0], 16384.0 / 32767.0);
    assert_eq!(positions(1)[0], [32767.0, -32767.0, -32768.0]);
}

#[test]
fn sparse_accessors_replace_elements_also_of_nothing() {
    let mut tiny = two_triangles();
    let keys = tiny.view(&[1, 4], "");
    let values = tiny.view(
        &[9.0f32, 8.0, 7.0, 6.0, 5.0, 4.0]
            .map(f32::to_le_bytes)
            .concat(),
        "",
    );
    let sparse = format!(
        r#""componentType":5126,"count":5,"type":"VEC3","sparse":{{"count":2,"indices":{{"bufferView":{keys},"componentType":5121}},"values":{{"bufferView":{values}}}}}"#
    );
    let over = tiny.accessor(&format!(r#""bufferView":0,{sparse}"#));
    let alone = tiny.accessor(&sparse);
    let positions = |accessor: usize| {
        let primitive = format!(r#""attributes":{{"POSITION":{accessor}}},"indices":1"#);
        read(&tiny.gltf(&one_mesh(&primitive))).meshes[0]
            .positions
            .clone()
    };
    assert_eq!(positions(over)[1..3], [[9.0, 8.0, 7.0], [1.0, 1.5, 0.0]]);
    assert_eq!(positions(alone)[1..3], [[9.0, 8.0, 7.0], [0.0; 3]]);
}

#[test]
fn nodes_multiply_down_the_tree() {
    let tiny = two_triangles();
    let rest = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
        "nodes":[{"children":[1],"translation":[10,0,0],"scale":[2,2,2]},{"mesh":0,"rotation":[0,0,1,1],"camera":0}],
        "cameras":[{"perspective":{"yfov":1.5707963267948966}}]"#;
    let model = read(&tiny.gltf(rest));
    // A quarter turn about z (not normalised in the file), then twice as large, then ten to the right.
    let flat = model.flatten().unwrap();
    let corner = flat.positions[1];
    assert!(
        (corner[0] - 10.0).abs() < 1e-6 && (corner[1] - 2.0).abs() < 1e-6,
        "{corner:?}"
    );
    let camera = model.cameras[0];
    assert_eq!(
        (camera.eye, camera.target, camera.fov),
        ([10.0, 0.0, 0.0], [10.0, 0.0, -1.0], 90.0)
    );
    assert!((camera.up[0] + 1.0).abs() < 1e-6, "{camera:?}");
}

#[test]
fn only_the_default_scene_is_shown_but_every_mesh_is_stored() {
    let tiny = two_triangles();
    let rest = format!(
        "{PLAIN}{}",
        r#","scene":1,"scenes":[{"nodes":[0]},{"nodes":[]}]"#
    );
    let model = read(&tiny.gltf(&rest));
    assert_eq!(
        (model.triangle_count(), model.unique_triangle_count()),
        (0, 2)
    );
}

#[test]
fn texture_coordinates_are_turned_up_and_transformed() {
    let tiny = two_triangles();
    let primitive = r#""attributes":{"POSITION":0,"TEXCOORD_0":3},"indices":1,"material":0"#;
    let uvs = |info: &str| {
        let materials =
            format!(r#","materials":[{{"pbrMetallicRoughness":{{{info}}}}}],"textures":[{{}}]"#);
        read(&tiny.gltf(&(one_mesh(primitive) + &materials))).meshes[0].uvs[0]
    };
    assert_eq!(uvs(""), [0.25, 0.25]);
    let transform = r#""baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.5,0.125],"scale":[2,1]}}}"#;
    assert_eq!(uvs(transform), [1.0, 0.125]);
}

#[test]
fn a_long_accessor_that_many_meshes_share_is_not_copied_for_each() {
    let mut tiny = Tiny::default();
    tiny.floats("VEC3", &vec![0.5; 3 * 9000]);
    for i in 0..3000_u16 {
        tiny.shorts(&[3 * i, 3 * i + 2, 3 * i + 1]);
    }
    let mesh = |i: usize| {
        format!(
            r#"{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":{}}}]}}"#,
            i + 1
        )
    };
    let meshes: Vec<_> = (0..3000).map(mesh).collect();
    let model = read(&tiny.gltf(&format!(
        r#""meshes":[{}],"nodes":[{{"mesh":7}}]"#,
        meshes.join(",")
    )));
    assert!(
        model
            .meshes
            .iter()
            .all(|mesh| mesh.positions.len() == 3 && mesh.indices == [[0, 2, 1]])
    );
}

#[test]
fn errors_name_the_place_and_the_numbers() {
    let mut tiny = two_triangles();
    let view = tiny.view(&[0; 72], "");
    let bad = |json: &str| {
        let mut tiny = two_triangles();
        tiny.view(&[0; 72], "");
        let accessor = tiny.accessor(json);
        refusal(&tiny.gltf(&one_mesh(&format!(
            r#""attributes":{{"POSITION":0}},"indices":{accessor}"#
        ))))
    };
    let indices = format!(r#""bufferView":{view},"type":"SCALAR","componentType":5123"#);
    assert_eq!(
        bad(&format!(r#"{indices},"count":3600"#)),
        "a.gltf: accessors[4]: 3600 indices need 7200 bytes, the buffer view has 72"
    );
    assert!(bad(&format!(r#"{indices},"count":36,"byteOffset":2"#)).contains("from 2 on"));
    assert!(
        bad(&format!(
            r#"{indices},"count":1,"byteOffset":18446744073709551615"#
        ))
        .contains("the buffer view has 72")
    );
    assert!(bad(&format!(r#"{indices},"count":18446744073709551615"#)).contains("more than 2^32"));
    assert!(
        bad(r#""type":"SCALAR","componentType":5123,"count":4000000000"#)
            .contains("without a buffer view")
    );
    assert!(
        bad(r#""bufferView":99,"type":"SCALAR","componentType":5123,"count":1"#)
            .contains("buffer view 99 of 5")
    );
    assert!(
        bad(r#""bufferView":0,"type":"VEC3","componentType":5123,"count":1"#)
            .contains("indices are SCALAR")
    );
    assert!(
        bad(r#""bufferView":0,"type":"SCALAR","componentType":5126,"count":1"#)
            .contains("component type 5126")
    );
    assert!(
        bad(r#""bufferView":0,"type":"SCALAR","componentType":7,"count":1"#)
            .contains("component type 7")
    );
    let error = refusal(&tiny.gltf(&one_mesh(r#""attributes":{"POSITION":0},"indices":77"#)));
    assert_eq!(
        error,
        "a.gltf: meshes[0].primitives[0]: refers to accessor 77 of 4"
    );
}

#[test]
fn an_index_beyond_the_vertices_is_refused() {
    let mut tiny = two_triangles();
    let indices = tiny.shorts(&[0, 1, 5]);
    let error = refusal(&tiny.gltf(&one_mesh(&format!(
        r#""attributes":{{"POSITION":0}},"indices":{indices}"#
    ))));
    assert_eq!(
        error,
        "a.gltf: accessors[4]: index 2 refers to vertex 5 of 5"
    );
}

#[test]
fn positions_that_are_not_finite_are_refused_and_normals_repaired() {
    let mut tiny = two_triangles();
    let bad = tiny.floats("VEC3", &[f32::NAN; 15]);
    let error = refusal(&tiny.gltf(&one_mesh(&format!(
        r#""attributes":{{"POSITION":{bad}}},"indices":1"#
    ))));
    assert!(
        error.starts_with("a.gltf: accessors[4]: position 0 is [NaN, NaN, NaN]"),
        "{error}"
    );
    let model = read(&tiny.gltf(&one_mesh(&format!(
        r#""attributes":{{"POSITION":0,"NORMAL":{bad}}},"indices":1"#
    ))));
    assert_eq!(model.meshes[0].normals, [[0.0; 3]; 5]);
    assert_eq!(model.warnings.len(), 1);
}

#[test]
fn node_graphs_that_are_no_trees_are_refused() {
    let nodes = |nodes: &str| {
        let mesh = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}]"#;
        two_triangles().gltf(&format!(r#"{mesh},"nodes":[{nodes}]"#))
    };
    assert!(refusal(&nodes(r#"{"children":[1]},{"children":[0]}"#)).contains("without cycles"));
    assert!(
        refusal(&nodes(r#"{"children":[1]},{"children":[1]}"#))
            .contains("nodes[1]: is reached twice")
    );
    let diamond = r#"{"children":[1,2]},{"children":[3]},{"children":[3]},{"mesh":0}"#;
    assert!(refusal(&nodes(diamond)).contains("nodes[3]: is reached twice"));
    assert!(refusal(&nodes(r#"{"children":[9]}"#)).contains("nodes[9]: does not exist"));
    assert!(refusal(&nodes(r#"{"mesh":3}"#)).contains("nodes[0]: refers to mesh 3 of 1"));
    assert!(
        refusal(&nodes(
            r#"{"mesh":0,"matrix":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}"#
        ))
        .contains("not affine")
    );
    assert!(refusal(&nodes(r#"{"mesh":0,"scale":[1e300,1,1]}"#)).contains("range of f32"));
    // Two paths at each of 40 levels: 2^40 visits, were shared children allowed.
    let ladder: Vec<_> = (0..40)
        .map(|i| format!(r#"{{"children":[{0},{0}]}}"#, i + 1))
        .collect();
    assert!(
        refusal(&nodes(&format!(r#"{},{{"mesh":0}}"#, ladder.join(",")))).contains("reached twice")
    );
    let chain: Vec<_> = (1..100_000)
        .map(|i| format!(r#"{{"children":[{i}]}}"#))
        .collect();
    assert!(refusal(&nodes(&format!("{},{{}}", chain.join(",")))).contains("deeper than 1024"));
}

#[test]
fn bombs_of_shared_data_are_refused_before_they_grow() {
    let mut tiny = Tiny::default();
    tiny.floats("VEC3", &vec![0.5; 3 * 60_000]);
    let primitives = vec![r#"{"attributes":{"POSITION":0}}"#; 20_000].join(",");
    let error = refusal(&tiny.glb(&format!(r#""meshes":[{{"primitives":[{primitives}]}}]"#)));
    assert!(error.contains("the same data again and again"), "{error}");

    let moves =
        r#"{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}}"#;
    let nodes = vec![moves; 80].join(",");
    let error = refusal(&tiny.glb(&format!(r#""meshes":[{{}}],"nodes":[{nodes}]"#)));
    assert!(error.contains("more than 4194304 instances"), "{error}");

    let nodes = "{},".repeat(4_194_304) + "{}";
    assert!(
        refusal(&tiny.gltf(&format!(r#""nodes":[{nodes}]"#)))
            .contains("a list of at most 4194304 items")
    );

    let deep = ["[".repeat(1_000_000), "]".repeat(1_000_000)].join("1");
    assert!(refusal(&tiny.gltf(&format!(r#""nodes":{deep}"#))).contains("line 1"));
    assert_eq!(
        read(&tiny.gltf(&format!(r#""extras":{deep}"#))).triangle_count(),
        0,
        "skipped without recursion"
    );
}

#[test]
fn unknown_required_extensions_are_refused_by_name() {
    let with =
        |list: &str| two_triangles().gltf(&format!(r#"{PLAIN},"extensionsRequired":[{list}]"#));
    let error = refusal(&with(
        r#""KHR_mesh_quantization","EXT_meshopt_compression""#,
    ));
    assert!(
        error.contains("EXT_meshopt_compression") && error.contains("without compression"),
        "{error}"
    );
    assert!(refusal(&with(r#""KHR_draco_mesh_compression""#)).contains("without compression"));
    assert!(
        refusal(&with(r#""ACME_teapots""#))
            .contains("the extension ACME_teapots is required and not known")
    );
    assert_eq!(read(&with(r#""KHR_mesh_quantization""#)).warnings.len(), 0);
    assert_eq!(read(&with(r#""KHR_materials_unlit""#)).warnings.len(), 1);
    let draco = r#""attributes":{"POSITION":4},"extensions":{"KHR_draco_mesh_compression":{"bufferView":0}}"#;
    let mut tiny = two_triangles();
    tiny.accessor(r#""componentType":5126,"count":3,"type":"VEC3""#);
    assert!(refusal(&tiny.gltf(&one_mesh(draco))).contains("compressed by KHR_draco"));
}

#[test]
fn buffers_must_be_as_long_as_they_say_and_lie_beside_the_file() {
    let with = |buffer: &str| {
        refusal(format!(r#"{{"asset":{{"version":"2.0"}},"buffers":[{{{buffer}}}],"bufferViews":[{{"byteLength":3}}],
            "accessors":[{{"bufferView":0,"componentType":5121,"type":"VEC3","count":1}}],{PLAIN}}}"#).as_bytes())
    };
    let error = with(r#""byteLength":3,"uri":"data:;base64,AAA=""#);
    assert_eq!(
        error,
        "a.gltf: buffers[0]: is said to have 3 bytes and has 2"
    );
    assert!(with(r#""byteLength":3,"uri":"../../etc/passwd""#).contains("../../etc/passwd"));
    assert!(with(r#""byteLength":3,"uri":"%ff%fe""#).contains("buffers[0]"));
    assert!(with(r#""byteLength":3"#).contains("buffer 0 has no data"));
}

#[test]
fn other_files_are_told_what_they_are_not() {
    assert!(refusal(b"").contains("JSON"));
    assert!(refusal(b"{}").contains("this is not a glTF file"));
    assert!(refusal(br#"{"asset":{"version":"1.0"}}"#).contains("version \"1.0\" is not 2.0"));
    assert!(
        refusal(br#"{"asset":{"version":"2.0"},"nodes":[{"mesh":-1}]}"#).contains("line 1 column")
    );
    assert!(
        refusal(br#"{"asset":{"version":"2.0"},"nodes":[{"scale":[1e999,1,1]}]}"#)
            .contains("out of range")
    );
}

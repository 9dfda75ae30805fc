//! Seeds of the mutation test and of the fuzzers.

/// Small files of each format, with its name, that hold about everything a parser looks at.
pub(crate) fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let obj = b"mtllib a.mtl\no a\nv 0 0 0\nv 1 0 0 1\nv 1 1 0\nv 0.5 0.25 -1e2\nvt 0 1\nvn 0 0 1\nusemtl b\n\
                f 1/1/1 2//1 3/1 4\nf -1 -2 \\\n-3\nusemtl c\nf 1 2 3 4 1 2 3\nl 1 2\n";
    let elements = "comment c\nelement vertex 4\nproperty float x\nproperty double y\nproperty short z\nproperty float nx\n\
                    property float ny\nproperty float nz\nelement other 2\nproperty list uchar ushort a\nelement face 2\n\
                    property uchar b\nproperty list uchar int vertex_indices\nelement tristrips 1\n\
                    property list int int vertex_indices\nend_header\n";
    let ascii = format!(
        "ply\nformat ascii 1.0\n{elements}0 0 0 0 0 1\n1 0 0 0 0 1\n1 1.5 0 0 0 1\n0 1e1 0 0 0 1\n0\n2 1 2\n\
         7 3 0 1 2\n7 4 0 1 2 3\n8 0 1 2 3 -1 1 2 3\n"
    );
    let binary = |big: bool| {
        let format = if big {
            "binary_big_endian"
        } else {
            "binary_little_endian"
        };
        let mut bytes = format!("ply\nformat {format} 1.0\n{elements}").into_bytes();
        let mut put = |mut number: Vec<u8>| {
            if big {
                number.reverse();
            }
            bytes.extend(number);
        };
        for i in 0..4i16 {
            put(f32::from(i).to_le_bytes().to_vec());
            put(f64::from(i * i).to_le_bytes().to_vec());
            put(i.to_le_bytes().to_vec());
            (0..3).for_each(|_| put(0.5f32.to_le_bytes().to_vec()));
        }
        [0, 1].into_iter().for_each(|byte| put(vec![byte]));
        put(7u16.to_le_bytes().to_vec());
        for corners in [&[0i32, 1, 2][..], &[3, 2, 1, 0]] {
            put(vec![9]);
            put(vec![corners.len() as u8]);
            corners
                .iter()
                .for_each(|corner| put(corner.to_le_bytes().to_vec()));
        }
        [5i32, 0, 1, 2, -1, 3]
            .into_iter()
            .for_each(|number| put(number.to_le_bytes().to_vec()));
        bytes
    };
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1.5e0 0\nendloop\nendfacet\n";
    let mut stl = vec![b' '; 80];
    stl.extend(3u32.to_le_bytes());
    stl.extend((0..150).map(|i| i as u8));
    // One triangle: three positions and three 16-bit indices as a data URI, shown by two nodes.
    let gltf = br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"mesh":0,"children":[1],"translation":[1,2,3.5]},{"mesh":0,"rotation":[0,0,0,1],"scale":[1,-1,2]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]},"emissiveFactor":[0,0,1]}],
"buffers":[{"byteLength":42,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA"}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]}"#;
    vec![
        ("obj", obj.to_vec()),
        ("ply", ascii.into_bytes()),
        ("ply", binary(false)),
        ("ply", binary(true)),
        (
            "stl",
            format!("solid a\n{facet}{facet}endsolid a\n").into_bytes(),
        ),
        ("stl", stl),
        ("gltf", gltf.to_vec()),
    ]
}

/// The same of saved scenes, which no mutation survives: their fuzzer seals them anew.
#[allow(dead_code, reason = "for the fuzzers alone")]
pub(crate) fn sealed_seeds() -> Vec<(&'static str, Vec<u8>)> {
    let options = [
        boxwood::BuildOptions::default(),
        boxwood::BuildOptions::high(),
    ];
    options.map(|options| ("bwx", saved(options))).into()
}

/// Forty triangles in two meshes, slivers among them, with the notes that loaders look at.
fn saved(options: boxwood::BuildOptions) -> Vec<u8> {
    let corner = |i: u32| {
        let (x, y) = ((i % 7) as f32, (i / 7) as f32);
        [x, 1.5 * y + 0.01 * x, (i % 3) as f32 * 0.25]
    };
    let positions: Vec<[f32; 3]> = (0..42).map(corner).collect();
    let indices: Vec<[u32; 3]> = (0..40).map(|i| [i, i + 2, (i * 5 + 1) % 42]).collect();
    let options = boxwood::BuildOptions {
        split_budget: options.split_budget.max(1.0),
        ..options
    };
    let builder = boxwood::Scene::builder()
        .mesh(&positions, &indices[..30])
        .mesh(&positions, &indices[30..]);
    let scene = builder.options(options).build().expect("a small scene");
    let mut bytes = Vec::new();
    let corners = indices.as_flattened().iter();
    let noted = scene
        .with_note("units", "mm")
        .with_note(
            "origin",
            [1.5_f64, 0.0, -2.0].map(f64::to_le_bytes).as_flattened(),
        )
        .with_note("vertices", 42_u64.to_le_bytes().repeat(2))
        .with_note(
            "indices",
            corners.flat_map(|i| i.to_le_bytes()).collect::<Vec<_>>(),
        );
    noted.save(&mut bytes).expect("a vector takes all");
    bytes
}

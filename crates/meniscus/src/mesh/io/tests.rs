use super::*;

const PLY: &str = "ply\nformat ascii 1.0\ncomment a square\nelement vertex 4\nproperty float x\n\
    property double y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
    element face 1\nproperty list uchar int vertex_indices\nelement edge 1\nproperty int a\nend_header\n\
    0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 2\n0 1 0 0 0 1\n4 0 1 2 3\n7\n";
const OBJ: &str = "# a square\nmtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\n\
    usemtl x\nf 1//1 2//1 3//1 4//1\n";

fn gltf() -> String {
    let mut data: Vec<u8> = Vec::new();
    for place in [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
        data.extend(place.iter().flat_map(|x| x.to_le_bytes()));
    }
    data.extend([0_u16, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
    use base64::Engine;
    let encoded = base64::engine::general_purpose::STANDARD.encode(&data);
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\
         \"nodes\":[{{\"mesh\":0,\"translation\":[0,0,5],\"scale\":[2,2,-2]}}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}},\"indices\":1}}]}}],\
         \"buffers\":[{{\"byteLength\":42,\"uri\":\"data:application/octet-stream;base64,{encoded}\"}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}},{{\"buffer\":0,\"byteOffset\":36,\"byteLength\":6}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\
         \"min\":[0,0,0],\"max\":[1,1,0]}},\
         {{\"bufferView\":1,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"}}]}}"
    )
}

fn parsed(bytes: &[u8]) -> Result<MeshFile, Problem> {
    let format = MeshFormat::detect(bytes).unwrap_or_else(|| panic!("not detected"));
    parse(format, bytes, Path::new(""))
}

fn fails(bytes: &[u8], parts: &[&str]) {
    let problem = parsed(bytes).unwrap_err();
    let text = format!("{} {}", problem.text, problem.help.unwrap_or_default());
    for part in parts {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn a_square_is_read_from_every_format() {
    for (text, format) in [(PLY, MeshFormat::Ply), (OBJ, MeshFormat::Obj)] {
        let file = parsed(text.as_bytes()).unwrap();
        assert_eq!(file.format, format);
        let places: Vec<_> = file.mesh.positions.iter().map(|p| p.to_array()).collect();
        let square = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ];
        assert_eq!(places, square);
        assert_eq!(file.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(file.mesh.normals, [Vec3::Z; 4]);
        assert!(file.warnings.is_empty());
    }
}

#[test]
fn nodes_place_and_mirror_the_triangles_of_gltf() {
    let file = parsed(gltf().as_bytes()).unwrap();
    assert_eq!(file.format, MeshFormat::Gltf);
    let places: Vec<_> = file.mesh.positions.iter().map(|p| p.to_array()).collect();
    assert_eq!(places, [[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [0.0, 2.0, 5.0]]);
    assert_eq!(file.mesh.triangles, [[0, 2, 1]]);
    assert!(file.mesh.normals.is_empty());
}

#[test]
fn what_is_wrong_is_said() {
    let ply = |from: &str, to: &str| PLY.replace(from, to).into_bytes();
    fails(
        &ply("face 1", "face 4000000000000"),
        &["4000000000000", "bytes follow"],
    );
    fails(
        &ply("4 0 1 2 3", "4 0 1 2 9"),
        &["face 0", "vertex 9", "there are 4"],
    );
    fails(&ply("4 0 1 2 3", "4 0 1 2 -1"), &["face 0", "there are 4"]);
    fails(
        &ply("1 1 0 0", "1 nan 0 0"),
        &["Line 18", "'1 nan 0 0 0 2 '"],
    );
    fails(
        b"v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n",
        &["vertex 2", "NaN", "face 0"],
    );
    fails(&ply("double y", "double b"), &["no property y"]);
    fails(
        &ply("4 0 1 2 3", "3 0 1 1"),
        &["all of its 1 triangles are degenerate"],
    );
    fails(
        b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
          property float z\nend_header\n0 0 0\n",
        &["no faces, 1 vertices only", "[[surface]]"],
    );
    fails(b"v 0 0 0\nv 1 0 0\nv 0 x 0\nf 1 2 3\n", &["line 3"]);
    fails(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n", &["out of bounds"]);
    fails(
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 1 0\nf 1//-11 2//1 3//1\n",
        &["line 5", "1//-11", "out of bounds"],
    );
    fails(
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/9223372036854775807 2/1 3/1\n",
        &["line 5", "out of bounds"],
    );
    fails(
        gltf()
            .replace("\"POSITION\":0", "\"POSITION\":7")
            .as_bytes(),
        &["accessor 7, there are 2"],
    );
    fails(
        gltf()
            .replace("\"byteLength\":42", "\"byteLength\":43")
            .as_bytes(),
        &["42 bytes, 43"],
    );
    fails(
        gltf()
            .replace(
                "\"count\":3,\"type\":\"VEC3\"",
                "\"count\":400,\"type\":\"VEC3\"",
            )
            .as_bytes(),
        &["accessor 0", "beyond its data"],
    );
    fails(
        b"glTF\x02\0\0\0\x0b\0\0\0{}",
        &["promises 11 bytes, there are 14"],
    );
    fails(b"glTF", &["promises 0 bytes, there are 4"]);
    assert_eq!(MeshFormat::detect(b"hello"), None);
    assert_eq!(MeshFormat::detect(b""), None);
}

#[test]
fn damaged_files_do_not_panic() {
    for text in [PLY.to_owned(), OBJ.to_owned(), gltf()] {
        let bytes = text.as_bytes();
        let try_it = |bytes: &[u8]| {
            if let Some(format) = MeshFormat::detect(bytes) {
                let _ = parse(format, bytes, Path::new(""));
            }
        };
        for length in 0..bytes.len() {
            try_it(&bytes[..length]);
        }
        let mut damaged = bytes.to_vec();
        for i in (0..bytes.len()).step_by(2) {
            for byte in [0, 0xff, b'9', b'-', b'"', b' ', bytes[i] ^ 1] {
                damaged[i] = byte;
                try_it(&damaged);
            }
            damaged[i] = bytes[i];
        }
    }
}

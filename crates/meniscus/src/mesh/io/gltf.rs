//! glTF 2.0 through crate `gltf`: the triangles of the default scene where its nodes put them.
//! Skins, morphs, cameras, lights and materials are left aside.

use super::{Parts, Problem};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DMat3, DMat4, DVec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::Source;
use gltf::mesh::Mode;
use gltf::{Accessor, Gltf, Node, Primitive};
use std::path::Path;

/// Deepest tree of nodes that is followed.
const MAX_DEPTH: usize = 256;
/// Most corners over all nodes: a small file may place its meshes a million times.
const MAX_CORNERS: usize = 1 << 28;

pub(super) fn detect(bytes: &[u8]) -> bool {
    if bytes.starts_with(b"glTF") {
        return true;
    }
    let text = bytes.trim_ascii_start();
    let start = &text[..text.len().min(1 << 16)];
    text.starts_with(b"{") && start.windows(7).any(|word| word == b"\"asset\"")
}

pub(super) fn read(bytes: &[u8], folder: &Path) -> Result<Parts, Problem> {
    check_container(bytes)?;
    let wrong = |error: gltf::Error| Problem::new(error.to_string());
    // The crate's own validation looks up accessors before it has checked that they are there.
    check_accessors(&Gltf::from_slice_without_validation(bytes).map_err(wrong)?)?;
    let gltf = Gltf::from_slice(bytes).map_err(wrong)?;
    let mut buffers = Vec::new();
    for buffer in gltf.buffers() {
        let data = match buffer.source() {
            Source::Bin => gltf
                .blob
                .clone()
                .ok_or_else(|| Problem::new("the binary part that it refers to is missing"))?,
            Source::Uri(uri) => load(uri, folder)?,
        };
        if data.len() < buffer.length() {
            return Err(Problem::new(format!(
                "buffer {} holds {} bytes, {} are promised",
                buffer.index(),
                data.len(),
                buffer.length()
            ))
            .with_help("the file is cut short"));
        }
        buffers.push(data);
    }
    let mut reader = Reader {
        buffers,
        parts: Parts::default(),
        have_normals: true,
        skipped: 0,
    };
    let Some(scene) = gltf.default_scene().or_else(|| gltf.scenes().next()) else {
        return Err(Problem::new("it has no scene"));
    };
    for node in scene.nodes() {
        reader.node(&node, DMat4::IDENTITY, 0)?;
    }
    let Reader {
        mut parts,
        have_normals,
        skipped,
        ..
    } = reader;
    if !have_normals {
        parts.normals.clear();
    }
    if skipped > 0 {
        let problem = format!("{skipped} parts are points or lines and were left out");
        parts.warnings.push(problem);
    }
    Ok(parts)
}

/// Whether a binary file is as long as its header says; the crate takes the header's own length off
/// unseen.
fn check_container(bytes: &[u8]) -> Result<(), Problem> {
    const HEADER: u32 = 12;
    let Some(header) = bytes.strip_prefix(b"glTF") else {
        return Ok(());
    };
    let length = match header {
        [_, _, _, _, a, b, c, d, ..] => u32::from_le_bytes([*a, *b, *c, *d]),
        _ => 0,
    };
    if length < HEADER || length as usize > bytes.len() {
        let problem = format!(
            "its header promises {length} bytes, there are {}",
            bytes.len()
        );
        return Err(Problem::new(problem).with_help("the file is cut short or damaged"));
    }
    Ok(())
}

/// Whether every accessor that a mesh names exists.
fn check_accessors(gltf: &Gltf) -> Result<(), Problem> {
    let root = gltf.as_json();
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let named = primitives.flat_map(|primitive| {
        let attributes = primitive.attributes.values();
        attributes
            .chain(&primitive.indices)
            .map(|index| index.value())
    });
    match named.max() {
        Some(largest) if largest >= root.accessors.len() => Err(Problem::new(format!(
            "a mesh refers to accessor {largest}, there are {}",
            root.accessors.len()
        ))),
        _ => Ok(()),
    }
}

/// The bytes behind a URI: data in base64, or a file beside this one.
fn load(uri: &str, folder: &Path) -> Result<Vec<u8>, Problem> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
        return encoded
            .and_then(|encoded| STANDARD.decode(encoded).ok())
            .ok_or_else(|| Problem::new("a buffer is no base64 data"));
    }
    if uri.contains("://") {
        return Err(
            Problem::new(format!("the buffer {uri} is not on this machine"))
                .with_help("export with the data inside, as .glb"),
        );
    }
    let path = folder.join(uri.replace("%20", " "));
    std::fs::read(&path).map_err(|error| {
        Problem::new(format!(
            "cannot read its buffer {}: {error}",
            path.display()
        ))
    })
}

struct Reader {
    buffers: Vec<Vec<u8>>,
    parts: Parts,
    have_normals: bool,
    /// Points and lines.
    skipped: usize,
}

impl Reader {
    fn node(&mut self, node: &Node<'_>, parent: DMat4, depth: usize) -> Result<(), Problem> {
        if depth > MAX_DEPTH {
            return Err(Problem::new(format!(
                "its nodes are nested more than {MAX_DEPTH} deep"
            )));
        }
        let columns = node
            .transform()
            .matrix()
            .map(|column| column.map(f64::from));
        let world = parent * DMat4::from_cols_array_2d(&columns);
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                self.primitive(&primitive, world)?;
            }
        }
        for child in node.children() {
            self.node(&child, world, depth + 1)?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive<'_>, world: DMat4) -> Result<(), Problem> {
        let mode = primitive.mode();
        if !matches!(
            mode,
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
        ) {
            self.skipped += 1;
            return Ok(());
        }
        let compressed = "it may be compressed (Draco, meshopt): export it without compression";
        let positions = primitive
            .get(&gltf::Semantic::Positions)
            .ok_or_else(|| Problem::new("a part of it has no positions").with_help(compressed))?;
        self.check(&positions, Dimensions::Vec3, &[DataType::F32])?;
        let normals = primitive.get(&gltf::Semantic::Normals);
        if let Some(normals) = &normals {
            self.check(normals, Dimensions::Vec3, &[DataType::F32])?;
        }
        if let Some(indices) = primitive.indices() {
            let types = [DataType::U8, DataType::U16, DataType::U32];
            self.check(&indices, Dimensions::Scalar, &types)?;
        }
        let buffers = &self.buffers;
        let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
        let first = self.parts.positions.len() as u64;
        let unreadable =
            || Problem::new("positions of a part cannot be read").with_help(compressed);
        let places = reader.read_positions().ok_or_else(unreadable)?;
        self.parts.positions.extend(
            places.map(|place| world.transform_point3(DVec3::from_array(place.map(f64::from)))),
        );
        let count = self.parts.positions.len() as u64 - first;
        let normal_matrix = DMat3::from_mat4(world).inverse().transpose();
        match reader.read_normals() {
            Some(normals) if normals.len() as u64 == count => {
                self.parts.normals.extend(normals.map(|normal| {
                    let normal = DVec3::from_array(normal.map(f64::from));
                    (normal_matrix * normal).normalize_or_zero().as_vec3()
                }));
            }
            _ => self.have_normals = false,
        }
        let corners: Vec<u64> = match reader.read_indices() {
            Some(indices) => indices.into_u32().map(u64::from).collect(),
            None => (0..count).collect(),
        };
        if self.parts.corners.len() + 3 * corners.len() > MAX_CORNERS {
            return Err(Problem::new(
                "its nodes place more than 89 million triangles",
            ));
        }
        // A transform that mirrors turns the faces inside out.
        let is_mirrored = world.determinant() < 0.0;
        let mut triangle = |a: u64, b: u64, c: u64| {
            let [b, c] = if is_mirrored { [c, b] } else { [b, c] };
            // An index beyond this part must not reach into the next one.
            let index = |k: u64| if k < count { first + k } else { u64::MAX };
            self.parts.corners.extend([a, b, c].map(index));
            self.parts.sizes.push(3);
        };
        match mode {
            Mode::TriangleStrip => {
                for (k, window) in corners.windows(3).enumerate() {
                    let [b, c] = if k % 2 == 0 { [1, 2] } else { [2, 1] };
                    triangle(window[0], window[b], window[c]);
                }
            }
            Mode::TriangleFan => {
                for window in corners.windows(2).skip(1) {
                    triangle(corners[0], window[0], window[1]);
                }
            }
            _ => {
                for corner in corners.as_chunks::<3>().0 {
                    triangle(corner[0], corner[1], corner[2]);
                }
            }
        }
        Ok(())
    }

    /// Whether the numbers of an accessor lie within its view and that within its buffer: the crate
    /// does not ask everywhere.
    fn check(
        &self,
        accessor: &Accessor<'_>,
        dimensions: Dimensions,
        types: &[DataType],
    ) -> Result<(), Problem> {
        let index = accessor.index();
        let wrong = |what: &str| Problem::new(format!("accessor {index} {what}"));
        if accessor.dimensions() != dimensions || !types.contains(&accessor.data_type()) {
            return Err(wrong("has numbers of the wrong type"));
        }
        if accessor.sparse().is_some() {
            return Err(wrong("is sparse, which is not supported"));
        }
        let view = accessor.view().ok_or_else(|| wrong("has no data"))?;
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        let end = stride
            .checked_mul(accessor.count().saturating_sub(1))
            .and_then(|length| length.checked_add(size)?.checked_add(accessor.offset()));
        let view_end = view.offset().checked_add(view.length());
        let length = self.buffers.get(view.buffer().index()).map_or(0, Vec::len);
        let fits = end.is_some_and(|end| end <= view.length())
            && view_end.is_some_and(|end| end <= length)
            && stride >= size
            && accessor.count() > 0;
        if fits {
            Ok(())
        } else {
            Err(wrong("reaches beyond its data").with_help("the file is damaged"))
        }
    }
}

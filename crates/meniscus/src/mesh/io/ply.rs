//! PLY with faces through crate `ply-rs-bw`; vertex colours are left aside.

use super::{Parts, Problem};
use glam::{DVec3, Vec3};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};
use std::path::Path;

pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r")
}

/// What we take of a vertex.
struct Vertex {
    position: DVec3,
    normal: Vec3,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self {
            position: DVec3::NAN,
            normal: Vec3::ZERO,
        }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let value = match property {
            Property::Char(value) => f64::from(value),
            Property::UChar(value) => f64::from(value),
            Property::Short(value) => f64::from(value),
            Property::UShort(value) => f64::from(value),
            Property::Int(value) => f64::from(value),
            Property::UInt(value) => f64::from(value),
            Property::Float(value) => f64::from(value),
            Property::Double(value) => value,
            _ => return PropertyAccessResult::Ignored,
        };
        match name {
            "x" => self.position.x = value,
            "y" => self.position.y = value,
            "z" => self.position.z = value,
            "nx" => self.normal.x = value as f32,
            "ny" => self.normal.y = value as f32,
            "nz" => self.normal.z = value as f32,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// What we take of a face: its corners. A negative one becomes an index that cannot exist.
struct Face {
    corners: Vec<u64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self {
            corners: Vec::new(),
        }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !["vertex_indices", "vertex_index"].contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        fn indices<T: TryInto<u64>>(list: Vec<T>) -> Vec<u64> {
            let index = |value: T| value.try_into().unwrap_or(u64::MAX);
            list.into_iter().map(index).collect()
        }
        self.corners = match property {
            Property::ListChar(list) => indices(list),
            Property::ListUChar(list) => indices(list),
            Property::ListShort(list) => indices(list),
            Property::ListUShort(list) => indices(list),
            Property::ListInt(list) => indices(list),
            Property::ListUInt(list) => indices(list),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

pub(super) fn read(bytes: &[u8], _folder: &Path) -> Result<Parts, Problem> {
    let problem = |error: ply_rs_bw::parser::ParseError| {
        // The crate's messages go over several lines.
        let text = error.to_string();
        let words: Vec<&str> = text.split_whitespace().collect();
        Problem::new(words.join(" "))
    };
    let mut reader = Reader::new(bytes);
    let (vertices, faces) = (Parser::<Vertex>::new(), Parser::<Face>::new());
    let header = vertices.read_header(&mut reader).map_err(problem)?;
    let mut parts = Parts::default();
    let mut has_normals = false;
    for element in header.elements.values() {
        check_size(element, header.encoding, reader.get_ref().len())?;
        match element.name.as_str() {
            "vertex" => {
                for axis in ["x", "y", "z"] {
                    if !element.properties.contains_key(axis) {
                        return Err(Problem::new(format!(
                            "its vertices have no property {axis}"
                        )));
                    }
                }
                has_normals = element.properties.contains_key("nx");
                let read = vertices.read_payload_for_element(&mut reader, element, &header);
                for vertex in read.map_err(problem)? {
                    parts.positions.push(vertex.position);
                    parts.normals.push(vertex.normal);
                }
            }
            "face" => {
                let read = faces.read_payload_for_element(&mut reader, element, &header);
                for face in read.map_err(problem)? {
                    parts.sizes.push(face.corners.len() as u32);
                    parts.corners.extend(face.corners);
                }
            }
            // Elements that we do not know are read over.
            _ => {
                faces
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(problem)?;
            }
        }
    }
    if !has_normals {
        parts.normals.clear();
    }
    Ok(parts)
}

/// Holds the header's count against the bytes that are there before anything is allocated by it.
fn check_size(element: &ElementDef, encoding: Encoding, rest: usize) -> Result<(), Problem> {
    let least: usize = match encoding {
        // A digit and what parts it from the next.
        Encoding::Ascii => 2 * element.properties.len(),
        _ => element
            .properties
            .values()
            .map(|p| least_size(&p.data_type))
            .sum(),
    };
    let count = element.count;
    // The last line of a text may lack its end.
    if least.max(1).saturating_mul(count) > rest.saturating_add(1) {
        let name = &element.name;
        return Err(Problem::new(format!(
            "the header promises {count} elements `{name}`, but only {rest} bytes follow"
        ))
        .with_help("the file is cut short or its header is wrong"));
    }
    Ok(())
}

fn least_size(kind: &PropertyType) -> usize {
    let size = |scalar: &ScalarType| match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    match kind {
        PropertyType::Scalar(scalar) => size(scalar),
        PropertyType::List(count, _) => size(count),
    }
}

//! Wavefront OBJ through crate `tobj`; materials and texture coordinates are left aside.

use super::{Parts, Problem};
use glam::{DVec3, Vec3};
use std::io::{BufRead, Read};
use std::path::Path;
use tobj::LoadOptions;

/// Whether the first statements are OBJ's, with a vertex among them.
pub(super) fn detect(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1 << 16)];
    for line in start.split(|&byte| byte == b'\n') {
        let mut words = line
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => return words.count() >= 3,
            None | Some(b"mtllib" | b"usemtl" | b"o" | b"g" | b"s" | b"vn" | b"vt") => {}
            Some(word) if word.starts_with(b"#") => {}
            Some(_) => return false,
        }
    }
    false
}

/// Hands out one line at a time and counts, since tobj's errors know no place.
struct CountedLines<'a> {
    rest: &'a [u8],
    lines: usize,
}

impl Read for CountedLines<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let count = self.fill_buf()?.len().min(out.len());
        out[..count].copy_from_slice(&self.rest[..count]);
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for CountedLines<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        let end = self.rest.iter().position(|&byte| byte == b'\n');
        Ok(&self.rest[..end.map_or(self.rest.len(), |end| end + 1)])
    }

    fn consume(&mut self, count: usize) {
        let (passed, rest) = self.rest.split_at(count.min(self.rest.len()));
        self.lines += usize::from(passed.ends_with(b"\n") || rest.is_empty() && !passed.is_empty());
        self.rest = rest;
    }
}

/// Refuses indices that cannot be any vertex's: tobj multiplies them before it looks at their size.
fn check_indices(bytes: &[u8]) -> Result<(), Problem> {
    // Positions, texture coordinates and normals so far, in the order of a corner's indices.
    let mut counts = [0_i64; 3];
    for (line, text) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let mut words = text
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => counts[0] += 1,
            Some(b"vt") => counts[1] += 1,
            Some(b"vn") => counts[2] += 1,
            Some(b"f" | b"l" | b"p") => {
                for corner in words {
                    let indices = corner.split(|&byte| byte == b'/');
                    for (index, count) in indices.zip(counts) {
                        let number = str::from_utf8(index)
                            .ok()
                            .and_then(|i| i.parse::<i64>().ok());
                        // Those from the start may come later in the file, but not without a byte each.
                        if number.is_some_and(|i| i < -count || i > bytes.len() as i64) {
                            let corner = String::from_utf8_lossy(corner);
                            return Err(Problem::new(format!(
                                "line {}: corner {corner} is out of bounds",
                                line + 1
                            ))
                            .with_help(
                                "negative indices count back from the line that they stand in",
                            ));
                        }
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

pub(super) fn read(bytes: &[u8], _folder: &Path) -> Result<Parts, Problem> {
    check_indices(bytes)?;
    let options = LoadOptions {
        single_index: true,
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
    };
    let mut lines = CountedLines {
        rest: bytes,
        lines: 0,
    };
    let no_materials = |_: &Path| Ok((Vec::new(), Default::default()));
    let (models, _) = tobj::load_obj_buf(&mut lines, &options, no_materials).map_err(|error| {
        Problem::new(format!("line {}: {error}", lines.lines))
            .with_help("an index out of bounds is told at the end of its object")
    })?;
    let mut parts = Parts::default();
    let have_normals = models
        .iter()
        .all(|model| model.mesh.normals.len() == model.mesh.positions.len());
    for model in models {
        let mesh = model.mesh;
        let first = parts.positions.len() as u64;
        let (positions, _) = mesh.positions.as_chunks::<3>();
        parts
            .positions
            .extend(positions.iter().map(|&place| DVec3::from_array(place)));
        if have_normals {
            let (normals, _) = mesh.normals.as_chunks::<3>();
            parts.normals.extend(
                normals
                    .iter()
                    .map(|n| Vec3::from_array(n.map(|x| x as f32))),
            );
        }
        let (triangles, _) = mesh.indices.as_chunks::<3>();
        parts.sizes.extend(triangles.iter().map(|_| 3));
        let corners = triangles.as_flattened().iter();
        parts
            .corners
            .extend(corners.map(|&index| first + u64::from(index)));
    }
    Ok(parts)
}

//! Content that we know but do not read as particles, and words for content that nobody knows.

use super::text::{float, lines, words};
use super::{Format, ParseError, Place};

/// A format that is recognised and refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Foreign {
    /// What the file is.
    pub(super) name: &'static str,
    /// Whether it holds particles, so that a reader is only missing.
    pub(super) planned: bool,
    /// What to do about it.
    help: &'static str,
}

impl Foreign {
    /// The refusal as an error.
    pub(super) fn error(&self) -> ParseError {
        let problem = if self.planned {
            "is not supported yet".to_owned()
        } else {
            format!("looks like {}: {}; {}", self.name, self.help, readable())
        };
        ParseError::new(Place::Whole, problem).with_help(self.help)
    }
}

/// Bytes that the tests for text formats look at.
const WINDOW: usize = 1 << 14;

/// The foreign format of `bytes`, if it is one of those we can name.
pub(super) fn recognise(bytes: &[u8]) -> Option<Foreign> {
    let start = &bytes[..bytes.len().min(WINDOW)];
    let by_magic = MAGICS
        .iter()
        .find(|(at, magic, _)| bytes.get(*at..).is_some_and(|rest| rest.starts_with(magic)))
        .map(|(_, _, foreign)| *foreign);
    by_magic.or_else(|| {
        let by_shape: [(bool, Foreign); 6] = [
            (
                is_parsec(bytes),
                planned("PARSEC fluid", "convert it to PLY, NPY or CSV"),
            ),
            (
                is_swc(start),
                planned(
                    "SWC skeleton",
                    "its nodes are no free particles; write x, y, z, radius as CSV",
                ),
            ),
            (
                is_houdini_json(start),
                planned("newer Houdini geometry (JSON)", HOUDINI),
            ),
            (is_off(start), other("an OFF mesh", MESH)),
            (is_obj(start), other("an OBJ mesh", MESH)),
            (
                is_json(start),
                other(
                    "JSON",
                    "no particle format of ours is JSON; write CSV or NPY",
                ),
            ),
        ];
        by_shape
            .into_iter()
            .find_map(|(matches, foreign)| matches.then_some(foreign))
    })
}

const MESH: &str = "a mesh has no particles; save its vertices as PLY";
const HOUDINI: &str =
    "in Houdini, save as .bhclassic (the classic .bgeo of version 5), or export PLY or CSV";

const fn planned(name: &'static str, help: &'static str) -> Foreign {
    Foreign {
        name,
        planned: true,
        help,
    }
}

const fn other(name: &'static str, help: &'static str) -> Foreign {
    Foreign {
        name,
        planned: false,
        help,
    }
}

const fn trajectory(name: &'static str) -> Foreign {
    other(
        name,
        "it does not say what its atoms are; render takes it after a molecule file: \
         topology.pdb trajectory.xtc",
    )
}

const fn packed(name: &'static str) -> Foreign {
    other(name, "only gzip is unpacked; decompress the file first")
}

const fn image(name: &'static str) -> Foreign {
    other(name, "a picture is no input; give it a particle file")
}

const fn grid(name: &'static str) -> Foreign {
    other(name, "export the particles as VTK, PLY, NPZ or CSV")
}

/// Formats told by bytes at an offset.
const MAGICS: &[(usize, &[u8], Foreign)] = &[
    (
        0,
        b"\x7fNSJb",
        planned("newer Houdini geometry (binary JSON)", HOUDINI),
    ),
    (
        0,
        b"scf1",
        planned("Blosc-compressed Houdini geometry (.bgeo.sc)", HOUDINI),
    ),
    (0, b"\x54\0\0\0CORD", trajectory("a DCD trajectory")),
    (0, b"\0\0\0\x54CORD", trajectory("a DCD trajectory")),
    (0, b"\x54\0\0\0\0\0\0\0CORD", trajectory("a DCD trajectory")),
    (0, b"\0\0\0\0\0\0\0\x54CORD", trajectory("a DCD trajectory")),
    (0, b"\0\0\x07\xcb", trajectory("an XTC trajectory")),
    (0, b"\0\0\x07\xe7", trajectory("an XTC trajectory")),
    (0, b"\0\0\x07\xc9", trajectory("a TRR trajectory")),
    (
        0,
        b"ITEM: ",
        planned(
            "LAMMPS dump",
            "write it as XYZ (dump xyz) or VTK (dump vtk)",
        ),
    ),
    (0, b"\x89HDF\r\n\x1a\n", grid("HDF5")),
    (0, b"CDF\x01", grid("NetCDF")),
    (0, b"CDF\x02", grid("NetCDF")),
    (0, b"Ogawa", grid("Alembic")),
    (0, b" BDV\0\0\0\0", grid("OpenVDB")),
    (0, b"PXR-USDC", grid("USD")),
    (0, b"#usda", grid("USD")),
    (0, b"PAR1", grid("Parquet")),
    (0, b"LASF", grid("LAS")),
    (0, b"# .PCD", grid("a PCD point cloud")),
    (0, b"ASTM-E57", grid("an E57 point cloud")),
    (0, b"MATLAB 5.0", grid("a MATLAB file")),
    (0, b"glTF", other("a glTF model", MESH)),
    (0, b"solid ", other("an STL mesh", MESH)),
    (0, b"\x89PNG", image("a PNG picture")),
    (0, b"\xff\xd8\xff", image("a JPEG picture")),
    (0, b"v/1\x01", image("an EXR picture")),
    (0, b"\x28\xb5\x2f\xfd", packed("zstd")),
    (0, b"\xfd7zXZ\0", packed("xz")),
    (0, b"BZh", packed("bzip2")),
    (0, b"7z\xbc\xaf\x27\x1c", packed("7-Zip")),
    (0, b"\x1f\x8b", packed("gzip within gzip")),
    (257, b"ustar", packed("a tar archive")),
];

/// Particles per metre, a count, and 36 bytes for each.
fn is_parsec(bytes: &[u8]) -> bool {
    let Some((header, rest)) = bytes.split_first_chunk::<8>() else {
        return false;
    };
    let [a, b, c, d, e, f, g, h] = *header;
    let density = f32::from_le_bytes([a, b, c, d]);
    let count = i32::from_le_bytes([e, f, g, h]);
    (1e-3..1e9).contains(&density)
        && count > 0
        && u64::from(count.unsigned_abs()) * 36 == rest.len() as u64
}

/// Rows `id type x y z radius parent`, the first without a parent.
fn is_swc(start: &[u8]) -> bool {
    let mut rows = lines(start, 1)
        .map(|(_, line)| line)
        .filter(|line| !line.trim_ascii().is_empty() && !line.trim_ascii_start().starts_with(b"#"));
    rows.next().is_some_and(|row| {
        let row: Vec<&[u8]> = words(row).collect();
        let whole = |word: &[u8]| word.iter().all(u8::is_ascii_digit);
        row.len() == 7
            && whole(row[0])
            && whole(row[1])
            && row[6] == b"-1"
            && row.iter().all(|word| float::<f64>(word).is_some())
    })
}

fn is_houdini_json(start: &[u8]) -> bool {
    let text = start.trim_ascii_start();
    text.strip_prefix(b"[")
        .is_some_and(|rest| rest.trim_ascii_start().starts_with(b"\"fileversion\""))
}

fn is_off(start: &[u8]) -> bool {
    let first = words(start).next().unwrap_or_default();
    [&b"OFF"[..], b"COFF", b"NOFF", b"STOFF", b"CNOFF", b"4OFF"].contains(&first)
}

/// A line `v x y z`, after nothing but other statements of OBJ.
fn is_obj(start: &[u8]) -> bool {
    for (_, line) in lines(start, 1) {
        let mut words = words(line);
        match words.next() {
            Some(b"v") => {
                let coordinates = words
                    .take_while(|word| float::<f64>(word).is_some())
                    .count();
                return (3..=8).contains(&coordinates);
            }
            None | Some(b"mtllib" | b"usemtl" | b"o" | b"g" | b"s" | b"vn" | b"vt") => {}
            Some(word) if word.starts_with(b"#") => {}
            Some(_) => return false,
        }
    }
    false
}

fn is_json(start: &[u8]) -> bool {
    let text = start.trim_ascii_start();
    [&b"{"[..], b"["].iter().any(|open| {
        text.strip_prefix(*open).is_some_and(|rest| {
            let next = rest.trim_ascii_start().first();
            next.is_some_and(|byte| b"\"[{]}-0123456789".contains(byte))
        })
    })
}

/// What unknown content looks like, and what would be read.
pub(super) fn describe(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "the file is empty".to_owned();
    }
    let start = &bytes[..bytes.len().min(24)];
    let printable = |byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    let looks = if start.iter().all(printable) {
        let text = String::from_utf8_lossy(start);
        format!("text that starts with {:?}", text.trim_end())
    } else if start.starts_with(b"\xff\xfe") || start.starts_with(b"\xfe\xff") {
        "text in UTF-16 (save it as UTF-8)".to_owned()
    } else {
        let hex: Vec<String> = start[..start.len().min(12)]
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        format!("binary data that starts with bytes {}", hex.join(" "))
    };
    format!(
        "not a particle file that we know: {} bytes of {looks}; {}",
        bytes.len(),
        readable()
    )
}

fn readable() -> String {
    let names: Vec<&str> = Format::ALL.iter().map(|format| format.name()).collect();
    format!("read are {}, each also gzip-compressed", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(bytes: &[u8]) -> Option<&'static str> {
        recognise(bytes).map(|foreign| foreign.name)
    }

    #[test]
    fn formats_that_hold_no_particles_for_us_are_named() {
        let mut parsec = 204.0_f32.to_le_bytes().to_vec();
        parsec.extend(2_i32.to_le_bytes());
        parsec.extend([0; 72]);
        assert_eq!(name(&parsec), Some("PARSEC fluid"));
        parsec.pop();
        assert_eq!(name(&parsec), None);
        for (text, expected) in [
            (
                "# made by\n1 1 0.0 0.0 0.0 0.5 -1\n2 3 0 1 0 0.2 1\n",
                "SWC skeleton",
            ),
            (
                "[\n\t\"fileversion\",\"18.0\",",
                "newer Houdini geometry (JSON)",
            ),
            ("COFF\n8 6 0\n", "an OFF mesh"),
            ("# cube\nmtllib a.mtl\nv 0 0 1\nv 1 1 1\n", "an OBJ mesh"),
            (" {\"a\": 1}", "JSON"),
            ("[[0, 1, 2]]", "JSON"),
            ("solid cube\n", "an STL mesh"),
        ] {
            assert_eq!(name(text.as_bytes()), Some(expected), "{text:?}");
        }
        assert_eq!(name(b"\x54\0\0\0CORD"), Some("a DCD trajectory"));
        assert_eq!(name(b"\0\0\x07\xcb\0\0\0\x09"), Some("an XTC trajectory"));
    }

    #[test]
    fn particle_files_are_not_taken_for_foreign_ones() {
        for text in [
            "ply\nformat ascii 1.0\n",
            "3\ncomment\nH 0 0 0\n",
            "12\n34\nC    0.1668    0.1005    0.5014    1.0000    2.0000\n",
            "x,y,z\n0,1,2\n",
            "0 1 2\n3 4 5\n",
            "1 1 0 0 0 0.5 7\n",
            "",
        ] {
            assert_eq!(name(text.as_bytes()), None, "{text:?}");
        }
    }

    #[test]
    fn unknown_content_is_described() {
        assert!(describe(b"hello, world").contains("\"hello, world\""));
        assert!(describe(b"\x00\x01\xffabc").contains("00 01 ff 61"));
        assert!(describe(b"\xff\xfea\0").contains("UTF-16"));
        assert!(describe(b"").contains("empty"));
        assert!(describe(b"?").contains("ply"));
    }
}

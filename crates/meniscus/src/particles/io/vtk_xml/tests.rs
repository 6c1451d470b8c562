use super::*;
use crate::particles::Particles;
use crate::particles::io::Place;
use crate::particles::io::tests_support::survives_damage;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use std::io::Write;

/// How a test file is stored.
#[derive(Debug, Clone, Copy)]
struct Variant {
    big_endian: bool,
    wide_header: bool,
    compressor: &'static str,
    storage: &'static str,
    pieces: usize,
}

const ASCII: Variant = Variant {
    big_endian: false,
    wide_header: false,
    compressor: "",
    storage: "ascii",
    pieces: 1,
};

fn variants() -> Vec<Variant> {
    let mut variants = vec![ASCII, Variant { pieces: 3, ..ASCII }];
    for storage in ["binary", "raw", "base64"] {
        for compressor in ["", "ZLib", "LZ4", "LZMA"] {
            for i in 0..4 {
                variants.push(Variant {
                    big_endian: i & 1 > 0,
                    wide_header: i & 2 > 0,
                    compressor,
                    storage,
                    pieces: 1 + i % 3,
                });
            }
        }
    }
    variants
}

impl Variant {
    fn number(self, value: usize, wide: bool) -> Vec<u8> {
        match (wide, self.big_endian) {
            (true, true) => (value as u64).to_be_bytes().to_vec(),
            (true, false) => (value as u64).to_le_bytes().to_vec(),
            (false, true) => (value as u32).to_be_bytes().to_vec(),
            (false, false) => (value as u32).to_le_bytes().to_vec(),
        }
    }

    fn bytes(self, data: &ColumnData) -> Vec<u8> {
        let big = self.big_endian;
        macro_rules! put {
            ($($variant:ident)*) => {
                match data {
                    $(ColumnData::$variant(values) => values
                        .iter()
                        .flat_map(|x| if big { x.to_be_bytes() } else { x.to_le_bytes() }.to_vec())
                        .collect(),)*
                }
            };
        }
        put!(I8 U8 I16 U16 I32 U32 I64 U64 F32 F64)
    }

    /// Header and body of an array, in blocks of 16 bytes where it is compressed.
    fn payload(self, data: &ColumnData) -> (Vec<u8>, Vec<u8>) {
        let bytes = self.bytes(data);
        let wide = self.wide_header;
        if self.compressor.is_empty() {
            return ([self.number(bytes.len(), wide), bytes].concat(), Vec::new());
        }
        let blocks: Vec<Vec<u8>> = bytes.chunks(16).map(|block| self.compress(block)).collect();
        let mut header = self.number(blocks.len(), wide);
        header.extend(self.number(16, wide));
        header.extend(self.number(bytes.len() % 16, wide));
        for block in &blocks {
            header.extend(self.number(block.len(), wide));
        }
        (header, blocks.concat())
    }

    fn compress(self, block: &[u8]) -> Vec<u8> {
        match self.compressor {
            "ZLib" => {
                let mut zlib =
                    flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
                zlib.write_all(block).unwrap();
                zlib.finish().unwrap()
            }
            "LZ4" => lz4_flex::block::compress(block),
            _ => {
                let mut xz = liblzma::write::XzEncoder::new(Vec::new(), 1);
                xz.write_all(block).unwrap();
                xz.finish().unwrap()
            }
        }
    }

    fn write(self) -> Vec<u8> {
        let kind = if self.pieces > 1 {
            "PolyData"
        } else {
            "UnstructuredGrid"
        };
        let order = if self.big_endian {
            "BigEndian"
        } else {
            "LittleEndian"
        };
        let header = if self.wide_header { "UInt64" } else { "UInt32" };
        let compressor = match self.compressor {
            "" => String::new(),
            name => format!(" compressor=\"vtk{name}DataCompressor\""),
        };
        let mut xml = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" \
             byte_order=\"{order}\" header_type=\"{header}\"{compressor}>\n<{kind}>\n"
        );
        let mut appended = Vec::new();
        for piece in 0..self.pieces {
            let particles = rows(piece);
            xml += &format!(
                "<Piece NumberOfPoints=\"{}\">\n<PointData>",
                particles.len()
            );
            for column in &particles.columns {
                self.array(&mut xml, &mut appended, column);
            }
            xml += "</PointData>\n<CellData><DataArray/></CellData><Points>";
            let triples = particles.positions.iter().flat_map(|p| p.to_array());
            let triples: Vec<f32> = triples.map(|x| x as f32).collect();
            self.array(&mut xml, &mut appended, &Column::new("Points", 3, triples));
            xml += "</Points></Piece>\n";
        }
        xml += &format!("</{kind}>\n");
        let mut file = xml.into_bytes();
        if !appended.is_empty() {
            let encoding = self.storage;
            file.extend(format!("<AppendedData encoding=\"{encoding}\">\n _").bytes());
            file.extend(appended);
            file.extend(b"\n</AppendedData>\n");
        }
        file.extend(b"</VTKFile>\n");
        file
    }

    fn array(self, xml: &mut String, appended: &mut Vec<u8>, column: &Column) {
        let name = column.name.replace('&', "&amp;");
        let kind = column.data.type_name();
        let kind = match kind.split_at(1) {
            ("i", bits) => format!("Int{bits}"),
            ("u", bits) => format!("UInt{bits}"),
            (_, bits) => format!("Float{bits}"),
        };
        let tag = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{}\"",
            column.components
        );
        if self.storage == "ascii" {
            let words = (0..column.data.len()).map(|i| column.data.get(i).to_string());
            let words = words.collect::<Vec<_>>().join(" ");
            *xml += &format!("{tag} format=\"ascii\">\n{words}\n<Value>7</Value></DataArray>");
            return;
        }
        let (header, body) = self.payload(&column.data);
        let base64 = || STANDARD.encode(&header) + &STANDARD.encode(&body);
        if self.storage == "binary" {
            *xml += &format!("{tag} format=\"binary\">\n  {}\n</DataArray>", base64());
            return;
        }
        *xml += &format!("{tag} format=\"appended\" offset=\"{}\"/>", appended.len());
        if self.storage == "base64" {
            appended.extend(base64().bytes());
        } else {
            appended.extend([header, body].concat());
        }
    }
}

/// Some particles of piece `piece`.
fn rows(piece: usize) -> Particles {
    let count = 5 + 3 * piece;
    let at = |i: usize| (i + 10 * piece) as f64;
    let positions = (0..count).map(|i| DVec3::new(at(i), 0.5, -at(i))).collect();
    let mut particles = Particles::from_positions(positions);
    particles.columns = vec![
        Column::new(
            "a & b",
            1,
            (0..count).map(|i| i as i8 - 3).collect::<Vec<_>>(),
        ),
        Column::new(
            "id",
            1,
            (0..count).map(|i| (i * i) as u64).collect::<Vec<_>>(),
        ),
        Column::new("v", 3, (0..3 * count).map(at).collect::<Vec<f64>>()),
        Column::new(
            "u16",
            1,
            (0..count).map(|i| i as u16 * 1000).collect::<Vec<_>>(),
        ),
    ];
    particles
}

fn expected(pieces: usize) -> Particles {
    let mut all = rows(0);
    for piece in (1..pieces).map(rows) {
        all.positions.extend(piece.positions);
        for (column, more) in all.columns.iter_mut().zip(piece.columns) {
            append(&mut column.data, more.data);
        }
    }
    all.rows = (0..all.positions.len() as u32).collect();
    all
}

#[test]
fn every_storage_reads_the_same() {
    for variant in variants() {
        let file = variant.write();
        assert!(detect(&file), "{variant:?}");
        let parsed = read(&file, 0).unwrap_or_else(|error| panic!("{variant:?}: {error}"));
        assert!(
            parsed.warnings.is_empty(),
            "{variant:?}: {:?}",
            parsed.warnings
        );
        assert_eq!(parsed.particles, expected(variant.pieces), "{variant:?}");
    }
}

#[test]
fn damage_never_panics() {
    for variant in variants() {
        // Each compressor raw, and each other storage without compression, is enough.
        let chosen = match variant.storage {
            "raw" => !variant.big_endian,
            _ => variant.compressor.is_empty() && !variant.wide_header,
        };
        if chosen {
            survives_damage(&variant.write(), 11, |bytes| drop(read(bytes, 0)));
        }
    }
}

/// A file with one piece of `points` points and this content.
fn file(points: &str, content: &str) -> String {
    format!(
        "<VTKFile type=\"PolyData\"><PolyData>\n<Piece NumberOfPoints=\"{points}\">\n{content}\n\
         </Piece></PolyData></VTKFile>"
    )
}

const ONE_POINT: &str =
    "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\">1 2 3</DataArray></Points>";

#[test]
fn errors_say_where_and_what() {
    let points = |attributes: &str, text: &str| {
        let array = format!("<DataArray type=\"Float32\" {attributes}>{text}</DataArray>");
        file("2", &format!("<Points>{array}</Points>"))
    };
    let root = |attributes: &str| format!("<VTKFile {attributes}><PolyData/></VTKFile>");
    for (content, problem) in [
        (root("type=\"ImageData\""), "grid"),
        (root("type=\"PPolyData\""), "other files"),
        (root("type=\"Soup\""), "\"Soup\""),
        (root(""), "type"),
        (root("type=\"PolyData\" byte_order=\"Odd\""), "byte_order"),
        (
            root("type=\"PolyData\" header_type=\"Int8\""),
            "header_type",
        ),
        (root("type=\"PolyData\" compressor=\"zip\""), "compressor"),
        (
            "<VTKFile type=\"PolyData\"></VTKFile>".to_owned(),
            "no data set",
        ),
        (
            "<VTKFile type=\"PolyData\"><PolyData>".to_owned(),
            "ends before",
        ),
        (
            "<VTKFile type=\"PolyData\"></PolyData>".to_owned(),
            "well-formed",
        ),
        (file("many", ""), "NumberOfPoints"),
        (file("-1", ""), "NumberOfPoints"),
        (file("1", ""), "<Points>"),
        (points("", "1 2 3 4 5"), "announced"),
        (points("", "1 2 3  4  5"), "after 5"),
        (points("", "1 2 3 4 5 x"), "\"x\""),
        (
            points("NumberOfComponents=\"2\"", "1 2 3 4"),
            "3 components",
        ),
        (points("NumberOfComponents=\"no\"", ""), "\"no\""),
        (points("format=\"hex\"", "00"), "\"hex\""),
        (points("format=\"appended\"", ""), "offset"),
        (points("format=\"appended\" offset=\"5\"", ""), "offset"),
        (points("format=\"binary\"", ""), "bytes"),
        (points("format=\"binary\"", "BAAAAAAAgD8="), "has 4 bytes"),
        (points("format=\"binary\"", "GAAAAAAAgD8="), "24 bytes"),
        (points("format=\"binary\"", "GAAAAA*AgD8="), "base64"),
        (file("9223372036854775807", ONE_POINT), "×"),
        (file("999999999999", ONE_POINT), "announced"),
    ] {
        let error = read(content.as_bytes(), 0).unwrap_err();
        assert!(error.problem.contains(problem), "{content}: {error}");
        assert!(
            matches!(error.place, Place::Line(1..=4)),
            "{content}: {error}"
        );
    }
}

#[test]
fn announced_sizes_are_held_against_the_bytes_that_are_there() {
    let tiny = Variant {
        compressor: "ZLib",
        storage: "raw",
        ..ASCII
    };
    let valid = String::from_utf8_lossy(&tiny.write()).into_owned();
    assert!(valid.contains("NumberOfPoints=\"5\""));
    // Block count, block size and last size that agree with a billion points of 12 bytes.
    for (blocks, block_size, last) in [
        (1u32, 0u32, 12_000_000),
        (1_000_000, 12, 0),
        (1, 12_000_000, 0),
    ] {
        let mut content =
            b"<VTKFile type=\"PolyData\" compressor=\"vtkZLibDataCompressor\"><PolyData>\
            <Piece NumberOfPoints=\"1000000\"><Points><DataArray type=\"Float32\" \
            format=\"appended\" offset=\"0\"/></Points></Piece></PolyData>\
            <AppendedData encoding=\"raw\">_"
                .to_vec();
        for number in [blocks, block_size, last, 20] {
            content.extend(number.to_le_bytes());
        }
        content.extend([0; 20]);
        let error = read(&content, 0).unwrap_err();
        assert!(matches!(error.place, Place::Byte(_)), "{error}");
        let problem = &error.problem;
        assert!(
            problem.contains("cannot unfold") || problem.contains("bytes are needed"),
            "{error}"
        );
    }
    // Many arrays that share the same bytes would multiply the file's size in memory.
    let array =
        "<DataArray type=\"Float64\" NumberOfComponents=\"300\" format=\"appended\" offset=\"0\"";
    let arrays: String = (0..100)
        .map(|i| format!("{array} Name=\"{i}\"/>"))
        .collect();
    let mut content = format!(
        "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"3\"><Points>\
         <DataArray type=\"Float64\" format=\"appended\" offset=\"0\"/></Points>\
         <PointData>{arrays}</PointData></Piece></PolyData><AppendedData encoding=\"raw\">_"
    )
    .into_bytes();
    content.extend(7200u32.to_le_bytes());
    content.extend([0; 7200]);
    let error = read(&content, 0).unwrap_err();
    assert!(error.problem.contains("too much for a file"), "{error}");
}

#[test]
fn pieces_keep_what_all_of_them_have() {
    let piece = |points: usize, arrays: &str| {
        let zeros = "0 0 0 ".repeat(points);
        format!(
            "<Piece NumberOfPoints=\"{points}\"><Points><DataArray type=\"Float32\" \
             NumberOfComponents=\"3\">{zeros}</DataArray></Points><PointData>{arrays}</PointData>\
             </Piece>"
        )
    };
    let array = |kind: &str, name: &str, text: &str| {
        format!("<DataArray type=\"{kind}\" Name=\"{name}\">{text}</DataArray>")
    };
    let first = array("Int8", "all", "1 <!-- one --> 2")
        + &array("Int8", "some", "3 4")
        + &array("Int8", "mixed", "5 6")
        + &array("Int8", "all", "7 8")
        + &array("String", "words", "65 0");
    let second = array("Float32", "mixed", "7") + &array("Int8", "all", "9");
    let content = format!(
        "\u{feff}<?xml version=\"1.0\"?><VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>{}{}{}\
         </UnstructuredGrid></VTKFile>",
        piece(2, &first),
        piece(0, ""),
        piece(1, &second)
    );
    assert!(detect(content.as_bytes()));
    let parsed = read(content.as_bytes(), 0).unwrap();
    assert_eq!(parsed.particles.len(), 3);
    assert_eq!(
        parsed.particles.columns,
        [Column::new("all", 1, vec![1i8, 2, 9])]
    );
    let warned = |name| parsed.warnings.iter().any(|warning| warning.contains(name));
    assert!(
        ["\"all\"", "\"some\"", "\"mixed\"", "\"words\""]
            .into_iter()
            .all(warned)
    );
    assert_eq!(parsed.warnings.len(), 4);
}

#[test]
fn time_steps_are_frames() {
    let content = file(
        "1",
        &(ONE_POINT.to_owned()
            + "<PointData><DataArray type=\"Int32\" Name=\"a\" TimeStep=\"0\">4</DataArray>\
               <DataArray type=\"Int32\" Name=\"a\" TimeStep=\"1\">5</DataArray></PointData>"),
    )
    .replace("<PolyData>", "<PolyData TimeValues=\"0.5 1.5\">");
    for frame in 0..2 {
        let parsed = read(content.as_bytes(), frame).unwrap();
        assert_eq!(parsed.frames, 2);
        let column = Column::new("a", 1, vec![4 + frame as i32]);
        assert_eq!(parsed.particles.columns, [column]);
    }
    assert_eq!(read(content.as_bytes(), 2).unwrap().frames, 2);
}

#[test]
fn structured_grids_count_their_points_and_empty_files_are_valid() {
    let grid = file("", ONE_POINT)
        .replace("NumberOfPoints=\"\"", "Extent=\"0 0 3 3 -1 -1\"")
        .replace("PolyData", "StructuredGrid");
    let parsed = read(grid.as_bytes(), 0).unwrap();
    assert_eq!(parsed.particles.positions, [DVec3::new(1.0, 2.0, 3.0)]);
    let inverted = grid.replace("0 0 3 3", "0 -1 3 3");
    assert!(read(inverted.as_bytes(), 0).unwrap().particles.is_empty());
    assert!(
        read(file("0", "").as_bytes(), 0)
            .unwrap()
            .particles
            .is_empty()
    );
}

//! Walks over the markup up to the appended data, which is no XML.

use super::compression::Compressor;
use super::document::{Array, Document, Piece, Stored, element};
use crate::particles::io::bytes::Endian;
use crate::particles::io::vtk_values::{Words, excerpt, line_of};
use crate::particles::io::{ParseError, Place};
use quick_xml::Reader;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use std::collections::HashSet;
use std::ops::Range;

/// An open element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tag {
    VtkFile,
    DataSet,
    Piece,
    Points,
    PointData,
    DataArray,
    Other,
}

/// Reads the markup of `file`, with the arrays of time step `frame`.
pub(super) fn parse(file: &[u8], frame: usize) -> Result<Document, ParseError> {
    let start = if file.starts_with(b"\xef\xbb\xbf") {
        3
    } else {
        0
    };
    let mut reader = Reader::from_reader(&file[start..]);
    reader.config_mut().expand_empty_elements = true;
    let mut walk = Walk {
        file,
        frame,
        document: Document::default(),
        open: Vec::new(),
        array: None,
        text: Vec::new(),
        names: HashSet::new(),
        offset: 0,
    };
    loop {
        walk.offset = start + reader.buffer_position() as usize;
        let event = reader.read_event().map_err(|error| {
            let offset = start + reader.error_position() as usize;
            let problem = format!("no well-formed XML: {error}");
            ParseError::new(line_of(file, offset), problem)
        })?;
        let end = start + reader.buffer_position() as usize;
        match event {
            Event::Start(tag) => {
                let opened = walk.start(&tag)?;
                if walk.open.last() == Some(&Tag::VtkFile) && tag.name().as_ref() == "AppendedData"
                {
                    walk.appended(&tag, end)?;
                    break;
                }
                walk.open.push(opened);
            }
            Event::Text(_)
                if walk.open.last() == Some(&Tag::DataArray)
                    && !file[walk.offset..end].trim_ascii().is_empty() =>
            {
                walk.text.push(walk.offset..end);
            }
            Event::End(_) => {
                let closed = walk.open.pop();
                walk.end(closed);
                if closed == Some(Tag::VtkFile) {
                    break;
                }
            }
            Event::Eof => return Err(walk.error("the file ends before </VTKFile>")),
            _ => {}
        }
    }
    if walk.document.frames == 0 {
        return Err(walk.error("there is no data set in <VTKFile>"));
    }
    Ok(walk.document)
}

struct Walk<'a> {
    file: &'a [u8],
    frame: usize,
    document: Document,
    open: Vec<Tag>,
    /// The array whose element is open.
    array: Option<Array>,
    /// The text in that element.
    text: Vec<Range<usize>>,
    /// Names of the arrays of the current piece.
    names: HashSet<String>,
    /// Where the current event starts.
    offset: usize,
}

impl Walk<'_> {
    fn error(&self, problem: impl Into<String>) -> ParseError {
        ParseError::new(line_of(self.file, self.offset), problem)
    }

    fn start(&mut self, tag: &BytesStart) -> Result<Tag, ParseError> {
        let name = tag.name();
        Ok(match (self.open.last(), name.as_ref()) {
            (None, "VTKFile") => {
                self.vtk_file(tag)?;
                Tag::VtkFile
            }
            (Some(Tag::VtkFile), "UnstructuredGrid" | "PolyData" | "StructuredGrid") => {
                let [times] = self.attributes(tag, ["TimeValues"])?;
                let steps = times.map_or(1, |times| Words::new(times.as_bytes(), 0).count());
                self.document.frames = steps.max(1);
                Tag::DataSet
            }
            (Some(Tag::DataSet), "Piece") => {
                self.piece(tag)?;
                Tag::Piece
            }
            (Some(Tag::Piece), "Points") => Tag::Points,
            (Some(Tag::Piece), "PointData") => Tag::PointData,
            (Some(Tag::Points | Tag::PointData), "DataArray" | "Array") => {
                self.data_array(tag)?;
                Tag::DataArray
            }
            _ => Tag::Other,
        })
    }

    fn vtk_file(&mut self, tag: &BytesStart) -> Result<(), ParseError> {
        let [kind, order, header, compressor] =
            self.attributes(tag, ["type", "byte_order", "header_type", "compressor"])?;
        let problem = match kind.as_deref() {
            Some("UnstructuredGrid" | "PolyData" | "StructuredGrid") => None,
            Some(kind @ ("ImageData" | "RectilinearGrid" | "HyperTreeGrid")) => Some((
                format!("a {kind} is a grid without points of its own"),
                "particles are the points of an UnstructuredGrid or PolyData",
            )),
            Some(
                kind @ ("PUnstructuredGrid"
                | "PPolyData"
                | "PStructuredGrid"
                | "Collection"
                | "vtkMultiBlockDataSet"
                | "vtkPartitionedDataSet"
                | "vtkPartitionedDataSetCollection"),
            ) => Some((
                format!("a {kind} only names other files"),
                "give those files (.vtu, .vtp) themselves",
            )),
            Some(kind) => Some((
                format!("the file holds a {}", excerpt(kind.as_bytes())),
                "particles are the points of an UnstructuredGrid or PolyData",
            )),
            None => Some((
                "<VTKFile> has no attribute \"type\"".to_owned(),
                "it must say UnstructuredGrid or PolyData",
            )),
        };
        if let Some((problem, help)) = problem {
            return Err(self.error(problem).with_help(help));
        }
        let storage = &mut self.document.storage;
        storage.endian = match order.as_deref() {
            None | Some("LittleEndian") => Endian::Little,
            Some("BigEndian") => Endian::Big,
            Some(other) => return Err(self.unexpected("byte_order", other)),
        };
        storage.header_width = match header.as_deref() {
            None | Some("UInt32") => 4,
            Some("UInt64") => 8,
            Some(other) => return Err(self.unexpected("header_type", other)),
        };
        if let Some(name) = compressor.filter(|name| !name.is_empty()) {
            storage.compressor = Compressor::from_name(&name);
            if storage.compressor.is_none() {
                let help = "vtkZLibDataCompressor, vtkLZ4DataCompressor, vtkLZMADataCompressor are";
                return Err(self.unexpected("compressor", &name).with_help(help));
            }
        }
        Ok(())
    }

    fn unexpected(&self, attribute: &str, value: &str) -> ParseError {
        let value = excerpt(value.as_bytes());
        self.error(format!("{attribute} = {value} is not known"))
    }

    fn piece(&mut self, tag: &BytesStart) -> Result<(), ParseError> {
        let [points, extent] = self.attributes(tag, ["NumberOfPoints", "Extent"])?;
        let count = match (&points, &extent) {
            (Some(points), _) => points.trim().parse().ok(),
            (None, Some(extent)) => points_in_extent(extent),
            (None, None) => None,
        };
        let Some(points) = count else {
            return Err(self.error("<Piece> must have a whole number as its NumberOfPoints"));
        };
        self.names.clear();
        self.document.pieces.push(Piece {
            points,
            offset: self.offset,
            ..Piece::default()
        });
        Ok(())
    }

    /// Begins an array; it is forgotten at its end unless it holds numbers of this frame.
    fn data_array(&mut self, tag: &BytesStart) -> Result<(), ParseError> {
        let [kind, name, components, format, offset, step] = self.attributes(
            tag,
            [
                "type",
                "Name",
                "NumberOfComponents",
                "format",
                "offset",
                "TimeStep",
            ],
        )?;
        let name = name.unwrap_or_default();
        let number = |attribute: &str, value: Option<String>| match value {
            None => Ok(None),
            Some(value) => value.trim().parse().map(Some).map_err(|_| {
                let value = excerpt(value.as_bytes());
                self.error(format!("array {name:?}: {attribute} = {value} is no count"))
            }),
        };
        let components: Option<usize> = number("NumberOfComponents", components)?;
        let offset = number("offset", offset)?;
        let step = number("TimeStep", step)?;
        if step.is_some_and(|step| step != self.frame) {
            return Ok(());
        }
        let Some(element) = kind
            .as_deref()
            .and_then(element)
            .filter(|_| components != Some(0))
        else {
            self.document.warnings.push(format!(
                "array {name:?} does not hold numbers and was left out"
            ));
            return Ok(());
        };
        let stored = match (format.as_deref(), offset) {
            (Some("appended") | None, Some(offset)) => Stored::Appended(offset),
            (Some("binary"), _) => Stored::Base64(Vec::new()),
            (Some("ascii") | None, _) => Stored::Text(Vec::new()),
            (Some("appended"), None) => {
                return Err(self.error(format!("array {name:?} is appended, but has no offset")));
            }
            (Some(other), _) => {
                let other = excerpt(other.as_bytes());
                return Err(self.error(format!("array {name:?}: format = {other} is not known")));
            }
        };
        self.array = Some(Array {
            name,
            element,
            components,
            stored,
            offset: self.offset,
        });
        Ok(())
    }

    fn end(&mut self, closed: Option<Tag>) {
        if closed != Some(Tag::DataArray) {
            return;
        }
        let text = std::mem::take(&mut self.text);
        let (Some(mut array), Some(piece)) = (self.array.take(), self.document.pieces.last_mut())
        else {
            return;
        };
        match &mut array.stored {
            Stored::Text(ranges) | Stored::Base64(ranges) => *ranges = text,
            Stored::Appended(_) => {}
        }
        if self.open.last() == Some(&Tag::Points) {
            piece.positions.get_or_insert(array);
        } else if self.names.insert(array.name.clone()) {
            piece.arrays.push(array);
        } else {
            self.document.warnings.push(format!(
                "array {:?} stands twice in one piece; the first was taken",
                array.name
            ));
        }
    }

    /// Notes where the appended data are: from behind the first `_` to the closing tag.
    fn appended(&mut self, tag: &BytesStart, end_of_tag: usize) -> Result<(), ParseError> {
        let [encoding] = self.attributes(tag, ["encoding"])?;
        let mut words = Words::new(self.file, end_of_tag);
        words.skip_space();
        if words.rest().first() != Some(&b'_') {
            let place = Place::Byte(words.position as u64);
            return Err(ParseError::new(
                place,
                "appended data must start with \"_\"",
            ));
        }
        let start = words.position + 1;
        let behind = &self.file[start..];
        let storage = &mut self.document.storage;
        storage.appended_base64 = match encoding.as_deref() {
            Some("raw") => false,
            Some("base64") | None => true,
            Some(other) => return Err(self.unexpected("encoding", other)),
        };
        let end = if storage.appended_base64 {
            behind.iter().position(|&byte| byte == b'<')
        } else {
            // Raw bytes may hold anything, so only the last closing tag is one.
            let tail = behind.len().saturating_sub(CLOSING_WITHIN);
            let window = CLOSING_TAG.len();
            let found = behind[tail..]
                .windows(window)
                .rposition(|w| w == CLOSING_TAG);
            found.map(|found| tail + found)
        };
        storage.appended = start..start + end.unwrap_or(behind.len());
        Ok(())
    }

    /// The values of these attributes of `tag`.
    fn attributes<const N: usize>(
        &self,
        tag: &BytesStart,
        names: [&str; N],
    ) -> Result<[Option<String>; N], ParseError> {
        let mut values = [const { None }; N];
        // The check for attributes that stand twice takes time with the square of their number.
        for attribute in tag.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.error(error.to_string()))?;
            let name = attribute.key.as_ref();
            if let Some(index) = names.iter().position(|&wanted| wanted == name) {
                let value = attribute
                    .normalized_value(XmlVersion::Explicit1_0)
                    .map_err(|error| self.error(format!("attribute {name}: {error}")))?;
                values[index] = Some(value.into_owned());
            }
        }
        Ok(values)
    }
}

const CLOSING_TAG: &[u8] = b"</AppendedData>";
/// The closing tags stand within so many bytes of the end.
const CLOSING_WITHIN: usize = 256;

/// Number of points of a structured piece: `x0 x1 y0 y1 z0 z1`, both ends included.
fn points_in_extent(extent: &str) -> Option<usize> {
    let bounds: Vec<i64> = extent
        .split_ascii_whitespace()
        .map(|bound| bound.parse().ok())
        .collect::<Option<_>>()?;
    let [x0, x1, y0, y1, z0, z1] = bounds.try_into().ok()?;
    let side = |low: i64, high: i64| {
        let side = high.checked_sub(low)?.checked_add(1)?.max(0);
        usize::try_from(side).ok()
    };
    side(x0, x1)?
        .checked_mul(side(y0, y1)?)?
        .checked_mul(side(z0, z1)?)
}

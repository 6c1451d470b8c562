//! Gzip around any format: several members in a row, bounded memory.

use super::{ParseError, Place};
use flate2::bufread::GzDecoder;
use std::io::Read;

/// Content that compresses better than [`RATIO`] may still unfold to this size.
const ALWAYS_ALLOWED: u64 = 128 << 20;
/// Allowed bytes per compressed byte beyond that.
const RATIO: u64 = 32;

/// How many bytes compressed ones may unfold to.
pub(super) fn allowance(compressed: usize) -> u64 {
    ALWAYS_ALLOWED + RATIO * compressed as u64
}

/// Decompressed content.
pub(super) struct Unfolded {
    /// All members, one after the other.
    pub(super) bytes: Vec<u8>,
    /// About what stands behind the last member.
    pub(super) warning: Option<String>,
}

/// Whether the content is a gzip file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// Decompresses every member, at most 128 MiB plus 32 times the compressed size.
pub(super) fn unfold(compressed: &[u8]) -> Result<Unfolded, ParseError> {
    unfold_within(compressed, allowance(compressed.len()))
}

fn unfold_within(compressed: &[u8], limit: u64) -> Result<Unfolded, ParseError> {
    let mut rest = compressed;
    let mut bytes = Vec::new();
    while detect(rest) {
        let mut decoder = GzDecoder::new(rest);
        let room = limit - bytes.len() as u64;
        let read = (&mut decoder).take(room + 1).read_to_end(&mut bytes);
        let place = Place::Byte(bytes.len() as u64);
        let rest_of_file = decoder.into_inner();
        read.map_err(|error| {
            ParseError::new(place, format!("of the decompressed content: {error}"))
                .with_help("the compressed file is damaged or cut short; copy it again")
        })?;
        if bytes.len() as u64 > limit {
            return Err(ParseError::new(
                Place::Whole,
                format!(
                    "unfolds from {} bytes to more than {limit} bytes",
                    compressed.len()
                ),
            )
            .with_help(
                "no frame of particles compresses like that; if it is real, decompress it first",
            ));
        }
        rest = rest_of_file;
    }
    let only_padding = rest.iter().all(|&byte| byte == 0);
    let warning =
        (!only_padding).then(|| format!("{} bytes behind the gzip data were ignored", rest.len()));
    Ok(Unfolded { bytes, warning })
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    fn member(content: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn members_are_joined_and_padding_is_ignored() {
        let mut file = member(b"first ");
        file.extend(member(b"second"));
        file.extend([0; 7]);
        let unfolded = unfold(&file).unwrap();
        assert_eq!(unfolded.bytes, b"first second");
        assert_eq!(unfolded.warning, None);
        file.extend(b"junk");
        let warning = unfold(&file).unwrap().warning.unwrap();
        assert!(warning.contains("11 bytes"), "{warning}");
    }

    #[test]
    fn a_bomb_is_refused_at_the_limit() {
        let bomb = member(&vec![0; 1 << 20]);
        assert_eq!(unfold_within(&bomb, 1 << 20).unwrap().bytes.len(), 1 << 20);
        let error = unfold_within(&bomb, (1 << 20) - 1).err().unwrap();
        assert!(error.problem.contains("unfolds"), "{error}");
        let two = [bomb.clone(), bomb].concat();
        assert!(unfold_within(&two, 1 << 20).is_err());
    }

    #[test]
    fn truncation_at_any_byte_is_an_error_that_says_where() {
        let file = member(b"some content that is long enough to be cut anywhere");
        for length in 2..file.len() {
            let error = unfold(&file[..length]).err().unwrap();
            assert!(error.help.is_some(), "{length}: {error}");
        }
    }
}

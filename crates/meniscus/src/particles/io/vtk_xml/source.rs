//! Bytes of a binary array, raw or as base64.

use super::compression::number;
use crate::particles::io::bytes::Endian;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::borrow::Cow;

/// Padding is looked after here, because VTK puts it in the middle too.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_allow_trailing_bits(true)
        .with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Hands out the bytes of an array one after the other.
#[derive(Debug)]
pub(super) enum Source<'a> {
    /// The bytes themselves.
    Raw(&'a [u8]),
    /// Base64 text. A compressed array's header and body are encoded one after the other, each
    /// padded on its own; white space may stand anywhere.
    Base64 {
        text: &'a [u8],
        /// Decoded, not yet handed out; less than three bytes.
        carry: Vec<u8>,
    },
}

impl<'a> Source<'a> {
    pub(super) fn base64(text: &'a [u8]) -> Self {
        Self::Base64 {
            text,
            carry: Vec::new(),
        }
    }

    /// No more bytes than this can follow.
    pub(super) fn at_most(&self) -> usize {
        match self {
            Self::Raw(bytes) => bytes.len(),
            Self::Base64 { text, carry } => text.len() / 4 * 3 + 3 + carry.len(),
        }
    }

    /// The next `size` bytes.
    pub(super) fn take(&mut self, size: usize) -> Result<Cow<'a, [u8]>, String> {
        if size > self.at_most() {
            return Err(ends_early(size, self.at_most()));
        }
        match self {
            Self::Raw(bytes) => {
                let (taken, rest) = bytes.split_at(size);
                *bytes = rest;
                Ok(Cow::Borrowed(taken))
            }
            Self::Base64 { text, carry } => {
                let mut taken = std::mem::take(carry);
                taken.reserve(size + 3);
                while taken.len() < size {
                    let characters = (size - taken.len()).div_ceil(3) * 4;
                    let group = next_group(text, characters);
                    if group.is_empty() {
                        return Err(ends_early(size, taken.len()));
                    }
                    BASE64
                        .decode_vec(group, &mut taken)
                        .map_err(|error| format!("damaged base64: {error}"))?;
                }
                *carry = taken.split_off(size);
                Ok(Cow::Owned(taken))
            }
        }
    }

    /// The next number of `width` bytes.
    pub(super) fn take_number(&mut self, width: usize, endian: Endian) -> Result<usize, String> {
        let bytes = self.take(width)?;
        number(&bytes, endian)
    }
}

fn ends_early(size: usize, found: usize) -> String {
    format!("{size} bytes are needed, but only {found} follow")
}

/// Up to `characters` characters from the front of `text` without white space, ending at padding.
fn next_group<'a>(text: &mut &'a [u8], characters: usize) -> Cow<'a, [u8]> {
    let plain = |byte: &u8| *byte > b' ' && *byte != b'=';
    let start = text.iter().position(plain).unwrap_or(text.len());
    let rest = &text[start..];
    if let Some((group, behind)) = rest.split_at_checked(characters)
        && group.iter().all(plain)
    {
        *text = behind;
        return Cow::Borrowed(group);
    }
    let mut group = Vec::new();
    let mut used = 0;
    for &byte in rest {
        if group.len() == characters || byte == b'=' {
            break;
        }
        if plain(&byte) {
            group.push(byte);
        }
        used += 1;
    }
    *text = &rest[used..];
    Cow::Owned(group)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_continues_behind_padding_and_white_space() {
        let whole: Vec<u8> = (0..=255).collect();
        let encode = |bytes: &[u8]| base64::engine::general_purpose::STANDARD.encode(bytes);
        let text = format!(
            "\n  {}{}\r\n\t{}",
            encode(&whole[..4]),
            encode(&whole[4..100]),
            encode(&whole[100..])
        );
        for step in 1..40 {
            let mut source = Source::base64(text.as_bytes());
            let mut found = Vec::new();
            while found.len() < 256 {
                let size = step.min(256 - found.len());
                found.extend_from_slice(&source.take(size).unwrap());
            }
            assert_eq!(found, whole, "steps of {step}");
            assert!(source.take(1).is_err());
        }
        assert!(Source::base64(b"AA*A").take(3).is_err());
        assert!(Source::base64(b"AAAA").take(usize::MAX).is_err());
        assert!(Source::base64(b"====").take(1).is_err());
    }
}

//! What every reader must hold, whatever the bytes.

use meniscus::particles::io::{Format, Parsed, parse};

/// Reads the first two frames as one of `formats`, which the first byte chooses.
pub fn read_as(formats: &[Format], bytes: &[u8]) {
    let Some((&choice, bytes)) = bytes.split_first() else {
        return;
    };
    let format = formats[usize::from(choice) % formats.len()];
    for frame in 0..2 {
        if let Ok(parsed) = format.parse(bytes, frame) {
            check(&parsed);
        }
    }
}

/// Reads as files are read: gzip unfolded, the format told by content.
pub fn read_any(bytes: &[u8]) {
    if let Ok((_, parsed)) = parse(bytes, 0) {
        check(&parsed);
    }
}

fn check(parsed: &Parsed) {
    let particles = &parsed.particles;
    assert_eq!(particles.rows.len(), particles.len());
    for column in &particles.columns {
        assert!(column.components > 0, "{}", column.name);
        assert_eq!(
            column.data.len(),
            column.components * particles.len(),
            "{}",
            column.name
        );
    }
}

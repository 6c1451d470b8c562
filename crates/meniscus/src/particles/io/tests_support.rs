//! What tests of several readers share.

/// Calls `read` with `valid` cut at every byte, with every `step`-th byte changed in several ways, and
/// with pieces cut out or doubled. The point is that it returns.
pub(super) fn survives_damage(valid: &[u8], step: usize, read: impl Fn(&[u8])) {
    for length in 0..valid.len() {
        read(&valid[..length]);
    }
    let mut damaged = valid.to_vec();
    for i in (0..valid.len()).step_by(step) {
        let flips = (0..8).map(|bit| valid[i] ^ 1 << bit);
        for byte in flips.chain([0, 0xff, b' ', b'9', b'-', b'"', b'<']) {
            damaged[i] = byte;
            read(&damaged);
        }
        damaged[i] = valid[i];
    }
    for start in (0..valid.len()).step_by(3 * step) {
        let end = (start + 1 + start % 23).min(valid.len());
        read(&[&valid[..start], &valid[end..]].concat());
        read(&[&valid[..end], &valid[start..]].concat());
    }
}

//! Morton codes: the bits of three coordinates in turn, so that points near each other get codes
//! near each other (Morton 1966).

/// Bits per axis at most.
pub const MAX_BITS: u32 = 21;

/// The code of a cell of a grid of up to 2²¹ cells per axis; x has the highest bit.
pub fn morton([x, y, z]: [u64; 3]) -> u64 {
    spread(x) << 2 | spread(y) << 1 | spread(z)
}

/// Bit i of the lowest 21 to bit 3i.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_take_turns() {
        assert_eq!(morton([1, 0, 0]), 0b100);
        assert_eq!(morton([0, 1, 0]), 0b010);
        assert_eq!(morton([0, 0, 1]), 0b001);
        assert_eq!(morton([0b10, 0b11, 0]), 0b110_010);
        let full = (1 << MAX_BITS) - 1;
        assert_eq!(morton([full; 3]), (1 << (3 * MAX_BITS)) - 1);
    }
}

//! Chemical elements: symbols, van der Waals radii, colours.

/// Symbols by atomic number; number 0 is the dummy atom X.
const SYMBOLS: [&str; 119] = [
    "X", "H", "He", "Li", "Be", "B", "C", "N", "O", "F", "Ne", "Na", "Mg", "Al", "Si", "P", "S",
    "Cl", "Ar", "K", "Ca", "Sc", "Ti", "V", "Cr", "Mn", "Fe", "Co", "Ni", "Cu", "Zn", "Ga", "Ge",
    "As", "Se", "Br", "Kr", "Rb", "Sr", "Y", "Zr", "Nb", "Mo", "Tc", "Ru", "Rh", "Pd", "Ag", "Cd",
    "In", "Sn", "Sb", "Te", "I", "Xe", "Cs", "Ba", "La", "Ce", "Pr", "Nd", "Pm", "Sm", "Eu", "Gd",
    "Tb", "Dy", "Ho", "Er", "Tm", "Yb", "Lu", "Hf", "Ta", "W", "Re", "Os", "Ir", "Pt", "Au", "Hg",
    "Tl", "Pb", "Bi", "Po", "At", "Rn", "Fr", "Ra", "Ac", "Th", "Pa", "U", "Np", "Pu", "Am", "Cm",
    "Bk", "Cf", "Es", "Fm", "Md", "No", "Lr", "Rf", "Db", "Sg", "Bh", "Hs", "Mt", "Ds", "Rg", "Cn",
    "Nh", "Fl", "Mc", "Lv", "Ts", "Og",
];

/// The symbol of an atomic number; "X" for anything that is none.
pub fn symbol(atomic_number: f64) -> &'static str {
    let index = if atomic_number.fract() == 0.0 {
        atomic_number as usize
    } else {
        0
    };
    SYMBOLS.get(index).copied().unwrap_or("X")
}

/// The atomic number that a word of an XYZ file stands for: a symbol in any case, with digits or
/// signs behind it (`H1`, `C+`), deuterium, or the number itself; 0 for anything else.
pub fn atomic_number(word: &[u8]) -> u8 {
    if let Some(number) = std::str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse::<u8>().ok())
    {
        return if usize::from(number) < SYMBOLS.len() {
            number
        } else {
            0
        };
    }
    let letters = word
        .iter()
        .take_while(|byte| byte.is_ascii_alphabetic())
        .count();
    let symbol = &word[..letters];
    if symbol.eq_ignore_ascii_case(b"D") || symbol.eq_ignore_ascii_case(b"T") {
        return 1;
    }
    SYMBOLS
        .iter()
        .position(|known| known.as_bytes().eq_ignore_ascii_case(symbol))
        .unwrap_or(0) as u8
}

/// Van der Waals radii by atomic number in hundredths of an ångström; 0 where none is known.
///
/// A. Bondi, *van der Waals Volumes and Radii*, J. Phys. Chem. 68 (1964) 441, tables I, II and V; for
/// elements that he does not list, S. Alvarez, *A cartography of the van der Waals territories*,
/// Dalton Trans. 42 (2013) 8617, table 1. Neither lists promethium, astatine, francium, radium and
/// what follows einsteinium.
const RADII: [u16; 119] = [
    0, 120, 140, 182, 198, 191, 170, 155, 152, 147, 154, 227, 173, 225, 210, 180, 180, 175, 188,
    275, 262, 258, 246, 242, 245, 245, 244, 240, 163, 140, 139, 187, 229, 185, 190, 185, 202, 321,
    284, 275, 252, 256, 245, 244, 246, 244, 163, 172, 158, 193, 217, 247, 206, 198, 216, 348, 303,
    298, 288, 292, 295, 0, 290, 287, 283, 279, 287, 281, 283, 279, 280, 274, 263, 253, 257, 249,
    248, 241, 175, 166, 155, 196, 202, 254, 0, 0, 240, 0, 0, 280, 293, 288, 186, 282, 281, 283,
    305, 340, 305, 270, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
];

/// The radius, in ångström, of atoms whose element is not known: that of carbon.
pub const UNKNOWN_RADIUS: f64 = 1.7;

/// The van der Waals radius of an element in ångström; [`UNKNOWN_RADIUS`] where none is known.
pub fn van_der_waals_radius(atomic_number: u8) -> f64 {
    match RADII.get(usize::from(atomic_number)) {
        None | Some(0) => UNKNOWN_RADIUS,
        Some(&radius) => f64::from(radius) / 100.0,
    }
}

/// The colour of an element in the tradition of Corey, Pauling and Koltun, as 8-bit sRGB: white
/// hydrogen, gray carbon, blue nitrogen, red oxygen, yellow sulfur, orange phosphorus, green
/// halogens, violet alkali metals, …; pink for what has no colour of its own.
pub fn cpk_color(atomic_number: u8) -> [u8; 3] {
    match atomic_number {
        1 => [0xff, 0xff, 0xff],
        6 => [0x85, 0x85, 0x85],
        7 => [0x30, 0x50, 0xf8],
        8 => [0xee, 0x20, 0x10],
        9 | 17 => [0x1f, 0xd0, 0x1f],
        35 => [0x99, 0x22, 0x00],
        53 => [0x66, 0x00, 0xbb],
        2 | 10 | 18 | 36 | 54 | 86 => [0x00, 0xe0, 0xe8],
        15 => [0xff, 0x99, 0x00],
        16 => [0xff, 0xe5, 0x22],
        5 => [0xff, 0xaa, 0x77],
        3 | 11 | 19 | 37 | 55 | 87 => [0x77, 0x00, 0xff],
        4 | 12 | 20 | 38 | 56 | 88 => [0x00, 0x77, 0x00],
        22 => [0x99, 0x99, 0x99],
        26 => [0xdd, 0x77, 0x00],
        _ => [0xdd, 0x77, 0xff],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_are_those_of_the_tables() {
        let of = |symbol: &str| van_der_waals_radius(atomic_number(symbol.as_bytes()));
        // Bondi 1964.
        for (symbol, radius) in [
            ("H", 1.2),
            ("C", 1.7),
            ("O", 1.52),
            ("Cl", 1.75),
            ("I", 1.98),
        ] {
            assert_eq!(of(symbol), radius, "{symbol}");
        }
        for (symbol, radius) in [
            ("Zn", 1.39),
            ("Xe", 2.16),
            ("Pt", 1.75),
            ("Pb", 2.02),
            ("U", 1.86),
        ] {
            assert_eq!(of(symbol), radius, "{symbol}");
        }
        // Alvarez 2013.
        for (symbol, radius) in [
            ("Ca", 2.62),
            ("Fe", 2.44),
            ("Cs", 3.48),
            ("Rn", 2.4),
            ("Es", 2.7),
        ] {
            assert_eq!(of(symbol), radius, "{symbol}");
        }
        for symbol in ["X", "Pm", "Ra", "Og"] {
            assert_eq!(of(symbol), UNKNOWN_RADIUS, "{symbol}");
        }
    }

    #[test]
    fn symbols_and_numbers_name_each_other() {
        for number in 0..119_u8 {
            assert_eq!(atomic_number(symbol(number.into()).as_bytes()), number);
        }
        for (word, number) in [
            ("he", 2),
            ("H12", 1),
            ("Ca2+", 20),
            ("26", 26),
            ("D", 1),
            ("Q", 0),
            ("200", 0),
            ("", 0),
        ] {
            assert_eq!(atomic_number(word.as_bytes()), number, "{word}");
        }
        for odd in [-1.0, 0.5, 119.0, f64::NAN] {
            assert_eq!(symbol(odd), "X");
        }
    }
}

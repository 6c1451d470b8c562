//! Chemical element symbols.

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
pub(super) fn symbol(atomic_number: f64) -> &'static str {
    let index = if atomic_number.fract() == 0.0 {
        atomic_number as usize
    } else {
        0
    };
    SYMBOLS.get(index).copied().unwrap_or("X")
}

/// The atomic number that a word of an XYZ file stands for: a symbol in any case, with digits or
/// signs behind it (`H1`, `C+`), deuterium, or the number itself; 0 for anything else.
pub(super) fn atomic_number(word: &[u8]) -> u8 {
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

#[cfg(test)]
mod tests {
    use super::*;

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

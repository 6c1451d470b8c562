//! The element of an atom whose file does not name it: told by the names of the atom and its residue.

use crate::particles::elements::atomic_number;

/// Residues made of H, C, N, O, S and P alone, where `CA` is a carbon and `HG` a hydrogen.
const ORGANIC: &[&[u8]] = &[
    b"ALA", b"ARG", b"ASN", b"ASP", b"CYS", b"GLN", b"GLU", b"GLY", b"HIS", b"ILE", b"LEU", b"LYS",
    b"MET", b"PHE", b"PRO", b"SER", b"THR", b"TRP", b"TYR", b"VAL", b"ASX", b"GLX", b"SEC", b"PYL",
    b"HSD", b"HSE", b"HSP", b"HID", b"HIE", b"HIP", b"CYX", b"CYM", b"ASH", b"GLH", b"LYN", b"ACE",
    b"NME", b"NMA", b"NH2", b"A", b"C", b"G", b"U", b"T", b"I", b"DA", b"DC", b"DG", b"DT", b"DU",
    b"DI", b"RA", b"RC", b"RG", b"RU", b"ADE", b"CYT", b"GUA", b"URA", b"THY", b"HOH", b"WAT",
    b"SOL", b"H2O", b"DOD", b"SPC", b"TIP", b"TIP3", b"TP3", b"TIP4", b"TP4", b"TIP5", b"TP5",
    b"T3P", b"T4P", b"OPC", b"POPC", b"POPE", b"DPPC", b"DOPC", b"DMPC", b"CHL1", b"DPP",
];

const WATER: &[&[u8]] = &[
    b"HOH", b"WAT", b"SOL", b"H2O", b"SPC", b"TIP4", b"TP4", b"TIP5", b"TP5", b"T4P", b"OPC",
];

/// Ions under the names of CHARMM.
const IONS: &[(&[u8], u8)] = &[
    (b"CLA", 17),
    (b"SOD", 11),
    (b"POT", 19),
    (b"CAL", 20),
    (b"CES", 55),
    (b"LIT", 3),
    (b"RUB", 37),
    (b"BAR", 56),
    (b"CAD", 48),
];

/// Symbols of two letters that a name may start with where nothing shows how it is aligned: none of
/// them is a usual name of a carbon, hydrogen, nitrogen or oxygen.
const DISTINCT: &[&[u8]] = &[
    b"AG", b"AL", b"AR", b"AU", b"BA", b"BR", b"CL", b"CR", b"CU", b"FE", b"KR", b"LI", b"MG",
    b"MN", b"MO", b"PT", b"RB", b"RU", b"SE", b"SI", b"TI", b"XE", b"ZN", b"ZR",
];

/// How a name stands in its columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Alignment {
    /// PDB: four columns, the first two of which hold the symbol, right-aligned.
    Pdb([u8; 4]),
    /// The name alone.
    None,
}

/// The atomic number, 0 when nobody can tell; `None` for a site without an atom, such as the charge
/// sites of water models.
pub(super) fn element(name: &[u8], residue: &[u8], alignment: Alignment) -> Option<u8> {
    let upper = |text: &[u8]| -> Vec<u8> {
        text.iter()
            .filter(|byte| byte.is_ascii_alphanumeric())
            .map(u8::to_ascii_uppercase)
            .collect()
    };
    let (name, residue) = (upper(name), upper(residue));
    let letters: &[u8] = {
        let start = name.iter().position(u8::is_ascii_alphabetic);
        let rest = &name[start.unwrap_or(name.len())..];
        let end = rest.iter().position(u8::is_ascii_digit);
        &rest[..end.unwrap_or(rest.len())]
    };
    let Some(first) = letters.first() else {
        return Some(0);
    };
    if WATER.contains(&&residue[..]) && matches!(letters, b"M" | b"MW" | b"EP" | b"EPW" | b"LP") {
        return None;
    }
    if let Some((_, number)) = IONS.iter().find(|(ion, _)| *ion == letters)
        && residue.starts_with(letters)
    {
        return Some(*number);
    }
    // A residue that is called as its only atom is that element: NA in NA, ZN in ZN2, CL in CL-.
    let residue_letters: Vec<u8> = residue
        .iter()
        .copied()
        .take_while(u8::is_ascii_alphabetic)
        .collect();
    if residue_letters == letters && letters.len() == 2 && atomic_number(letters) > 0 {
        return Some(atomic_number(letters));
    }
    if ORGANIC.contains(&&residue[..]) && b"HCNOSPD".contains(first) {
        return Some(atomic_number(&[*first]));
    }
    let two = &letters[..letters.len().min(2)];
    let is_two = match alignment {
        Alignment::Pdb([a, b, _, last]) => {
            let is_long_hydrogen = a.eq_ignore_ascii_case(&b'H') && last != b' ';
            a.is_ascii_alphabetic() && b.is_ascii_alphabetic() && !is_long_hydrogen
        }
        Alignment::None => DISTINCT.contains(&two),
    };
    if is_two && two.len() == 2 && atomic_number(two) > 0 {
        return Some(atomic_number(two));
    }
    Some(atomic_number(&[*first]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn aligned(name: &[u8; 4], residue: &str) -> Option<u8> {
        element(name, residue.as_bytes(), Alignment::Pdb(*name))
    }

    #[test]
    fn columns_tell_calcium_from_carbon() {
        for (name, residue, number) in [
            (b" CA ", "GLY", 6),
            (b"CA  ", "CA", 20),
            (b"CA  ", "GLY", 6),
            (b"HG11", "VAL", 1),
            (b"HG  ", "HG", 80),
            (b"HE21", "LIG", 1),
            (b"1HB ", "ALA", 1),
            (b"FE  ", "HEM", 26),
            (b" NA ", "HEM", 7),
            (b"NA  ", "NA", 11),
            (b" CLA", "CLA", 17),
            (b" SOD", "SOD", 11),
            (b" POT", "POT", 19),
            (b"SE  ", "MSE", 34),
            (b" CD1", "LIG", 6),
            (b"CL1 ", "LIG", 17),
            (b" P  ", "DG", 15),
            (b"ZN  ", "ZN2", 30),
            (b" Q  ", "LIG", 0),
            (b" 12 ", "LIG", 0),
        ] {
            let found = aligned(name, residue);
            assert_eq!(found, Some(number), "{:?} {residue}", name.escape_ascii());
        }
    }

    #[test]
    fn names_without_columns_are_read_with_care() {
        for (name, residue, number) in [
            ("CA", "ASN", Some(6)),
            ("OW", "SOL", Some(8)),
            ("HW1", "SOL", Some(1)),
            ("MW", "SOL", None),
            ("NA", "NA", Some(11)),
            ("CL", "CL", Some(17)),
            ("CL-", "CL-", Some(17)),
            ("BR2", "LIG", Some(35)),
            ("CD1", "LIG", Some(6)),
            ("", "LIG", Some(0)),
        ] {
            let found = element(name.as_bytes(), residue.as_bytes(), Alignment::None);
            assert_eq!(found, number, "{name} {residue}");
        }
    }
}

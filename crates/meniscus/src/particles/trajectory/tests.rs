use super::*;
use crate::particles::io;
use std::io::Write;

const ATOMS: usize = 12;

/// Where atom `atom` stands in frame `frame`, in ångström: multiples of 0.01.
fn position(atom: usize, frame: usize) -> DVec3 {
    let (atom, frame) = (atom as f64, frame as f64);
    DVec3::new(
        1.25 * atom - 3.0,
        0.5 * frame - 0.25 * atom,
        0.07 * atom * frame - 1.0,
    )
}

fn file_of(bytes: &[u8]) -> tempfile::NamedTempFile {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(bytes).unwrap();
    file
}

fn put(bytes: &mut Vec<u8>, numbers: &[i32]) {
    bytes.extend(numbers.iter().flat_map(|number| number.to_be_bytes()));
}

fn trr(frames: usize, is_double: bool, has_velocities: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    let real = if is_double { 8 } else { 4 };
    let vectors = (3 * ATOMS * real) as i32;
    let put_real = |bytes: &mut Vec<u8>, value: f64| {
        if is_double {
            bytes.extend(value.to_be_bytes());
        } else {
            bytes.extend((value as f32).to_be_bytes());
        }
    };
    for frame in 0..frames {
        put(&mut bytes, &[1993, 13, 12]);
        bytes.extend(b"GMX_trn_file");
        let velocities = if has_velocities { vectors } else { 0 };
        put(
            &mut bytes,
            &[0, 0, 9 * real as i32, 0, 0, 0, 0, vectors, velocities, 0],
        );
        put(&mut bytes, &[ATOMS as i32, frame as i32, 0]);
        for value in [2.0 * frame as f64, 0.0].into_iter().chain([1.0; 9]) {
            put_real(&mut bytes, value);
        }
        for factor in [0.1, -0.2]
            .into_iter()
            .take(1 + usize::from(has_velocities))
        {
            for atom in 0..ATOMS {
                for value in (position(atom, frame) * factor).to_array() {
                    put_real(&mut bytes, value);
                }
            }
        }
    }
    bytes
}

/// `moving` atoms from the first on move; with a unit cell in every frame.
fn dcd(frames: usize, is_wide: bool, is_little: bool, moving: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let number = |value: u32| {
        if is_little {
            value.to_le_bytes()
        } else {
            value.to_be_bytes()
        }
    };
    let mark = |length: usize| {
        let length = length as u64;
        match (is_wide, is_little) {
            (true, true) => length.to_le_bytes().to_vec(),
            (true, false) => length.to_be_bytes().to_vec(),
            (false, _) => number(length as u32).to_vec(),
        }
    };
    let mut record = |content: &[u8]| {
        bytes.extend(mark(content.len()));
        bytes.extend(content);
        bytes.extend(mark(content.len()));
    };
    let mut header = b"CORD".to_vec();
    let mut numbers = [0_u32; 20];
    (numbers[8], numbers[10], numbers[19]) = ((ATOMS - moving) as u32, 1, 24);
    header.extend(numbers.iter().flat_map(|&n| number(n)));
    record(&header);
    record(&[&number(1)[..], &[b' '; 80]].concat());
    record(&number(ATOMS as u32));
    if moving < ATOMS {
        let free: Vec<u8> = (1..=moving as u32).flat_map(number).collect();
        record(&free);
    }
    for frame in 0..frames {
        record(&[0; 48]);
        for axis in 0..3 {
            let atoms = if frame == 0 { ATOMS } else { moving };
            let values = (0..atoms).map(|atom| position(atom, frame)[axis] as f32);
            record(
                &values
                    .flat_map(|value| number(value.to_bits()))
                    .collect::<Vec<u8>>(),
            );
        }
    }
    bytes
}

/// Writes bits, the highest first.
#[derive(Default)]
struct BitWriter {
    bytes: Vec<u8>,
    used: u32,
}

impl BitWriter {
    fn put(&mut self, value: u128, count: u32) {
        for bit in (0..count).rev() {
            if self.used.is_multiple_of(8) {
                self.bytes.push(0);
            }
            let last = self.bytes.last_mut().unwrap();
            *last |= ((value >> bit & 1) as u8) << (7 - self.used % 8);
            self.used += 1;
        }
    }

    /// Digits of a mixed base, the lowest byte first.
    fn put_three(&mut self, digits: [i64; 3], sizes: [u64; 3], bits: u32) {
        let [x, y, z] = digits.map(|digit| u128::try_from(digit).unwrap());
        let value = (x * u128::from(sizes[1]) + y) * u128::from(sizes[2]) + z;
        let mut shift = 0;
        while shift < bits {
            let count = (bits - shift).min(8);
            self.put(value >> shift & 0xff, count);
            shift += 8;
        }
    }
}

/// Positions in hundredths of an ångström, the smallest step of precision 1000 per nm; those of `runs`
/// atoms after every fourth one are packed as steps.
fn xtc(frames: usize, magic: i32, runs: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    for frame in 0..frames {
        put(&mut bytes, &[magic, ATOMS as i32, frame as i32]);
        bytes.extend((frame as f32).to_be_bytes());
        bytes.extend([0; 36]);
        put(&mut bytes, &[ATOMS as i32]);
        bytes.extend(1000_f32.to_be_bytes());
        let steps: Vec<[i64; 3]> = (0..ATOMS)
            .map(|atom| {
                position(atom, frame)
                    .to_array()
                    .map(|x| (x * 100.0).round() as i64)
            })
            .collect();
        let bound = |pick: fn(i64, i64) -> i64| {
            [0, 1, 2].map(|axis| steps.iter().map(|s| s[axis]).reduce(pick).unwrap())
        };
        let (least, greatest) = (bound(i64::min), bound(i64::max));
        put(&mut bytes, &least.map(|x| x as i32));
        put(&mut bytes, &greatest.map(|x| x as i32));
        // Steps of up to 512, which 27 bits hold.
        let range = 27;
        put(&mut bytes, &[range]);
        let sizes = [0, 1, 2].map(|axis| (greatest[axis] - least[axis] + 1) as u64);
        let whole = bits_of(sizes);
        let mut packed = BitWriter::default();
        let mut atom = 0;
        while atom < ATOMS {
            let length = if runs { 3.min(ATOMS - 1 - atom) } else { 0 };
            // The position stored by itself is the second one of a run.
            let by_itself = steps[if length > 0 { atom + 1 } else { atom }];
            let offset = [0, 1, 2].map(|axis| by_itself[axis] - least[axis]);
            packed.put_three(offset, sizes, whole);
            packed.put(1, 1);
            packed.put(3 * length as u128 + 1, 5);
            let order = [atom, atom + 2, atom + 3];
            let mut before = by_itself;
            for &next in &order[..length] {
                let half = i64::from(512 / 2);
                let step = [0, 1, 2].map(|axis| steps[next][axis] - before[axis] + half);
                packed.put_three(step, [512; 3], range as u32);
                before = steps[next];
            }
            atom += 1 + length;
        }
        let length = packed.bytes.len();
        if magic == 2023 {
            bytes.extend((length as u64).to_be_bytes());
        } else {
            put(&mut bytes, &[length as i32]);
        }
        packed.bytes.resize(length.next_multiple_of(4), 0);
        bytes.extend(packed.bytes);
    }
    bytes
}

fn bits_of(sizes: [u64; 3]) -> u32 {
    let product: u128 = sizes.map(u128::from).iter().product();
    u128::BITS - product.leading_zeros()
}

fn assert_frames(bytes: &[u8], format: TrajectoryFormat, tolerance: f64) {
    let file = file_of(bytes);
    let trajectory = Trajectory::open(file.path()).unwrap();
    assert_eq!(trajectory.format(), format);
    assert_eq!((trajectory.atoms(), trajectory.len()), (ATOMS, 3));
    assert!(trajectory.warnings().is_empty());
    // In any order.
    for frame in [2, 0, 1] {
        let read = trajectory.read(frame).unwrap();
        for (atom, found) in read.positions.iter().enumerate() {
            let off = (*found - position(atom, frame)).length();
            assert!(
                off <= tolerance,
                "{format:?} frame {frame} atom {atom}: {found}"
            );
        }
    }
    assert!(
        trajectory
            .read(3)
            .unwrap_err()
            .to_string()
            .contains("3 frames")
    );
}

#[test]
fn every_kind_of_file_gives_its_positions_in_any_order() {
    for is_double in [false, true] {
        for has_velocities in [false, true] {
            assert_frames(
                &trr(3, is_double, has_velocities),
                TrajectoryFormat::Trr,
                1e-5,
            );
        }
    }
    for is_wide in [false, true] {
        for is_little in [false, true] {
            assert_frames(
                &dcd(3, is_wide, is_little, ATOMS),
                TrajectoryFormat::Dcd,
                1e-5,
            );
        }
    }
    for magic in [1995, 2023] {
        for runs in [false, true] {
            // The format's own rounding aside.
            assert_frames(&xtc(3, magic, runs), TrajectoryFormat::Xtc, 0.006);
        }
    }
}

#[test]
fn velocities_and_moments_are_read() {
    let file = file_of(&trr(2, false, true));
    let read = Trajectory::open(file.path()).unwrap().read(1).unwrap();
    assert_eq!(read.time_ps, Some(2.0));
    let velocities = read.velocities.unwrap();
    for (atom, velocity) in velocities.iter().enumerate() {
        assert!((*velocity + position(atom, 1) * 2.0).length() < 1e-4);
    }
    let file = file_of(&xtc(3, 1995, true));
    let read = Trajectory::open(file.path()).unwrap().read(2).unwrap();
    assert_eq!((read.time_ps, read.velocities), (Some(2.0), None));
}

#[test]
fn atoms_that_do_not_move_come_from_the_first_frame() {
    let file = file_of(&dcd(3, false, true, 5));
    let trajectory = Trajectory::open(file.path()).unwrap();
    assert_eq!(trajectory.len(), 3);
    let read = trajectory.read(2).unwrap();
    for atom in 0..ATOMS {
        let frame = if atom < 5 { 2 } else { 0 };
        assert!(
            (read.positions[atom] - position(atom, frame)).length() < 1e-5,
            "{atom}"
        );
    }
}

#[test]
fn a_run_that_was_stopped_leaves_its_whole_frames() {
    for bytes in [
        trr(3, false, false),
        dcd(3, false, true, ATOMS),
        xtc(3, 1995, true),
    ] {
        let file = file_of(&bytes[..bytes.len() - 7]);
        let trajectory = Trajectory::open(file.path()).unwrap();
        assert_eq!(trajectory.len(), 2);
        assert!(trajectory.warnings()[0].contains("no whole frame"));
        let file = file_of(&bytes[..bytes.len() / 5]);
        Trajectory::open(file.path()).unwrap_err();
    }
}

#[test]
fn damage_is_an_error_and_never_a_panic() {
    for bytes in [
        trr(2, true, true),
        dcd(2, false, true, 4),
        dcd(2, true, false, ATOMS),
        xtc(2, 1995, true),
        xtc(2, 2023, false),
    ] {
        for at in 0..bytes.len() {
            for value in [0, 0x7f, 0xff, bytes[at] ^ 0x10] {
                let mut damaged = bytes.clone();
                damaged[at] = value;
                let file = file_of(&damaged);
                if let Ok(trajectory) = Trajectory::open(file.path()) {
                    for frame in 0..trajectory.len().min(3) {
                        let _ = trajectory.read(frame);
                    }
                }
            }
        }
    }
}

#[test]
fn a_topology_gives_the_columns_and_the_unit() {
    let mut pdb = String::new();
    let mut gro = format!("title\n{ATOMS}\n");
    for atom in 0..ATOMS {
        let serial = atom + 1;
        pdb += &format!(
            "ATOM  {serial:5}  CA  ALA A{serial:4}       0.000   0.000   0.000  1.00  0.00           C\n"
        );
        gro += &format!(
            "{serial:5}ALA     CA{serial:5}   0.000   0.000   0.000  1.0000  1.0000  1.0000\n"
        );
    }
    gro += "1 1 1\n";
    let file = file_of(&trr(2, false, true));
    let trajectory = Trajectory::open(file.path()).unwrap();
    for (text, unit) in [(&pdb, 1.0), (&gro, 0.1)] {
        let topology = file_of(text.as_bytes());
        let topology = io::read(topology.path(), 0).unwrap();
        let (particles, time_ps) = trajectory.over(&topology, 1).unwrap();
        assert_eq!(time_ps, Some(2.0));
        for (atom, found) in particles.positions.iter().enumerate() {
            assert!((*found - position(atom, 1) * unit).length() < 1e-5);
        }
        assert!(particles.column("atomic_number").is_some());
        let velocities = particles.column("velocity").unwrap();
        assert!((velocities.get(3, 0) + position(3, 1).x * 2.0 * unit).abs() < 1e-4);
    }
    let fewer = file_of(
        pdb.split_inclusive('\n')
            .skip(1)
            .collect::<String>()
            .as_bytes(),
    );
    let fewer = io::read(fewer.path(), 0).unwrap();
    let error = trajectory.over(&fewer, 0).unwrap_err().to_string();
    assert!(
        error.contains("12 atoms") && error.contains("has 11"),
        "{error}"
    );
}

//! Real VTK files, held against what PyPI `vtk` 9.7.2 reads from them (`meshio` agrees wherever it can
//! read the file). The hashes are FNV-1a (64 bits) over all values as little-endian f64.

use meniscus::particles::io::{Format, ParseError, Place, ReadError, read};
use meniscus_testing::data;

struct Expected {
    file: &'static str,
    count: usize,
    positions: u64,
    first: [f64; 3],
    /// Name, type, components, hash.
    columns: &'static [(&'static str, &'static str, usize, u64)],
}

#[rustfmt::skip]
const EXPECTED: &[Expected] = &[
    Expected { file: "fluid/pysph/sph.vtk.gz", count: 3993, positions: 0x24f4_162c_ac31_a68f, first: [2.1, -0.1, 0.02], columns: &[] },
    Expected { file: "fluid/splashsurf/ParticleData_Fluid_5.vtk", count: 4732, positions: 0x0ebf_c5de_5dc0_b54d, first: [0.8229686617851257, 0.04062836617231369, 0.8229687213897705], columns: &[("id", "u32", 1, 0xfdf9_44a0_4538_ba74), ("velocity", "f32", 3, 0xffa6_f238_7584_5bd6)] },
    Expected { file: "fluid/splashsurf/bunny_frame_14_7705_particles.vtk", count: 7706, positions: 0xaa2f_482a_e741_4a68, first: [0.12854121625423431, 0.8383985757827759, 0.11624263226985931], columns: &[("id", "u32", 1, 0xb227_c486_2616_1f0f), ("velocity", "f32", 3, 0xa81d_07c6_b8f7_6b9f)] },
    Expected { file: "fluid/splashsurf/cube_2366_particles.vtk", count: 2366, positions: 0x75a7_daaf_31ba_fac0, first: [0.8500000238418579, 0.09999018907546997, 0.8500000238418579], columns: &[] },
    Expected { file: "fluid/splashsurf/double_dam_break_frame_01_4732_particles.vtk", count: 4732, positions: 0x3b8b_2468_dc0b_07e9, first: [0.8500000238418579, 0.09999018907546997, 0.8500000238418579], columns: &[("id", "u32", 1, 0x5672_475f_e492_b198), ("velocity", "f32", 3, 0x6a34_ff4f_cce1_58e5)] },
    Expected { file: "fluid/splashsurf/double_dam_break_frame_26_4732_particles.vtk", count: 4732, positions: 0x413e_b26e_8417_78e6, first: [0.002692208159714937, 0.2675342559814453, 0.03149385750293732], columns: &[("id", "u32", 1, 0x444a_eab7_8a55_15dc), ("velocity", "f32", 3, 0xb4a5_9c3f_be07_392a)] },
    Expected { file: "fluid/splashsurf/free_particles_125_particles.vtk", count: 125, positions: 0x7820_90f6_2ee1_4034, first: [158.80352783203125, 29.653087615966797, 131.12979125976562], columns: &[] },
    Expected { file: "fluid/splashsurf/sailors_knot_19539_particles.vtk", count: 19539, positions: 0xb6cb_a59d_0101_b52a, first: [0.0684703066945076, -0.7429585456848145, -0.6547190546989441], columns: &[("id", "u32", 1, 0x7d9a_2fbc_23d9_d7f7)] },
    Expected { file: "fluid/splishsplash_crown/ParticleData_Fluid_36.vtk", count: 55760, positions: 0x69e3_436c_dfda_3146, first: [0.14938341081142426, 0.08851621299982071, 0.13222913444042206], columns: &[("id", "u32", 1, 0xc8a6_e289_ba33_4f10), ("velocity", "f32", 3, 0x467f_8dee_fba3_c829), ("density", "f32", 1, 0xe7db_ac43_c0d3_a1ec)] },
    Expected { file: "fluid/splishsplash_crown/ParticleData_Fluid_40.vtk", count: 55760, positions: 0x6ccd_bb5e_ae3e_7488, first: [0.2543438673019409, 0.07813738286495209, 0.2276894599199295], columns: &[("id", "u32", 1, 0xc8a6_e289_ba33_4f10), ("velocity", "f32", 3, 0xe42b_b9f5_9189_f8be), ("density", "f32", 1, 0xadb4_f90b_8ecf_f025)] },
    Expected { file: "fluid/splishsplash_crown/ParticleData_Fluid_41.vtk", count: 55760, positions: 0x84da_ff0c_b0f3_0327, first: [0.2814141809940338, 0.07974404841661453, 0.252404123544693], columns: &[("id", "u32", 1, 0xc8a6_e289_ba33_4f10), ("velocity", "f32", 3, 0xc781_0dd6_3b68_47cd), ("density", "f32", 1, 0x5a42_c69d_e787_4398)] },
    Expected { file: "fluid/splishsplash_crown/ParticleData_Fluid_44.vtk", count: 55760, positions: 0xc24e_2c17_57e1_dc7b, first: [0.16372454166412354, 0.10189315676689148, 0.11604220420122147], columns: &[("id", "u32", 1, 0xc394_b14c_ddbe_6a08), ("velocity", "f32", 3, 0x2e8a_6a53_3a69_11ac), ("density", "f32", 1, 0x0733_3af7_bd7f_cea2)] },
    Expected { file: "tricky/splashsurf/cube_8_particles.vtu", count: 8, positions: 0x1803_1f4f_84e2_107d, first: [0.5, 0.49950949999999966, 0.5], columns: &[("velocity", "f64", 3, 0xc873_714a_e5f0_c36d), ("pressure", "f64", 1, 0xb9b2_3f3a_46fd_0825), ("density", "f64", 1, 0xc44d_a5e5_2f54_4b35), ("index", "i64", 1, 0xce39_d4e4_0706_c610)] },
    Expected { file: "tricky/splashsurf/fluid_250_particles.vtu", count: 250, positions: 0x0b31_5b04_9524_b5d0, first: [0.3286479863716946, 0.21009526877553064, 0.2049105240508048], columns: &[("velocity", "f64", 3, 0x00bc_5e8e_a34b_4828), ("pressure", "f64", 1, 0xf1d1_8df1_90f3_718e), ("density", "f64", 1, 0x155b_8700_d084_b04e), ("index", "i64", 1, 0x7bac_acae_1e01_f2b7)] },
    Expected { file: "tricky/splashsurf/fluid_encoded_250_particles.vtu", count: 250, positions: 0x0b31_5b04_9524_b5d0, first: [0.3286479863716946, 0.21009526877553064, 0.2049105240508048], columns: &[("velocity", "f64", 3, 0x00bc_5e8e_a34b_4828), ("pressure", "f64", 1, 0xf1d1_8df1_90f3_718e), ("density", "f64", 1, 0x155b_8700_d084_b04e), ("index", "i64", 1, 0x7bac_acae_1e01_f2b7)] },
    Expected { file: "tricky/vtkio/hexahedron.vtu", count: 8, positions: 0x0293_7131_b0be_26e5, first: [0.0, 0.0, 0.0], columns: &[] },
    Expected { file: "tricky/vtkio/hexahedron_ascii.vtu", count: 8, positions: 0x0293_7131_b0be_26e5, first: [0.0, 0.0, 0.0], columns: &[("uint8x1", "u8", 1, 0xd0a6_b05d_9979_f965), ("uint16x1", "u16", 1, 0xd0a6_b05d_9979_f965), ("int32x1", "i32", 1, 0xd0a6_b05d_9979_f965), ("int64x1", "i32", 1, 0xd0a6_b05d_9979_f965), ("float32x1", "f32", 1, 0xcb67_cc20_fb47_1188), ("float64x1", "f64", 1, 0xcb67_cc20_fb47_1188)] },
    Expected { file: "tricky/vtkio/hexahedron_binary.vtu", count: 8, positions: 0x0293_7131_b0be_26e5, first: [0.0, 0.0, 0.0], columns: &[] },
    Expected { file: "tricky/vtkio/hexahedron_inline_binary.vtu", count: 8, positions: 0x0293_7131_b0be_26e5, first: [0.0, 0.0, 0.0], columns: &[("uint8x1", "u8", 1, 0xd0a6_b05d_9979_f965), ("uint16x1", "u16", 1, 0xd0a6_b05d_9979_f965), ("int32x1", "i32", 1, 0xd0a6_b05d_9979_f965), ("int64x1", "i32", 1, 0xd0a6_b05d_9979_f965), ("float32x1", "f32", 1, 0xcb67_cc20_fb47_1188), ("float64x1", "f64", 1, 0xcb67_cc20_fb47_1188)] },
    Expected { file: "tricky/vtkio/hexahedron_lz4.vtu", count: 8, positions: 0x0293_7131_b0be_26e5, first: [0.0, 0.0, 0.0], columns: &[] },
    Expected { file: "tricky/vtkio/hexahedron_zlib.vtu", count: 8, positions: 0x0293_7131_b0be_26e5, first: [0.0, 0.0, 0.0], columns: &[] },
    Expected { file: "tricky/vtkio/point.vtp", count: 1, positions: 0x81d2_3fd7_003c_2305, first: [0.0, 0.0, 0.0], columns: &[] },
    Expected { file: "tricky/vtkio/point_ascii.vtp", count: 1, positions: 0x81d2_3fd7_003c_2305, first: [0.0, 0.0, 0.0], columns: &[] },
    Expected { file: "tricky/vtkio/point_cloud.vtk", count: 3, positions: 0xc597_2b94_cfa1_9925, first: [0.0, 0.0, 0.0], columns: &[] },
    Expected { file: "tricky/vtkio/point_cloud.vtp", count: 3, positions: 0xc597_2b94_cfa1_9925, first: [0.0, 0.0, 0.0], columns: &[] },
    Expected { file: "tricky/vtkio/pygmsh/ascii.vtk", count: 18, positions: 0x149b_335f_854d_e8d8, first: [0.0, 0.0, 0.0], columns: &[] },
    Expected { file: "tricky/vtkio/pygmsh/binary.vtk", count: 18, positions: 0x149b_335f_854d_e8d8, first: [0.0, 0.0, 0.0], columns: &[] },
    Expected { file: "tricky/vtkio/structured_grid.vtk", count: 8, positions: 0x8bb0_a0fc_71b2_6ed1, first: [0.0, 0.20000000298023224, 0.0], columns: &[("ptval", "f32", 1, 0x2006_2299_e182_7990), ("ptvec", "f32", 3, 0xcf0e_ef04_51d9_bd45)] },
    Expected { file: "tricky/vtkio/triangle_vtkidtype.vtk", count: 3, positions: 0x8b47_5b2b_efbc_6b20, first: [1.837499976158142, 2.9874446392059326, 0.23750001192092896], columns: &[("vtkOriginalPointIds", "i32", 1, 0xdd9d_218d_84ae_7013)] },
];

fn fnv(values: impl Iterator<Item = f64>) -> u64 {
    values
        .flat_map(f64::to_le_bytes)
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
}

#[test]
fn real_files_read_as_vtk_reads_them() {
    for expected in EXPECTED {
        let file = expected.file;
        let Some(path) = data::file(file) else { return };
        let found = read(&path, 0).unwrap_or_else(|error| panic!("{file}: {error}"));
        let legacy = file.contains(".vtk");
        assert_eq!(found.format == Format::VtkLegacy, legacy, "{file}");
        assert_eq!(found.frames, 1, "{file}");
        assert!(found.warnings.is_empty(), "{file}: {:?}", found.warnings);
        let particles = found.particles;
        assert_eq!(particles.len(), expected.count, "{file}");
        assert_eq!(particles.positions[0].to_array(), expected.first, "{file}");
        let positions = particles.positions.iter().flat_map(|p| p.to_array());
        assert_eq!(fnv(positions), expected.positions, "{file}");
        let columns: Vec<_> = particles
            .columns
            .iter()
            .map(|column| {
                let values = (0..column.data.len()).map(|i| column.data.get(i));
                let kind = column.data.type_name();
                (column.name.as_str(), kind, column.components, fnv(values))
            })
            .collect();
        assert_eq!(columns, expected.columns, "{file}");
    }
}

#[test]
fn a_field_without_points_is_refused() {
    let Some(path) = data::file("tricky/vtkio/field.vtk") else {
        return;
    };
    let error = read(&path, 0).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("field.vtk") && text.contains("no POINTS section"),
        "{text}"
    );
    let ReadError::Malformed {
        error: ParseError { place, help, .. },
        ..
    } = error
    else {
        panic!("{text}");
    };
    assert!(matches!(place, Place::Line(_)) && help.is_some(), "{text}");
}

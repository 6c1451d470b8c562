//! Fields of real frames: the columns found, the spacing, the surface around the particles.

use meniscus::field::{BlobField, SupportSource};
use meniscus::math::ray::Side;
use meniscus::particles::filter::Filter;
use meniscus::particles::io::read;
use meniscus::particles::spacing::median_spacing;
use meniscus::particles::{Particles, Role};
use meniscus::scene::surface::BlobSettings;
use meniscus_testing::data;

/// Path, particles, and the median nearest-neighbour distance from a k-d tree of another program.
const FILES: [(&str, usize, f64); 8] = [
    ("fluid/splashsurf/cube_2366_particles.vtk", 2366, 0.05),
    (
        "fluid/splashsurf/double_dam_break_frame_26_4732_particles.vtk",
        4732,
        0.03783,
    ),
    (
        "fluid/splashsurf/free_particles_125_particles.vtk",
        125,
        0.7951,
    ),
    ("fluid/splishsplash/sphere.bgeo", 12394, 0.02644),
    (
        "fluid/splishsplash_crown/ParticleData_Fluid_36.vtk",
        55760,
        0.03677,
    ),
    (
        "fluid/splishsplash_crown/ParticleData_Fluid_44.vtk",
        55760,
        0.03462,
    ),
    ("fluid/pysph/sph.vtk.gz", 3993, 0.01603),
    (
        "anisotropic/mpm_water_snow_jelly/wsj_065.ply",
        65536,
        0.005157,
    ),
];

fn particles(path: &str) -> Option<Particles> {
    let file = data::file(path)?;
    Some(read(&file, 0).unwrap().particles)
}

#[test]
fn spacing_agrees_with_another_program() {
    for (path, count, nearest) in FILES {
        let Some(particles) = particles(path) else {
            continue;
        };
        assert_eq!(particles.len(), count, "{path}");
        let spacing = median_spacing(&particles.positions).unwrap();
        assert!(
            (spacing / nearest - 1.0).abs() < 2e-3,
            "{path}: {spacing} for {nearest}"
        );
    }
}

#[test]
fn default_settings_put_particles_inside_their_surface() {
    for (path, count, _) in FILES {
        let Some(particles) = particles(path) else {
            continue;
        };
        let build = BlobField::from_particles(&particles, &BlobSettings::default()).unwrap();
        let field = &build.field;
        assert_eq!((field.len(), build.report.dropped), (count, 0), "{path}");
        let inside = (0..field.len())
            .filter(|&i| field.side(field.center(i).as_dvec3()) == Side::Inside)
            .count();
        assert!(
            inside * 10 > count * 9,
            "{path}: {inside} of {count} inside"
        );
        let most = (0..field.len())
            .map(|i| field.value(field.center(i).as_dvec3()))
            .fold(0.0, f64::max);
        assert!(most < 2.5, "{path}: F reaches {most}");
    }
}

#[test]
fn columns_of_simulations_play_their_roles() {
    if let Some(sphere) = particles("fluid/splishsplash/sphere.bgeo") {
        let build = BlobField::from_particles(&sphere, &BlobSettings::default()).unwrap();
        let source = SupportSource::Column("pscale".to_owned());
        assert_eq!(build.report.support_source, source);
        assert!(sphere.role(Role::Id).is_some());
    }
    if let Some(crown) = particles("fluid/splishsplash_crown/ParticleData_Fluid_44.vtk") {
        assert_eq!(crown.role(Role::Velocity).unwrap().components(), 3);
        let filter = Filter::parse("|velocity| > 0.5 && y < 1 || density > 1100").unwrap();
        let keep = filter.keep(&crown).unwrap();
        let velocity = crown.column("velocity").unwrap();
        let density = crown.column("density").unwrap();
        for (i, keep) in keep.into_iter().enumerate() {
            let square: f64 = (0..3).map(|c| velocity.get(i, c).powi(2)).sum();
            let expected =
                (square.sqrt() > 0.5 && crown.positions[i].y < 1.0) || density.get(i, 0) > 1100.0;
            assert_eq!(keep, expected, "particle {i}");
        }
    }
    if let Some(mpm) = particles("anisotropic/mpm_water_snow_jelly/wsj_065.ply") {
        assert_eq!(mpm.role(Role::Velocity).unwrap().components(), 3);
        assert_eq!(mpm.attribute("F").unwrap().components(), 9);
        assert!(mpm.role(Role::Metric).is_none());
        let missing = mpm.attribute("materiel").unwrap_err();
        assert_eq!(missing.nearest.as_deref(), Some("material"));
    }
}

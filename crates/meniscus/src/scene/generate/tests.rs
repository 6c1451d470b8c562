use super::*;
use crate::math::aabb::DAabb;
use crate::scene::camera::Camera;
use glam::DVec3;

const COUNTS: [usize; 4] = [1, 7, 500, 5_440];

#[test]
fn every_generator_makes_exactly_the_count_for_any_count() {
    for generator in Generator::ALL {
        for count in COUNTS {
            let particles = generator.generate(count, 3, None).unwrap().particles;
            assert_eq!(particles.len(), count, "{}", generator.name());
            assert_eq!(particles.rows.len(), count);
            for column in &particles.columns {
                assert_eq!(column.rows(), count, "{} {}", generator.name(), column.name);
            }
            for p in &particles.positions {
                assert!(p.is_finite(), "{}: {p}", generator.name());
                assert_eq!(p.as_vec3().as_dvec3(), *p, "not an f32");
            }
        }
    }
}

#[test]
fn the_seed_decides_everything() {
    for generator in Generator::ALL {
        let one = generator.generate(400, 5, None).unwrap();
        assert_eq!(one, generator.generate(400, 5, None).unwrap());
        let other = generator.generate(400, 6, None).unwrap();
        assert_ne!(
            one.particles.positions,
            other.particles.positions,
            "{}",
            generator.name()
        );
    }
}

#[test]
fn impossible_counts_are_refused() {
    for count in [0, MAX_COUNT + 1] {
        assert_eq!(
            Generator::Pool.generate(count, 0, None),
            Err(GenerateError::Count { count })
        );
    }
}

#[test]
fn the_camera_holds_the_set() {
    for generator in [Generator::Scattered, Generator::Pool, Generator::Molecule] {
        let Generated { particles, scene } = generator.generate(2_000, 1, None).unwrap();
        let camera = Camera::from_settings(&scene.camera, DAabb::EMPTY, [400, 300]).unwrap();
        for p in &particles.positions {
            let [x, y] = camera.project(*p).unwrap();
            assert!((-10.0..=410.0).contains(&x) && (-10.0..=310.0).contains(&y));
        }
    }
}

#[test]
fn moving_particles_fly_on_the_parabolas_that_their_columns_state() {
    for generator in [Generator::Fountain, Generator::Splash] {
        assert!(generator.is_animated());
        let frames: Vec<Generated> = (3..5)
            .map(|frame| generator.generate(3_000, 2, Some(frame)).unwrap())
            .collect();
        assert_eq!(frames[0].scene, frames[1].scene);
        let (now, next) = (&frames[0].particles, &frames[1].particles);
        let vector = |name: &str, row: usize| {
            let column = now.column(name).unwrap();
            DVec3::new(column.get(row, 0), column.get(row, 1), column.get(row, 2))
        };
        let ids = |particles: &Particles, row: usize| particles.column("id").unwrap().get(row, 0);
        let dt = 1.0 / FRAMES_PER_SECOND;
        let mut flying = 0;
        for row in 0..now.len() {
            let acceleration = vector("acceleration", row);
            let still_flies = next.column("acceleration").unwrap().get(row, 1) != 0.0;
            if acceleration == DVec3::ZERO || !still_flies || ids(now, row) != ids(next, row) {
                continue;
            }
            flying += 1;
            let expected =
                now.positions[row] + vector("velocity", row) * dt + acceleration * (0.5 * dt * dt);
            assert!(
                expected.distance(next.positions[row]) < 2e-6,
                "{}: {expected} {}",
                generator.name(),
                next.positions[row]
            );
        }
        assert!(flying > 800, "{}: only {flying} fly", generator.name());
    }
}

#[test]
fn atoms_of_the_molecule_keep_chemical_distances() {
    let particles = Generator::Molecule
        .generate(2_000, 1, None)
        .unwrap()
        .particles;
    let radius = particles.column("radius").unwrap();
    let mut sum = 0.0;
    for (i, p) in particles.positions.iter().enumerate() {
        let nearest = (particles.positions.iter().enumerate())
            .filter(|&(j, _)| j != i)
            .map(|(_, q)| p.distance(*q))
            .fold(f64::INFINITY, f64::min);
        assert!(nearest > 0.4 && nearest < 3.0, "atom {i}: {nearest}");
        assert!((1.5..=1.8).contains(&radius.get(i, 0)));
        sum += nearest;
    }
    let mean = sum / particles.len() as f64;
    assert!((1.1..1.5).contains(&mean), "mean bond {mean}");
}

#[test]
fn scenes_are_valid_and_name_their_file() {
    for generator in Generator::ALL {
        let scene = generator
            .generate(100, 1, None)
            .unwrap()
            .scene_of("here.vtk");
        assert_eq!(scene.surfaces[0].file, PathBuf::from("here.vtk"));
        let text = toml::to_string(&scene).unwrap();
        assert_eq!(toml::from_str::<Scene>(&text).unwrap(), scene, "{text}");
    }
}

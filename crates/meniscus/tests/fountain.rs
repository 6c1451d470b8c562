//! A fountain whose particles fly on parabolas: moments between frames, and rays while the shutter is
//! open, against the closed form.

use meniscus::accel::Engine;
use meniscus::field::BlobField;
use meniscus::frame::{Frame, FrameSettings};
use meniscus::intersect::Scratch;
use meniscus::math::DVec3;
use meniscus::math::ray::Ray;
use meniscus::particles::between::{BetweenSettings, Identity, Moment, Pair};
use meniscus::particles::{Column, Particles, Role};
use meniscus::scene::generate::{FRAMES_PER_SECOND, Generator};
use meniscus::scene::{BlobSettings, Scene, Surface, Weights};
use std::collections::HashMap;
use std::sync::Arc;

const COUNT: usize = 3000;
/// The pictures of a generator that lie between two frames here, which are so far apart.
const STEPS: u32 = 4;
const FRAME_SECS: f64 = STEPS as f64 / FRAMES_PER_SECOND;
const GRAVITY: DVec3 = DVec3::new(0.0, -9.81, 0.0);
/// The generator writes what f32 holds: half a unit in the last place of 2 m, at both ends and in what is
/// compared, and of 6.4 m/s over a frame.
const POSITION_ERROR: f64 = 4e-7;

fn fountain(picture: u32) -> Particles {
    let generated = Generator::Fountain.generate(COUNT, 5, Some(picture));
    generated.unwrap().particles
}

fn ids(particles: &Particles) -> Vec<u64> {
    let ids = particles.role(Role::Id).unwrap();
    (0..particles.len())
        .map(|row| ids.get(row, 0) as u64)
        .collect()
}

fn velocity(particles: &Particles, row: usize) -> DVec3 {
    let velocity = particles.role(Role::Velocity).unwrap();
    DVec3::new(
        velocity.get(row, 0),
        velocity.get(row, 1),
        velocity.get(row, 2),
    )
}

#[test]
fn between_frames_every_particle_is_on_its_parabola() {
    let start = 30;
    let moment = |frame: u32| Moment {
        name: format!("frame {frame}"),
        particles: Arc::new(fountain(start + frame * STEPS)),
        time: f64::from(frame) * FRAME_SECS,
    };
    let [before, earlier, later, after] = [0, 1, 2, 3].map(moment);
    let settings = BetweenSettings {
        identity: Identity::Ids,
        velocity_scale: 1.0,
    };
    let pair = Pair::new(Some(&before), &earlier, &later, Some(&after), &settings).unwrap();
    assert_eq!(pair.fitting_velocity_scale(), None);
    for step in 0..=STEPS {
        let fraction = f64::from(step) / f64::from(STEPS);
        let found = pair.at(fraction);
        let expected = fountain(start + STEPS + step);
        let rows: HashMap<u64, usize> = ids(&expected).into_iter().zip(0..).collect();
        let scales = found.role(Role::SupportScale);
        let (mut whole, mut partly) = (0, 0);
        for (row, id) in ids(&found).into_iter().enumerate() {
            let scale = scales.as_ref().map_or(1.0, |scales| scales.get(row, 0));
            // Under the floor, where it came from or went to, it is on its way alone.
            let Some(&there) = rows.get(&id) else {
                assert!(scale < 1.0 && found.positions[row].y < 1e-6, "{id} {scale}");
                partly += 1;
                continue;
            };
            let off = found.positions[row].distance(expected.positions[there]);
            assert!(off < POSITION_ERROR, "{fraction}, {id}: off by {off}");
            let off = velocity(&found, row).distance(velocity(&expected, there));
            let limit = if scale < 1.0 { 10.0 * FRAME_SECS } else { 2e-6 };
            assert!(off < limit, "{fraction}, {id}: faster by {off}");
            whole += usize::from(scale == 1.0);
        }
        assert!(whole > COUNT * 3 / 4, "{whole}");
        assert!(partly > 5 || step == 0 || step == STEPS, "{partly}");
    }
}

/// The settings without anything that depends on where neighbours are.
fn surface(radius: f64) -> Surface {
    let mut surface = Surface::from_file("");
    surface.support = Some(4.0 * radius);
    surface.weights = Some(Weights::Unit);
    surface.threshold = Some(0.6);
    surface
}

fn frame(particles: &Particles, shutter_secs: [f64; 2], engine: Engine) -> Frame {
    let surface = surface(0.024);
    let settings = surface.settings(&BlobSettings::default());
    let built = BlobField::from_moving_particles(particles, &settings, shutter_secs, 1.0).unwrap();
    let scene = Scene {
        surfaces: vec![surface],
        ..Scene::default()
    };
    let settings = FrameSettings {
        engine,
        ..FrameSettings::default()
    };
    Frame::build(&scene, vec![built.field], &settings).unwrap()
}

#[test]
fn rays_meet_particles_where_the_closed_form_has_them() {
    let particles = fountain(18);
    let half = 0.02;
    let scale = 4.0 * 0.024;
    for engine in [Engine::Cells, Engine::Particles, Engine::Interval] {
        let moving = frame(&particles, [-half, half], engine);
        let mut scratch = Scratch::default();
        for time in [-half, -0.3 * half, 0.0, 0.77 * half, half] {
            let acceleration: Vec<DVec3> = vec![GRAVITY; particles.len()];
            let places = particles
                .positions
                .iter()
                .enumerate()
                .map(|(row, &position)| {
                    position
                        + velocity(&particles, row) * time
                        + acceleration[row] * (0.5 * time * time)
                });
            let still = Particles::from_positions(places.collect());
            let still = frame(&still, [0.0; 2], Engine::Sweep);
            let (mut hits, mut edges) = (0, 0);
            for i in 0..900 {
                let (x, y) = (f64::from(i % 30), f64::from(i / 30));
                let origin = DVec3::new(x / 12.0 - 1.25, y / 14.0 + 0.02, 4.0);
                let direction = DVec3::new(0.05, -0.02, -1.0);
                let ray = Ray {
                    time,
                    ..Ray::new(origin, direction)
                };
                let found = moving.closest_hit(&ray, &mut scratch).map(|hit| hit.t);
                let expected = still.closest_hit(&ray, &mut scratch).map(|hit| hit.t);
                match (found, expected) {
                    (Some(found), Some(expected)) if (found - expected).abs() < 1e-4 * scale => {
                        hits += 1;
                    }
                    (None, None) => {}
                    // A touch goes either way by the last bits.
                    _ => edges += 1,
                }
            }
            assert!(hits > 100, "{engine:?} {time}: {hits} hits");
            assert!(edges <= 1, "{engine:?} {time}: {edges} of {hits}");
        }
    }
}

#[test]
fn velocities_in_other_units_need_their_factor() {
    let mut particles = fountain(18);
    for column in &mut particles.columns {
        if column.components == 3 {
            let scaled: Vec<f32> = (0..column.data.len())
                .map(|i| (column.data.get(i) * 1000.0) as f32)
                .collect();
            *column = Column::new(column.name.clone(), 3, scaled);
        }
    }
    let settings = surface(0.024).settings(&BlobSettings::default());
    let shutter = [-0.01, 0.01];
    let field = |particles: &Particles, scale: f64| {
        let built = BlobField::from_moving_particles(particles, &settings, shutter, scale);
        built.unwrap().field.motion.unwrap()
    };
    let (scaled, own) = (field(&particles, 1e-3), field(&fountain(18), 1.0));
    for (a, b) in scaled.velocities.iter().zip(&own.velocities) {
        for k in 0..3 {
            assert!((a[k] - b[k]).abs() <= 2e-6, "{a:?} {b:?}");
        }
    }
}

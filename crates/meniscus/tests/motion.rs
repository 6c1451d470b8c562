//! Moving blobs, judged by the oracle at the time of each ray.

use glam::DVec3;
use meniscus::accel::cells::{Cells, TimedCells};
use meniscus::accel::{Accel, Engine};
use meniscus::field::{BlobField, Motion, Search};
use meniscus::frame::Blobs;
use meniscus::intersect::{BlobHit, Crossing, Scratch};
use meniscus::kernel::Kernel;
use meniscus::math::ray::Ray;
use meniscus::math::simd::Level;
use meniscus::scene::{EngineSettings, Leaves, MotionBounds};
use meniscus_testing::corpus::{self, Scene};
use meniscus_testing::examine::{Question, Tracer};
use meniscus_testing::oracle::Oracle;
use meniscus_testing::random::Stream;
use meniscus_testing::rays;
use meniscus_testing::suite::{Stage, complaints, levels};

const ENGINES: [Engine; 4] = [
    Engine::Cells,
    Engine::Particles,
    Engine::Interval,
    Engine::Sweep,
];

/// Open from before the frame's time until after it, not alike.
const SHUTTER_SECS: [f64; 2] = [-0.3, 0.7];

/// `scene` with every blob moving about `distance` spacings while the shutter is open, in a swirl with
/// noise, accelerated by as much again.
fn moving(scene: &Scene, distance: f64) -> Scene {
    let field = &scene.field;
    let speed = distance * f64::from(field.spacing);
    let size = f64::from(field.bounds().size().max_element());
    let rate = |i: usize, salt: u64, turn: f64| {
        let mut random = Stream::new(41 + salt, i as u64);
        let noise = DVec3::from_array([(); 3].map(|()| random.unit() - 0.5));
        let place = field.center(i).as_dvec3() / size;
        let swirl = DVec3::new(-place.y, place.x, 0.3) * turn;
        ((swirl + noise) * speed).as_vec3().to_array()
    };
    let motion = Motion {
        velocities: (0..field.len()).map(|i| rate(i, 0, 2.0)).collect(),
        half_accelerations: (0..field.len()).map(|i| rate(i, 1, -2.0)).collect(),
        velocity_gradients: Vec::new(),
        shutter: SHUTTER_SECS,
    };
    Scene {
        name: format!("{} moving {distance}", scene.name),
        field: BlobField {
            motion: Some(motion),
            search: Search::default(),
            ..field.clone()
        },
    }
}

/// The structure of that very engine, also where `cells` would hand the blobs on.
fn built(field: &BlobField, engine: Engine, level: Level) -> Blobs {
    match engine {
        Engine::Cells => in_slabs(field, 1, level),
        _ => Blobs::build(field.clone(), engine, level),
    }
}

/// Engine `cells` with the shutter cut into slabs of time.
fn in_slabs(field: &BlobField, slabs: u32, level: Level) -> Blobs {
    let mut blobs = Blobs::build(field.clone(), Engine::Cells, level);
    blobs.accel = Accel::Cells(TimedCells::build(field, slabs, Leaves::default()));
    blobs
}

/// The structures of all engines, those over particles with boxes that move either way.
fn structures(field: &BlobField) -> Vec<(String, Blobs)> {
    let mut all = Vec::new();
    for level in levels() {
        for engine in ENGINES {
            all.push((format!("{engine:?} {level:?}"), built(field, engine, level)));
        }
        for slabs in [2, 4] {
            let name = format!("cells {level:?} in {slabs} slabs of time");
            all.push((name, in_slabs(field, slabs, level)));
        }
        for engine in [Engine::Particles, Engine::Interval] {
            let settings = EngineSettings {
                motion_bounds: MotionBounds::Bezier,
                ..EngineSettings::default()
            };
            let blobs = Blobs::build_with(field.clone(), engine, settings, level);
            all.push((format!("{engine:?} {level:?} along curves"), blobs));
        }
    }
    all
}

fn at_time(rays: Vec<Ray>, time: f64) -> Vec<Ray> {
    rays.into_iter().map(|ray| Ray { time, ..ray }).collect()
}

/// Times at both ends of the shutter, at the frame's own and between.
fn times() -> Vec<f64> {
    let mut random = Stream::new(77, 0);
    let [open, close] = SHUTTER_SECS;
    let mut times = vec![open, 0.0, close];
    times.extend([(); 3].map(|()| open + (close - open) * random.unit()));
    times
}

#[test]
fn moving_blobs_are_where_they_are_at_the_ray_s_time() {
    let mut problems = Vec::new();
    let mut traced = 0;
    for (n, kind) in corpus::KINDS.iter().enumerate() {
        for distance in [0.3, 3.0, 10.0] {
            let kernel = Kernel::ALL[(n + distance as usize) % Kernel::ALL.len()];
            let scene = moving(&corpus::scene(kind, kernel, 300), distance);
            let structures = structures(&scene.field);
            for time in times() {
                let oracle = Oracle::at(&scene.field, time);
                let stage = Stage::new(&scene, &oracle, 60);
                let mut all = rays::hemisphere(&stage.points, 3);
                all.extend(rays::grazing(&oracle, &stage.points, 4));
                all.extend(rays::inside(&oracle, &stage.points, 5));
                all.extend(rays::primary(&oracle, 14, DVec3::new(0.3, 0.5, 1.0)));
                let all = at_time(all, time);
                for (name, blobs) in &structures {
                    for question in [Question::Closest, Question::Any] {
                        traced += all.len();
                        let complaint = complaints(blobs, &stage, &all, question);
                        problems.extend(complaint.map(|text| format!("{name} at {time}: {text}")));
                    }
                }
            }
        }
    }
    assert!(traced > 100_000, "only {traced} rays");
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn blobs_at_rest_under_an_open_shutter_stay_where_they_are() {
    let still = corpus::scene("pool", Kernel::Sextic, 500);
    let resting = moving(&still, 0.0);
    let oracle = Oracle::new(&still.field);
    let rays = at_time(rays::primary(&oracle, 40, DVec3::new(0.3, 0.5, 1.0)), 0.4);
    for engine in ENGINES {
        let level = levels()[0];
        let trace = |field: &BlobField| {
            let blobs = built(field, engine, level);
            let mut scratch = Scratch::default();
            let hit = |ray: &Ray| blobs.closest(ray, &mut scratch).map(|hit| hit.t);
            rays.iter().map(hit).collect::<Vec<_>>()
        };
        let (moving, resting) = (trace(&still.field), trace(&resting.field));
        let spacing = f64::from(still.field.spacing);
        for (a, b) in moving.iter().zip(&resting) {
            match (a, b) {
                (Some(a), Some(b)) => assert!((a - b).abs() < 1e-4 * spacing, "{engine:?}"),
                _ => assert_eq!(a, b, "{engine:?}"),
            }
        }
    }
}

#[test]
fn cells_keep_blobs_that_move_with_their_neighbours() {
    let still = corpus::scene("pool", Kernel::Sextic, 2000).field;
    let built = |velocity: &dyn Fn(usize) -> [f32; 3]| {
        let motion = Motion {
            velocities: (0..still.len()).map(velocity).collect(),
            half_accelerations: vec![[0.0; 3]; still.len()],
            velocity_gradients: Vec::new(),
            shutter: SHUTTER_SECS,
        };
        let field = BlobField {
            motion: Some(motion),
            search: Search::default(),
            ..still.clone()
        };
        Blobs::build(field, Engine::Cells, levels()[0])
            .accel
            .engine()
    };
    let speed = 10.0 * still.spacing;
    assert_eq!(built(&|_| [speed, 0.0, -speed]), Engine::Cells);
    let scattering = |i: usize| {
        let mut random = Stream::new(5, i as u64);
        [(); 3].map(|()| speed * (random.unit() - 0.5) as f32)
    };
    assert_eq!(built(&scattering), Engine::Particles);
}

/// Into how many slabs the shutter is cut where the blobs of `still` move by `distance` spacings in a swirl:
/// neighbours move about alike, and less so the faster it is.
fn slabs_of_swirl(still: &BlobField, asked: u32, distance: f64) -> Option<u32> {
    let speed = distance * f64::from(still.spacing) / f64::from(still.bounds().size().x);
    let velocity = |i: usize| {
        let place = still.center(i).as_dvec3();
        (DVec3::new(-place.y, place.x, 0.0) * speed * 2.0)
            .as_vec3()
            .to_array()
    };
    let motion = Motion {
        velocities: (0..still.len()).map(velocity).collect(),
        half_accelerations: vec![[0.0; 3]; still.len()],
        velocity_gradients: Vec::new(),
        shutter: SHUTTER_SECS,
    };
    let field = BlobField {
        motion: Some(motion),
        search: Search::default(),
        ..still.clone()
    };
    TimedCells::slabs_for(&field, asked)
}

#[test]
fn the_shutter_is_cut_where_a_slab_of_it_is_calm_enough() {
    for (scene, expected) in [
        ("pool", vec![Some(1), Some(2), Some(4), None]),
        ("ellipsoids", vec![Some(1), Some(2), None]),
    ] {
        let still = corpus::scene(scene, Kernel::Sextic, 2000).field;
        let slabs = |asked: u32, distance: f64| slabs_of_swirl(&still, asked, distance);
        assert_eq!(slabs(0, 0.1), Some(1), "{scene}");
        assert_eq!(slabs(2, 0.1), Some(2), "{scene}");
        let mut found: Vec<_> = (1..240).map(|d| slabs(0, 0.25 * f64::from(d))).collect();
        // More of them the farther blobs move, and none at all in the end.
        let rank = |slabs: &Option<u32>| slabs.unwrap_or(u32::MAX);
        assert!(found.is_sorted_by_key(rank), "{scene}: {found:?}");
        found.dedup();
        assert_eq!(found, expected, "{scene}");
        // What is asked for is not done where it would not end.
        assert_eq!(slabs(1, 60.0), None, "{scene}");
    }
}

#[test]
fn every_time_belongs_to_the_slab_that_holds_it() {
    let scene = moving(&corpus::scene("pool", Kernel::Quartic, 200), 3.0);
    let cells = TimedCells::build(&scene.field, 4, Leaves::default());
    assert_eq!(cells.slabs().len(), 4);
    let [open, close] = SHUTTER_SECS;
    for n in -10..=110 {
        let time = open + (close - open) * f64::from(n) / 100.0;
        let [from, to] = cells.at(time).span().ends_secs();
        let within = time.clamp(open, close);
        assert!(
            from - 1e-12 <= within && within <= to + 1e-12,
            "{time} in {from} to {to}"
        );
    }
    assert_eq!(cells.slab_at(f64::NEG_INFINITY), 0);
    assert_eq!(cells.slab_at(f64::INFINITY), 3);
}

/// Asks about every ray together with the same one at other times.
struct AmongOtherTimes<'a>(&'a Blobs);

impl AmongOtherTimes<'_> {
    const TIMES: usize = 4;

    fn mixed(rays: &[Ray]) -> Vec<Ray> {
        let [open, close] = SHUTTER_SECS;
        let mut random = Stream::new(91, rays.len() as u64);
        let mut with_others = |ray: &Ray| {
            let mut times = [(); Self::TIMES].map(|()| open + (close - open) * random.unit());
            times[0] = ray.time;
            times.map(|time| Ray { time, ..*ray })
        };
        rays.iter().flat_map(&mut with_others).collect()
    }
}

impl Tracer for AmongOtherTimes<'_> {
    fn closest(&self, ray: &Ray, scratch: &mut Scratch) -> Option<BlobHit> {
        self.0.closest(ray, scratch)
    }

    fn occluded(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
        self.0.occluded(ray, scratch)
    }

    fn crossings(&self, ray: &Ray, scratch: &mut Scratch) -> Vec<Crossing> {
        Tracer::crossings(self.0, ray, scratch)
    }

    fn closest_many(&self, rays: &[Ray], scratch: &mut Scratch) -> Vec<Option<BlobHit>> {
        let hits = Tracer::closest_many(self.0, &Self::mixed(rays), scratch);
        hits.into_iter().step_by(Self::TIMES).collect()
    }

    fn occluded_many(&self, rays: &[Ray], scratch: &mut Scratch) -> Vec<bool> {
        let hits = Tracer::occluded_many(self.0, &Self::mixed(rays), scratch);
        hits.into_iter().step_by(Self::TIMES).collect()
    }
}

#[test]
fn rays_traced_together_have_times_of_their_own() {
    let mut problems = Vec::new();
    for (n, kind) in corpus::KINDS.iter().enumerate() {
        let kernel = Kernel::ALL[n % Kernel::ALL.len()];
        let scene = moving(&corpus::scene(kind, kernel, 300), 0.6);
        for (level, slabs) in levels()
            .into_iter()
            .flat_map(|level| [(level, 1), (level, 4)])
        {
            let blobs = in_slabs(&scene.field, slabs, level);
            let Accel::Cells(cells) = &blobs.accel else {
                panic!("not cells");
            };
            let together = |cells: &Cells| cells.phases_together() >= 2.0;
            assert!(cells.slabs().iter().all(together), "{kind}");
            for time in times() {
                let oracle = Oracle::at(&scene.field, time);
                let stage = Stage::new(&scene, &oracle, 60);
                let mut all = rays::primary(&oracle, 40, DVec3::new(0.3, 0.5, 1.0));
                all.extend(rays::hemisphere(&stage.points, 3));
                all.extend(rays::grazing(&oracle, &stage.points, 4));
                let all = at_time(all, time);
                for question in [Question::ClosestTogether, Question::AnyTogether] {
                    let complaint = complaints(&AmongOtherTimes(&blobs), &stage, &all, question);
                    problems.extend(
                        complaint
                            .map(|text| format!("{level:?}, {slabs} slabs, at {time}: {text}")),
                    );
                }
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

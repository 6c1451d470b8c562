use super::*;
use std::collections::HashMap;

const GRAVITY: DVec3 = DVec3::new(0.0, -9.81, 0.0);

/// A particle thrown at time 0.
#[derive(Clone, Copy)]
struct Throw {
    id: u32,
    start: DVec3,
    velocity: DVec3,
}

impl Throw {
    fn position(&self, time: f64) -> DVec3 {
        self.start + (self.velocity + GRAVITY * (0.5 * time)) * time
    }

    fn velocity(&self, time: f64) -> DVec3 {
        self.velocity + GRAVITY * time
    }
}

fn throws(count: u32) -> Vec<Throw> {
    (0..count)
        .map(|id| {
            let angle = f64::from(id) * 2.399;
            Throw {
                id: 7 * id + 3,
                start: DVec3::new(1e3 + angle.cos(), 0.2 * f64::from(id), angle.sin()),
                velocity: DVec3::new(angle.sin(), 3.0 + angle.cos(), 0.5),
            }
        })
        .collect()
}

#[derive(Clone, Copy, PartialEq)]
enum With {
    Positions,
    Velocities(f64),
}

fn moment(throws: &[Throw], time: f64, with: With) -> Moment {
    let positions = throws.iter().map(|throw| throw.position(time)).collect();
    let mut particles = Particles::from_positions(positions);
    let ids: Vec<u32> = throws.iter().map(|throw| throw.id).collect();
    particles.columns.push(Column::new("id", 1, ids));
    if let With::Velocities(unit) = with {
        let values = throws
            .iter()
            .flat_map(|t| (t.velocity(time) / unit).to_array());
        let values: Vec<f64> = values.collect();
        particles.columns.push(Column::new("velocity", 3, values));
        let values: Vec<f64> = throws
            .iter()
            .flat_map(|_| (GRAVITY / unit).to_array())
            .collect();
        particles
            .columns
            .push(Column::new("acceleration", 3, values));
    }
    Moment {
        name: format!("frame at {time}"),
        particles: Arc::new(particles),
        time,
    }
}

fn settings(velocity_scale: f64) -> BetweenSettings {
    BetweenSettings {
        identity: Identity::Ids,
        velocity_scale,
    }
}

fn assert_on_their_ways(found: &Particles, throws: &[Throw], time: f64, tolerance: f64) {
    for (index, position) in found.positions.iter().enumerate() {
        let id = found.column("id").unwrap().get(index, 0) as u32;
        let throw = throws.iter().find(|throw| throw.id == id).unwrap();
        let off = (*position - throw.position(time)).length();
        assert!(off <= tolerance, "id {id} at {time}: {off}");
    }
}

#[test]
fn ballistic_ways_are_exact_with_velocities_and_without() {
    let throws = throws(50);
    // Another order in the later frame.
    let mut turned = throws.clone();
    turned.reverse();
    let frame = |throws: &[Throw], time, with| moment(throws, time, with);
    for (with, scale) in [
        (With::Velocities(1.0), 1.0),
        (With::Velocities(100.0), 100.0),
        (With::Positions, 1.0),
    ] {
        let before = frame(&throws, -0.04, with);
        let (a, b) = (frame(&throws, 0.0, with), frame(&turned, 0.04, with));
        // As after a frame that is missing.
        let after = frame(&turned, 0.12, with);
        for (before, after) in [
            (Some(&before), Some(&after)),
            (Some(&before), None),
            (None, Some(&after)),
        ] {
            let pair = Pair::new(before, &a, &b, after, &settings(scale)).unwrap();
            assert_eq!(pair.fitting_velocity_scale(), None);
            for fraction in [0.0, 0.1, 0.5, 0.77, 1.0] {
                let found = pair.at(fraction);
                assert_eq!(found.len(), 50);
                assert!(found.column("support_scale").is_none());
                assert_on_their_ways(&found, &throws, 0.04 * fraction, 1e-11);
                if with != With::Positions {
                    let speed = found.column("velocity").unwrap().get(4, 1);
                    let expected = throws[4].velocity(0.04 * fraction).y / scale;
                    assert!((speed - expected).abs() < 1e-11);
                }
            }
        }
    }
}

#[test]
fn two_frames_alone_are_joined_by_straight_lines() {
    let throws = throws(3);
    let (a, b) = (
        moment(&throws, 0.0, With::Positions),
        moment(&throws, 0.1, With::Positions),
    );
    let pair = Pair::new(None, &a, &b, None, &settings(1.0)).unwrap();
    let middle = pair.at(0.25).positions[1];
    let straight = a.particles.positions[1].lerp(b.particles.positions[1], 0.25);
    assert!((middle - straight).length() < 1e-12);
}

#[test]
fn particles_come_and_go_without_a_jump() {
    let all = throws(6);
    let (first, last) = (&all[..5], &all[1..]);
    let with = With::Velocities(1.0);
    let (a, b) = (moment(first, 1.0, with), moment(last, 1.04, with));
    let pair = Pair::new(None, &a, &b, None, &settings(1.0)).unwrap();
    let scales = |fraction: f64| -> HashMap<u32, f64> {
        let found = pair.at(fraction);
        // Those that only one frame has move on as they do there.
        assert_on_their_ways(&found, &all, 1.0 + 0.04 * fraction, 1e-11);
        let ids = found.column("id").unwrap();
        let scale = found.role(Role::SupportScale);
        (0..found.len())
            .map(|i| {
                (
                    ids.get(i, 0) as u32,
                    scale.as_ref().map_or(1.0, |s| s.get(i, 0)),
                )
            })
            .collect()
    };
    let (leaves, comes, stays) = (all[0].id, all[5].id, all[2].id);
    for fraction in [0.05, 0.25, 0.5, 0.9] {
        let scales = scales(fraction);
        assert_eq!(scales.len(), 6);
        assert!((scales[&leaves] - (1.0 - fraction)).abs() < 1e-6);
        assert!((scales[&comes] - fraction).abs() < 1e-6);
        assert_eq!(scales[&stays], 1.0);
    }
    // The ends hold what the frames hold.
    let ids = |scales: HashMap<u32, f64>| {
        let mut ids: Vec<u32> = scales.into_keys().collect();
        ids.sort_unstable();
        ids
    };
    let of = |throws: &[Throw]| throws.iter().map(|throw| throw.id).collect::<Vec<_>>();
    assert_eq!(ids(scales(0.0)), of(first));
    assert_eq!(ids(scales(1.0)), of(last));
}

#[test]
fn columns_are_blended_or_chosen() {
    let frame = |values: [f32; 2], kinds: [u8; 2], time: f64| {
        let mut particles = Particles::from_positions(vec![DVec3::ZERO, DVec3::X]);
        particles.columns = vec![
            Column::new("particle_id", 1, vec![8_i64, 9]),
            Column::new("heat", 1, values.to_vec()),
            Column::new("kind", 1, kinds.to_vec()),
        ];
        Moment {
            name: format!("frame at {time}"),
            particles: Arc::new(particles),
            time,
        }
    };
    let (a, mut b) = (
        frame([0.0, 10.0], [1, 2], 0.0),
        frame([4.0, 20.0], [3, 2], 1.0),
    );
    Arc::make_mut(&mut b.particles)
        .columns
        .push(Column::new("new", 1, vec![1.0_f32, 2.0]));
    let pair = Pair::new(None, &a, &b, None, &settings(1.0)).unwrap();
    let found = pair.at(0.25);
    assert_eq!(
        found.column("heat").unwrap().data,
        vec![1.0_f32, 12.5].into()
    );
    assert_eq!(found.column("kind").unwrap().data, vec![1_u8, 2].into());
    assert_eq!(
        pair.at(0.5).column("kind").unwrap().data,
        vec![3_u8, 2].into()
    );
    assert!(found.column("new").is_none());
}

#[test]
fn velocities_in_another_unit_are_noticed_and_not_used() {
    let throws = throws(20);
    let with = With::Velocities(0.01);
    let (a, b) = (moment(&throws, 0.0, with), moment(&throws, 0.04, with));
    let pair = Pair::new(None, &a, &b, None, &settings(1.0)).unwrap();
    let fitting = pair.fitting_velocity_scale().unwrap();
    assert!((fitting - 0.01).abs() < 1e-4, "{fitting}");
    let straight = a.particles.positions[3].lerp(b.particles.positions[3], 0.5);
    assert!((pair.at(0.5).positions[3] - straight).length() < 1e-12);
    let pair = Pair::new(None, &a, &b, None, &settings(0.01)).unwrap();
    assert_eq!(pair.fitting_velocity_scale(), None);
    // Particles at rest disagree with nothing.
    let resting = Moment {
        time: 0.04,
        ..a.clone()
    };
    let pair = Pair::new(None, &a, &resting, None, &settings(1.0)).unwrap();
    assert_eq!(pair.fitting_velocity_scale(), None);
}

#[test]
fn ids_must_be_there_and_differ() {
    let throws = throws(4);
    let good = moment(&throws, 0.0, With::Positions);
    let mut bad = good.clone();
    Arc::make_mut(&mut bad.particles).columns[0] = Column::new("heat", 1, vec![0.0_f32; 4]);
    let error = Pair::new(None, &good, &bad, None, &settings(1.0)).unwrap_err();
    assert!(
        error.to_string().contains("`id`") && error.to_string().contains("heat"),
        "{error}"
    );
    let mut bad = good.clone();
    Arc::make_mut(&mut bad.particles).columns[0] = Column::new("id", 1, vec![5_u32, 17, 2, 17]);
    let error = Pair::new(None, &bad, &good, None, &settings(1.0)).unwrap_err();
    assert!(
        error.to_string().contains("id 17 twice, in rows 1 and 3"),
        "{error}"
    );
    // Atoms need no ids: their rows are the same.
    let by_rows = BetweenSettings {
        identity: Identity::Rows,
        ..settings(1.0)
    };
    let later = Moment {
        time: 1.0,
        ..bad.clone()
    };
    assert_eq!(
        Pair::new(None, &bad, &later, None, &by_rows)
            .unwrap()
            .at(0.5)
            .len(),
        4
    );
}

#[test]
fn turns_take_the_shorter_way() {
    let one = |turn: [f64; 4], names: &[&str]| {
        let mut particles = Particles::from_positions(vec![DVec3::ZERO]);
        particles.columns.push(Column::new("id", 1, vec![1]));
        if let [name] = names {
            particles.columns.push(Column::new(*name, 4, turn.to_vec()));
        } else {
            let scalars = names.iter().zip(turn);
            particles
                .columns
                .extend(scalars.map(|(name, q)| Column::new(*name, 1, vec![q])));
        }
        particles
    };
    for names in [&["orient"][..], &["qx", "qy", "qz", "qw"]] {
        let moment = |time: f64, turn| Moment {
            name: String::new(),
            particles: Arc::new(one(turn, names)),
            time,
        };
        // A turn by 60° about z, written as −q.
        let (sine, cosine) = (-0.5, -(0.75_f64.sqrt()));
        let pair = Pair::new(
            None,
            &moment(0.0, [0.0, 0.0, 0.0, 1.0]),
            &moment(1.0, [0.0, 0.0, sine, cosine]),
            None,
            &settings(1.0),
        );
        let between = pair.unwrap().at(0.5);
        let turn = between.role(Role::Orientation).unwrap();
        let [x, y, z, w] = [0, 1, 2, 3].map(|k| turn.get(0, k));
        let angle = 2.0 * (z / w).atan();
        assert!(
            (angle.to_degrees() - 30.0).abs() < 1e-9,
            "{names:?}: {angle}"
        );
        assert_eq!([x, y], [0.0; 2]);
    }
}

use super::*;
use glam::DMat3;
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

/// Three frames of one particle with a shape, an even turn apart, and its shape M = (FFᵀ)⁻¹ between
/// them at `at` intervals, from whatever `columns` say.
fn shape_at(
    columns: impl Fn(f64) -> Vec<Column>,
    metric: impl Fn(&Particles) -> DMat3,
    at: f64,
) -> DMat3 {
    let moment = |time: f64| {
        let mut particles = Particles::from_positions(vec![DVec3::ZERO]);
        particles.columns = columns(time);
        particles.columns.push(Column::new("id", 1, vec![1]));
        Moment {
            name: String::new(),
            particles: Arc::new(particles),
            time,
        }
    };
    let first = at.floor().clamp(0.0, 1.0);
    let pair = Pair::new(
        None,
        &moment(first),
        &moment(first + 1.0),
        None,
        &settings(1.0),
    );
    metric(&pair.unwrap().at(at - first))
}

/// An ellipsoid that turns by 50° per frame about an axis of no particular direction; its radii change
/// by even factors.
fn spinning(time: f64) -> [DMat3; 3] {
    let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
    let turn = DMat3::from_axis_angle(axis, 50_f64.to_radians() * time);
    let start = DMat3::from_rotation_x(0.4);
    let radii = DVec3::new(4.0, 1.0, 0.5 * 1.1_f64.powf(time));
    [turn, start, DMat3::from_diagonal(radii)]
}

fn row_by_row(m: DMat3) -> Vec<f64> {
    m.transpose().to_cols_array().to_vec()
}

#[test]
fn metrics_gradients_and_axes_turn_evenly_without_popping_at_frames() {
    let exact = |time: f64| {
        let [turn, start, radii] = spinning(time);
        let shape = turn * start * radii;
        (shape * shape.transpose()).inverse()
    };
    let nine = |particles: &Particles, role: Role| {
        let role = particles.role(role).unwrap();
        DMat3::from_cols_array(&[0, 1, 2, 3, 4, 5, 6, 7, 8].map(|k| role.get(0, k)))
    };
    let of_metric = |order: [usize; 6], time: f64| {
        let m = exact(time).to_cols_array();
        let numbers = [m[0], m[1], m[2], m[4], m[5], m[8]];
        vec![Column::new("metric", 6, order.map(|k| numbers[k]).to_vec())]
    };
    let six = |places: [usize; 9]| {
        move |particles: &Particles| {
            let role = particles.role(Role::Metric).unwrap();
            DMat3::from_cols_array(&places.map(|k| role.get(0, k)))
        }
    };
    let of_gradient = |sign: f64, time: f64| {
        let [turn, start, radii] = spinning(time);
        let gradient = turn * start * radii * start.transpose();
        // Every second one is turned inside out.
        let sign = if time == 1.0 { sign } else { 1.0 };
        let numbers = row_by_row(gradient * sign);
        let names = [
            "F00", "F01", "F02", "F10", "F11", "F12", "F20", "F21", "F22",
        ];
        let columns = names.iter().zip(numbers);
        columns
            .map(|(name, number)| Column::new(*name, 1, vec![number]))
            .collect()
    };
    let from_gradient = |particles: &Particles| {
        let gradient = nine(particles, Role::Deformation).transpose();
        (gradient * gradient.transpose()).inverse()
    };
    let of_axes = |time: f64| {
        let [turn, start, radii] = spinning(time);
        let mut shape = turn * start * radii;
        if time == 1.0 {
            shape.y_axis = -shape.y_axis;
        }
        vec![Column::new("axes", 9, shape.to_cols_array().to_vec())]
    };
    let from_axes = |particles: &Particles| {
        let shape = nine(particles, Role::Axes);
        (shape * shape.transpose()).inverse()
    };
    let plain = [0, 1, 2, 1, 3, 4, 2, 4, 5];
    let vtk = [0, 3, 5, 3, 1, 4, 5, 4, 2];
    type At<'a> = Box<dyn Fn(f64) -> DMat3 + 'a>;
    let ways: [(&str, f64, At<'_>); 5] = [
        (
            "metric",
            1e-9,
            Box::new(|at| shape_at(|time| of_metric([0, 1, 2, 3, 4, 5], time), six(plain), at)),
        ),
        (
            "VTK's metric",
            1e-9,
            Box::new(|at| shape_at(|time| of_metric([0, 3, 5, 1, 4, 2], time), six(vtk), at)),
        ),
        // Stretches change evenly, radii of `spinning` by factors.
        (
            "gradient",
            0.01,
            Box::new(|at| shape_at(|time| of_gradient(1.0, time), from_gradient, at)),
        ),
        (
            "gradient inside out",
            0.01,
            Box::new(|at| shape_at(|time| of_gradient(-1.0, time), from_gradient, at)),
        ),
        (
            "axes",
            0.01,
            Box::new(|at| shape_at(of_axes, from_axes, at)),
        ),
    ];
    let size = |m: DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    for (name, tolerance, way) in ways {
        for step in 0..=20 {
            let at = f64::from(step) / 10.0;
            let (found, wanted) = (way(at), exact(at));
            let error = size(found - wanted) / size(wanted);
            assert!(error <= tolerance, "{name} at {at}: {error}");
        }
        // From either side a frame is that frame.
        for side in [-1e-7, 1e-7] {
            let error = size(way(1.0 + side) - exact(1.0)) / size(exact(1.0));
            assert!(error < 1e-5, "{name}: {error}");
        }
    }
}

use crate::particles::{Column, Particles, Role};
use glam::DVec3;

fn with(columns: Vec<Column>) -> Particles {
    Particles {
        columns,
        ..Particles::from_positions(vec![DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO])
    }
}

fn scalar(name: &str, first: f64) -> Column {
    Column::new(name, 1, vec![first, 0.0])
}

fn numbers(particles: &Particles, name: &str) -> Vec<f64> {
    let attribute = particles.attribute(name).unwrap();
    let each = |component| {
        let mut block = [0.0; 2];
        attribute.read(0, component, &mut block);
        assert_eq!(block, [0, 1].map(|row| attribute.get(row, component)));
        block[0]
    };
    (0..attribute.components()).map(each).collect()
}

#[test]
fn radius_goes_by_several_names_and_diameters_count_half() {
    for (name, expected) in [
        ("radius", 3.0),
        ("Radius", 3.0),
        ("pscale", 3.0),
        ("particle_radius", 3.0),
        ("diameter", 1.5),
    ] {
        let particles = with(vec![scalar(name, 3.0)]);
        let radius = particles.role(Role::Radius).unwrap();
        assert_eq!(radius.get(0, 0), expected, "{name}");
        assert_eq!(radius.name(), name);
    }
    for name in ["size", "h", "scale"] {
        assert!(with(vec![scalar(name, 3.0)]).role(Role::Radius).is_none());
    }
    let vector = with(vec![Column::new("radius", 3, vec![1.0_f64; 6])]);
    assert!(vector.role(Role::Radius).is_none());
    let both = with(vec![scalar("pscale", 1.0), scalar("radius", 2.0)]);
    assert_eq!(both.role(Role::Radius).unwrap().get(0, 0), 2.0);
}

#[test]
fn vectors_come_as_one_column_or_three() {
    for names in [
        ["vx", "vy", "vz"],
        ["v_x", "v_y", "v_z"],
        ["velocity_x", "velocity_y", "velocity_z"],
        ["u", "v", "w"],
        ["v0", "v1", "v2"],
        ["v.x", "v.y", "v.z"],
    ] {
        let particles = with(
            names
                .iter()
                .zip([4.0, 5.0, 6.0])
                .map(|(n, v)| scalar(n, v))
                .collect(),
        );
        assert_eq!(
            numbers(&particles, "velocity"),
            [4.0, 5.0, 6.0],
            "{names:?}"
        );
        assert_eq!(numbers(&particles, "velocity.y"), [5.0]);
        assert_eq!(numbers(&particles, "|velocity|"), [77.0_f64.sqrt()]);
    }
    for name in ["velocity", "Velocity", "velocities", "vel", "v"] {
        let particles = with(vec![Column::new(
            name,
            3,
            vec![4.0_f32, 5.0, 6.0, 0.0, 0.0, 0.0],
        )]);
        assert_eq!(numbers(&particles, "velocity"), [4.0, 5.0, 6.0], "{name}");
        assert_eq!(numbers(&particles, &format!("{name}.z")), [6.0]);
        assert_eq!(numbers(&particles, &format!("{name}[0]")), [4.0]);
    }
    let two = with(vec![scalar("u", 1.0), scalar("v", 2.0)]);
    assert!(two.role(Role::Velocity).is_none());
    let acceleration = with(vec![
        scalar("ax", 1.0),
        scalar("ay", 2.0),
        scalar("az", 3.0),
    ]);
    assert_eq!(numbers(&acceleration, "acceleration"), [1.0, 2.0, 3.0]);
    assert_eq!(numbers(&acceleration, "a"), [1.0, 2.0, 3.0]);
}

#[test]
fn colours_of_bytes_are_fractions() {
    let bytes = ["red", "green", "blue", "alpha"]
        .iter()
        .zip([255_u8, 51, 0, 102])
        .map(|(name, value)| Column::new(*name, 1, vec![value, 0]))
        .collect();
    let found = numbers(&with(bytes), "color");
    for (found, expected) in found.iter().zip([1.0, 0.2, 0.0, 0.4]) {
        assert!((found - expected).abs() < 1e-12);
    }
    let houdini = with(vec![Column::new(
        "Cd",
        3,
        vec![0.5_f32, 0.25, 1.0, 0.0, 0.0, 0.0],
    )]);
    assert_eq!(numbers(&houdini, "color"), [0.5, 0.25, 1.0]);
}

#[test]
fn tensors_come_as_one_column_or_many_and_f_is_no_metric() {
    let gradient: Vec<Column> = (0..9)
        .map(|i| scalar(&format!("F{}{}", i / 3, i % 3), f64::from(i)))
        .collect();
    let particles = with(gradient);
    assert!(particles.role(Role::Metric).is_none());
    let expected: Vec<f64> = (0..9).map(f64::from).collect();
    assert_eq!(numbers(&particles, "F"), expected);
    assert_eq!(numbers(&particles, "F.4"), [4.0]);
    let names = ["xx", "xy", "xz", "yy", "yz", "zz"];
    let metric = with(
        names
            .iter()
            .map(|n| scalar(&format!("metric_{n}"), 1.0))
            .collect(),
    );
    assert_eq!(metric.role(Role::Metric).unwrap().components(), 6);
}

#[test]
fn positions_answer_to_names_and_exact_columns_come_first() {
    let particles = with(vec![
        scalar("a.x", 8.0),
        Column::new("a", 3, vec![9.0_f64; 6]),
    ]);
    assert_eq!(numbers(&particles, "y"), [2.0]);
    assert_eq!(numbers(&particles, "position"), [1.0, 2.0, 3.0]);
    assert_eq!(numbers(&particles, "position.z"), [3.0]);
    assert_eq!(numbers(&particles, "a.x"), [8.0]);
    assert_eq!(numbers(&particles, "a.y"), [9.0]);
}

#[test]
fn a_missing_column_is_named_with_the_nearest() {
    let particles = with(vec![
        scalar("density", 1.0),
        Column::new("velocity", 3, vec![0.0_f64; 6]),
    ]);
    let error = particles.attribute("densty").unwrap_err();
    assert_eq!(error.nearest.as_deref(), Some("density"));
    assert_eq!(error.columns, ["density", "velocity"]);
    assert!(
        error.to_string().contains("did you mean `density`?"),
        "{error}"
    );
    assert_eq!(
        particles
            .attribute("velocitty.x")
            .unwrap_err()
            .nearest
            .as_deref(),
        Some("velocity")
    );
    assert_eq!(
        particles.attribute("temperature").unwrap_err().nearest,
        None
    );
    let component = particles.attribute("velocity.3").unwrap_err();
    assert_eq!(component.components, Some(3));
    assert!(
        component.to_string().contains("3 components"),
        "{component}"
    );
}

#[test]
fn non_finite_positions_are_dropped_and_counted() {
    let mut particles = Particles::from_positions(vec![
        DVec3::ZERO,
        DVec3::new(f64::NAN, 0.0, 0.0),
        DVec3::ONE,
        DVec3::new(0.0, f64::INFINITY, 0.0),
    ]);
    particles
        .columns
        .push(Column::new("id", 1, vec![5_i32, 6, 7, 8]));
    assert_eq!(particles.drop_non_finite(), 2);
    assert_eq!(particles.rows, [0, 2]);
    assert_eq!(particles.column("id").unwrap().get(1, 0), 7.0);
    assert_eq!(particles.drop_non_finite(), 0);
}

#[test]
fn shapes_go_by_several_names_and_quaternions_by_their_order() {
    let row = |name: &str, components: usize| {
        let numbers: Vec<f64> = (0..2 * components).map(|i| i as f64).collect();
        Column::new(name, components, numbers)
    };
    for (name, components, role) in [
        ("radii", 3, Role::Radii),
        ("Aspherical Shape", 3, Role::Radii),
        ("principal_axes", 9, Role::Axes),
        ("F", 9, Role::Deformation),
        ("deformation_gradient", 9, Role::Deformation),
        ("anisou", 6, Role::Displacements),
        ("orient", 4, Role::Orientation),
    ] {
        let particles = with(vec![row(name, components)]);
        assert_eq!(
            particles.role(role).unwrap().components(),
            components,
            "{name}"
        );
        let other = with(vec![row(name, components + 1)]);
        assert!(other.role(role).is_none(), "{name}");
    }
    for (name, first) in [
        ("Orientation", 0.0),
        ("quat_wxyz", 1.0),
        ("rotation_quaternion", 1.0),
    ] {
        let particles = with(vec![row(name, 4)]);
        let expected = [0.0, 1.0, 2.0, 3.0].map(|i| (first + i) % 4.0);
        let role = particles.role(Role::Orientation).unwrap();
        assert_eq!([0, 1, 2, 3].map(|k| role.get(0, k)), expected, "{name}");
        let several = particles.several(Role::Orientation, name).unwrap();
        assert_eq!(several.get(0), expected, "{name}");
    }
    for names in [
        ["qw", "qx", "qy", "qz"],
        ["q0", "q1", "q2", "q3"],
        ["quatw", "quati", "quatj", "quatk"],
    ] {
        let scalars = names.iter().zip([9.0, 1.0, 2.0, 3.0]);
        let particles = with(scalars.map(|(name, q)| scalar(name, q)).collect());
        assert_eq!(
            numbers(&particles, "orientation"),
            [1.0, 2.0, 3.0, 9.0],
            "{names:?}"
        );
        let own = format!("{}, {}", names[3], names[0]);
        assert_eq!(
            particles.several(Role::Orientation, &own).unwrap().get(0),
            [3.0, 9.0]
        );
    }
    let axes = with(
        ["axis_a", "axis_b", "axis_c"]
            .map(|name| row(name, 3))
            .to_vec(),
    );
    assert_eq!(
        numbers(&axes, "axes"),
        [0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 0.0, 1.0, 2.0]
    );
}

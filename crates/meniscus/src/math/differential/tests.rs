use super::*;
use crate::math::level_set::LevelSet;
use glam::DMat3;

/// A ball of radius 2 whose centre moves.
const CENTER: DVec3 = DVec3::new(0.3, -0.2, 0.1);
const VELOCITY: DVec3 = DVec3::new(0.4, 0.9, -0.3);
const RADIUS: f64 = 2.0;

/// Eye and target of the ray through a point of the film at a time.
fn ray([x, y, secs]: [f64; 3]) -> (DVec3, DVec3) {
    let eye = DVec3::new(1.0, 0.5, 8.0) + DVec3::new(0.2, -0.5, 0.7) * secs;
    let target = DVec3::new(0.8 + x, 0.4 - y, 0.3 * x + 0.2 * secs);
    (eye, (target - eye).normalize())
}

fn center(secs: f64) -> DVec3 {
    CENTER + VELOCITY * secs
}

/// Parameter, position and normal of the first hit on the ball.
fn hit(film: [f64; 3]) -> (f64, DVec3, DVec3) {
    let (eye, direction) = ray(film);
    let to_eye = eye - center(film[2]);
    let b = to_eye.dot(direction);
    let t = -b - (b * b - to_eye.length_squared() + RADIUS * RADIUS).sqrt();
    let position = eye + direction * t;
    (t, position, (position - center(film[2])) / RADIUS)
}

/// Central differences by the three variables.
fn differences(of: impl Fn([f64; 3]) -> DVec3) -> [DVec3; 3] {
    let h = 1e-6;
    [0, 1, 2].map(|k| {
        let at = |step: f64| {
            let mut film = [0.0; 3];
            film[k] = step;
            of(film)
        };
        (at(h) - at(-h)) / (2.0 * h)
    })
}

fn assert_near(found: [DVec3; 3], expected: [DVec3; 3], what: &str) {
    for k in 0..3 {
        let error = found[k].distance(expected[k]);
        assert!(
            error < 3e-6 * (1.0 + expected[k].length()),
            "{what} by {k}: {} for {}",
            found[k],
            expected[k]
        );
    }
}

#[test]
fn differentials_behind_a_moving_ball_are_differences() {
    let film = [0.0; 3];
    let (_, direction) = ray(film);
    let (t, position, normal) = hit(film);
    let surface = LevelSet {
        gradient: (CENTER - position) * 2.0,
        hessian: DMat3::IDENTITY * -2.0,
        rate: 2.0 * (position - CENTER).dot(VELOCITY),
        gradient_rate: VELOCITY * 2.0,
    };
    let differential = RayDifferential {
        origin: differences(|film| ray(film).0).map(|d| d.as_vec3()),
        direction: differences(|film| ray(film).1).map(|d| d.as_vec3()),
    };
    let hits = differential.at_hit(direction, t, &surface);
    assert_near(
        hits.map(|hit| hit.position),
        differences(|film| hit_of(film).0),
        "position",
    );
    assert_near(
        hits.map(|hit| hit.normal),
        differences(|film| hit_of(film).1),
        "normal",
    );
    let in_f64 = |vectors: [Vec3; 3]| vectors.map(|v| v.as_dvec3());
    let mirrored = differential.reflected(direction, normal, &hits);
    assert_near(
        in_f64(mirrored.direction),
        differences(|film| {
            let ((_, d), (_, n)) = (ray(film), hit_of(film));
            d - n * (2.0 * d.dot(n))
        }),
        "mirrored",
    );
    assert_eq!(mirrored.origin, hits.map(|hit| hit.position.as_vec3()));
    for eta in [1.0 / 1.33, 1.2] {
        let bent = differential
            .refracted(direction, normal, eta, &hits)
            .unwrap();
        assert_near(
            in_f64(bent.direction),
            differences(|film| {
                let ((_, d), (_, n)) = (ray(film), hit_of(film));
                let along = d.dot(n);
                let beyond = (1.0 - eta * eta * (1.0 - along * along)).sqrt();
                d * eta - n * (eta * along + beyond)
            }),
            "refracted",
        );
    }
    assert_eq!(
        differential.refracted(DVec3::new(0.8, -0.6, 0.0), DVec3::Y, 1.5, &hits),
        None
    );
    // The same rays from another start meet the surface alike.
    let later = differential
        .advanced(0.5 * t)
        .at_hit(direction, 0.5 * t, &surface);
    assert_near(
        later.map(|hit| hit.position),
        hits.map(|hit| hit.position),
        "advanced",
    );
}

fn hit_of(film: [f64; 3]) -> (DVec3, DVec3) {
    let (_, position, normal) = hit(film);
    (position, normal)
}

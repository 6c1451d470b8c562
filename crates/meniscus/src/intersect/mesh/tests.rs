use super::*;
use crate::mesh::TriangleMesh;
use glam::Vec3;

/// A ball of triangles: an octahedron, each face split `levels` times, vertices on the unit sphere.
fn ball(levels: u32) -> TriangleMesh {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut faces: Vec<[DVec3; 3]> = Vec::new();
    for signs in 0..8 {
        let corner = |axis: usize| {
            if signs >> axis & 1 == 0 {
                axes[axis]
            } else {
                -axes[axis]
            }
        };
        let face = [corner(0), corner(1), corner(2)];
        let is_outward = face[0].cross(face[1]).dot(face[2]) > 0.0;
        faces.push(if is_outward {
            face
        } else {
            [face[0], face[2], face[1]]
        });
    }
    for _ in 0..levels {
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                // The same sum for both faces at an edge.
                let middle = |p: DVec3, q: DVec3| (p + q).normalize();
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let mut mesh = TriangleMesh::default();
    for face in faces {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(face);
        mesh.normals.extend(face.map(|corner| corner.as_vec3()));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    mesh
}

fn placed(mesh: &TriangleMesh, scale: f64, shift: DVec3) -> MeshSurface {
    let mut moved = mesh.clone();
    for position in &mut moved.positions {
        *position = *position * scale + shift;
    }
    let (surface, notes) = MeshSurface::build(&moved);
    assert!(notes.is_empty(), "{notes:?}");
    surface
}

/// Directions all over the sphere.
fn directions(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
        let angle = 2.399_963_229_728_653 * f64::from(k);
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * angle.cos(), r * angle.sin(), z)
    })
}

const PLACES: [(f64, DVec3); 5] = [
    (1.0, DVec3::ZERO),
    (1e-9, DVec3::new(2e-9, 0.0, 1e-8)),
    (1e9, DVec3::new(-3e9, 1e9, 0.0)),
    (1.0, DVec3::new(1e6, -2e6, 5e5)),
    (1e-3, DVec3::new(100.0, 100.0, -100.0)),
];

fn error(surface: &MeshSurface) -> f64 {
    256.0 * f64::EPSILON * (surface.center.abs().max_element() + 4.0 * surface.size)
}

#[test]
fn rays_from_all_sides_hit_where_the_ball_is() {
    let mesh = ball(3);
    let mut stack = Vec::new();
    for (scale, shift) in PLACES {
        let surface = placed(&mesh, scale, shift);
        for out in directions(500) {
            for distance in [3.0, 1e5] {
                let start = shift + out * (distance * scale);
                let hit = surface
                    .closest(&Ray::new(start, -out), error(&surface), &mut stack)
                    .unwrap_or_else(|| panic!("{scale} {shift}: missed from {out}"));
                let radius = (hit.position - shift).length() / scale;
                assert!((0.98..=1.0 + 1e-9).contains(&radius), "{radius}");
                assert!(hit.entering && hit.outward.dot(out) > 0.97);
                assert!(hit.shading.dot(out) > 0.9999, "{}", hit.shading.dot(out));
            }
        }
    }
}

#[test]
fn no_ray_slips_through_edges_and_corners() {
    let surface = placed(&ball(3), 1.0, DVec3::ZERO);
    let mut stack = Vec::new();
    for triangle in 0..surface.triangles.len() {
        let [a, b, c] = surface.corners(triangle);
        for target in [a, b, c, (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5] {
            // Exactly through the corner, and along axes, where edges project onto each other.
            for direction in [
                -target,
                DVec3::X,
                DVec3::NEG_Y,
                DVec3::Z,
                DVec3::new(1.0, 1.0, 0.0),
            ] {
                let ray = Ray::new(target - direction * 4.0, direction);
                let mut crossings = Vec::new();
                surface.crossings(&ray, 0.0, &mut stack, &mut crossings);
                assert!(
                    crossings.len() % 2 == 0,
                    "{target} {direction}: {crossings:?}"
                );
                for (k, crossing) in crossings.iter().enumerate() {
                    assert_eq!(crossing.entering, k % 2 == 0, "{target} {direction}");
                }
                if direction == -target {
                    assert_eq!(crossings.len(), 2, "{target}: {crossings:?}");
                }
            }
        }
    }
}

#[test]
fn rays_that_leave_do_not_meet_what_they_leave() {
    let mesh = ball(2);
    let mut stack = Vec::new();
    for (scale, shift) in PLACES {
        let surface = placed(&mesh, scale, shift);
        let error = error(&surface);
        let (mut left, mut crossed) = (0, 0);
        for out in directions(300) {
            let ray = Ray::new(shift + out * (50.0 * scale), -out);
            let hit = surface.closest(&ray, error, &mut stack).unwrap();
            let tangent = hit.outward.any_orthonormal_vector();
            for lift in [1.0, 1e-3, 1e-6, 1e-9] {
                // The ball is convex: outwards there is nothing, inwards the other wall.
                let up = Ray::new(hit.position, tangent + hit.outward * lift);
                let up = up.with_side(Side::Outside);
                assert_eq!(
                    surface.closest(&up, error, &mut stack),
                    None,
                    "{scale} {shift} {lift}"
                );
                assert!(!surface.occluded(&up, error, &mut stack));
                left += 1;
                let down = Ray::new(hit.position, tangent - hit.outward * lift);
                let down = down.with_side(Side::Inside);
                let far = surface.closest(&down, error, &mut stack);
                assert!(
                    far.is_none_or(|far| !far.entering),
                    "{scale} {shift} {lift}: {far:?}"
                );
                // At a slope of 1e-9 and coordinates a million times the size, the rounding of the
                // start alone may lift the ray over the edge.
                assert!(
                    far.is_some() || lift < 1e-8,
                    "{scale} {shift} {lift}: {out}"
                );
                crossed += usize::from(far.is_some());
            }
        }
        assert_eq!(left, 1200);
        assert!(
            crossed >= 1170,
            "{scale} {shift}: {crossed} of 1200 found the other wall"
        );
    }
}

#[test]
fn points_know_their_side_also_within_hollows() {
    let mut mesh = ball(2);
    let count = mesh.positions.len() as u32;
    let hollow = ball(2);
    mesh.positions
        .extend(hollow.positions.iter().map(|p| *p * 0.5));
    mesh.normals.extend(hollow.normals.iter().map(|n| -*n));
    mesh.triangles.extend(
        hollow
            .triangles
            .iter()
            .map(|&[a, b, c]| [a, c, b].map(|k| k + count)),
    );
    let mut stack = Vec::new();
    for (scale, shift) in PLACES {
        let surface = placed(&mesh, scale, shift);
        for out in directions(200) {
            for (radius, side) in [
                (0.3, Side::Outside),
                (0.7, Side::Inside),
                (1.1, Side::Outside),
                (1e4, Side::Outside),
            ] {
                let point = shift + out * (radius * scale);
                assert_eq!(
                    surface.side(point, &mut stack),
                    side,
                    "{scale} {radius} {out}"
                );
            }
        }
        let ray = Ray::new(shift + DVec3::new(3.0, 0.1, 0.02) * scale, DVec3::NEG_X);
        let mut crossings = Vec::new();
        surface.crossings(&ray, error(&surface), &mut stack, &mut crossings);
        let entering: Vec<bool> = crossings.iter().map(|c| c.entering).collect();
        assert_eq!(entering, [true, false, true, false]);
    }
}

#[test]
fn a_sheet_is_hit_from_both_sides_and_has_no_inside() {
    let mesh = TriangleMesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        normals: vec![Vec3::Z; 3],
        triangles: vec![[0, 1, 2]],
    };
    let (surface, notes) = MeshSurface::build(&mesh);
    assert!(notes[0].contains("3 edges"), "{notes:?}");
    let mut stack = Vec::new();
    let at = DVec3::new(0.2, 0.3, 0.0);
    for (height, entering) in [(2.0, true), (-2.0, false)] {
        let ray = Ray::new(at + DVec3::Z * height, DVec3::Z * -height);
        let hit = surface.closest(&ray, 0.0, &mut stack).unwrap();
        assert_eq!(
            (hit.t, hit.entering, hit.outward),
            (1.0, entering, DVec3::Z)
        );
        assert_eq!(surface.side(ray.origin, &mut stack), Side::Outside);
    }
}

#[test]
fn evil_rays_miss() {
    let surface = placed(&ball(1), 1.0, DVec3::ZERO);
    let mut stack = Vec::new();
    for direction in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        assert_eq!(
            surface.closest(&Ray::new(DVec3::ZERO, direction), 0.0, &mut stack),
            None
        );
    }
    let inside = Ray::new(DVec3::ZERO, DVec3::new(1e-300, 0.0, 3.0));
    assert!(
        surface
            .closest(&inside, 0.0, &mut stack)
            .is_some_and(|hit| !hit.entering)
    );
    let short = inside.with_range(0.0, 0.1);
    assert_eq!(surface.closest(&short, 0.0, &mut stack), None);
    let far = Ray::new(DVec3::splat(1e30), DVec3::splat(-1.0));
    let _ = surface.closest(&far, 0.0, &mut stack);
}

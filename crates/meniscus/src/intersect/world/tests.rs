use super::*;
use crate::accel::Engine;
use crate::field::BlobField;
use crate::frame::{FrameSettings, MeshSurface};
use crate::mesh::TriangleMesh;
use crate::particles::Particles;
use crate::scene::{self, BlobSettings, Matrix, Scene, Surface};

/// A box with corners at ±half.
fn cube(half: f64) -> TriangleMesh {
    let corner = |k: usize| {
        let sign = |bit: usize| if k >> bit & 1 == 0 { -half } else { half };
        DVec3::new(sign(0), sign(1), sign(2))
    };
    let quads = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    TriangleMesh {
        positions: (0..8).map(corner).collect(),
        normals: Vec::new(),
        triangles: quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
    }
}

/// A unit ball of one particle at x = 0, a cube of side 2 at x = 4, a unit sphere at x = 8, and a
/// plane at y = −2.
fn frame(clips: Vec<scene::Clip>) -> Frame {
    let scene = Scene {
        surfaces: vec![Surface::from_file("ball")],
        meshes: vec![scene::Mesh {
            matrix: Matrix(DAffine3::from_translation(DVec3::X * 4.0)),
            ..scene::Mesh::default()
        }],
        spheres: vec![scene::Sphere {
            center: DVec3::X * 8.0,
            ..scene::Sphere::default()
        }],
        planes: vec![scene::Plane {
            point: DVec3::Y * -2.0,
            ..scene::Plane::default()
        }],
        clips,
        ..Scene::default()
    };
    let ball = Particles::from_positions(vec![DVec3::ZERO]);
    let settings = BlobSettings {
        radius: Some(1.0),
        ..BlobSettings::molecule()
    };
    let field = BlobField::from_particles(&ball, &settings).unwrap().field;
    let (mesh, notes) = MeshSurface::build(&cube(1.0));
    assert!(notes.is_empty(), "{notes:?}");
    let settings = FrameSettings {
        engine: Engine::Cells,
        ..FrameSettings::default()
    };
    Frame::build_with_meshes(&scene, vec![field], vec![mesh], &settings).unwrap()
}

fn keep_below(z: f64) -> Vec<scene::Clip> {
    vec![scene::Clip {
        point: DVec3::Z * z,
        normal: DVec3::Z,
    }]
}

fn crossings(frame: &Frame, ray: &Ray) -> Vec<(f64, bool)> {
    let mut found = Vec::new();
    frame.crossings(ray, &mut Scratch::default(), &mut found);
    found
        .iter()
        .map(|c| ((c.t * 1e6).round() * 1e-6, c.entering))
        .collect()
}

#[test]
fn every_kind_answers_every_question() {
    let frame = frame(Vec::new());
    let mut scratch = Scratch::default();
    let ray = Ray::new(DVec3::new(-4.0, 0.1, 0.2), DVec3::X);
    let hit = frame.closest_hit(&ray, &mut scratch).unwrap();
    assert_eq!((hit.surface, hit.blob), (0, Some(0)));
    let found = crossings(&frame, &ray);
    let entering: Vec<bool> = found.iter().map(|c| c.1).collect();
    assert_eq!(entering, [true, false, true, false, true, false]);
    assert_eq!((found[2].0, found[3].0), (7.0, 9.0));
    // The cube hides the sphere from a ray that starts between ball and cube.
    let between = Ray { t_min: 6.0, ..ray };
    let hit = frame.closest_hit(&between, &mut scratch).unwrap();
    assert_eq!((hit.surface, hit.t, hit.normal), (1, 7.0, DVec3::NEG_X));
    let after = Ray { t_min: 9.5, ..ray };
    assert_eq!(frame.closest_hit(&after, &mut scratch).unwrap().surface, 2);
    assert!(frame.any_hit(&after, &mut scratch));
    assert!(!frame.any_hit(&Ray { t_min: 14.0, ..ray }, &mut scratch));
    let down = Ray::new(DVec3::new(20.0, 0.0, 0.0), DVec3::NEG_Y);
    assert_eq!(frame.closest_hit(&down, &mut scratch).unwrap().surface, 3);
    for (x, inside) in [
        (0.0, true),
        (2.0, false),
        (4.5, true),
        (8.9, true),
        (9.1, false),
    ] {
        let at = Ray::new(DVec3::X * x, DVec3::Y);
        assert_eq!(frame.starts_inside(&at, &mut scratch), inside, "{x}");
    }
    let bounds = frame.bounds([0.0, 0.0]);
    assert_eq!((bounds.max.x, frame.framing_bounds().max.x), (9.0, 9.0));
}

#[test]
fn cuts_open_every_solid_and_cap_it() {
    let frame = frame(keep_below(0.25));
    let mut scratch = Scratch::default();
    for (x, surface) in [(0.2, 0), (4.3, 1), (8.1, 2)] {
        let top = DVec3::new(x, 0.1, 5.0);
        let down = Ray::new(top, DVec3::NEG_Z).with_side(Side::Outside);
        let hit = frame.closest_hit(&down, &mut scratch).unwrap();
        assert_eq!((hit.surface, hit.t, hit.entering), (surface, 4.75, true));
        assert_eq!((hit.normal, hit.position.z), (DVec3::Z, 0.25));
        assert_eq!(hit.blob, (surface == 0).then_some(0));
        assert!(frame.any_hit(&down, &mut scratch));
        // Nothing is left above the cap, and it does not shadow itself.
        let up = Ray::new(hit.position, DVec3::new(0.1, 0.0, 1.0)).with_side(Side::Outside);
        assert_eq!(frame.closest_hit(&up, &mut scratch), None);
        assert!(!frame.any_hit(&up, &mut scratch));
        // From within through the cap.
        let out = Ray::new(DVec3::new(x, 0.1, -0.2), DVec3::Z);
        let hit = frame.closest_hit(&out, &mut scratch).unwrap();
        assert!((hit.t - 0.45).abs() < 1e-12 && !hit.entering, "{hit:?}");
        assert_eq!(hit.normal, DVec3::Z);
        assert!(frame.any_hit(&out, &mut scratch));
        // Into the cap as a refracted ray: not the cap again, but the wall below.
        let at_cap = DVec3::new(x, 0.1, 0.25);
        let into = Ray::new(at_cap, DVec3::NEG_Z).with_side(Side::Inside);
        let hit = frame.closest_hit(&into, &mut scratch).unwrap();
        assert!(!hit.entering && hit.t > 1.0, "{hit:?}");
        let through = crossings(&frame, &down.with_side(Side::Unknown));
        assert_eq!(through.len(), 2);
        assert_eq!(through[0], (4.75, true));
        assert!(!through[1].1);
    }
    // Beside the cap, through what was cut away, to the rest of the ball's flank.
    let slanted = Ray::new(DVec3::new(-3.0, 0.0, 0.9), DVec3::X);
    assert_eq!(frame.closest_hit(&slanted, &mut scratch), None);
    // Planes stay whole.
    let plane = Ray::new(DVec3::new(2.0, 0.0, 5.0), DVec3::NEG_Y);
    assert_eq!(frame.closest_hit(&plane, &mut scratch).unwrap().surface, 3);
}

#[test]
fn packets_and_single_rays_agree_through_cuts() {
    let wedge = vec![
        scene::Clip {
            point: DVec3::ZERO,
            normal: DVec3::new(1.0, 0.0, 0.3),
        },
        scene::Clip {
            point: DVec3::Z * 0.4,
            normal: DVec3::Z,
        },
    ];
    let frame = frame(wedge);
    let mut scratch = Scratch::default();
    let rays: Vec<Ray> = (0..400)
        .map(|k| {
            let (u, v) = (
                f64::from(k % 20) / 10.0 - 1.0,
                f64::from(k / 20) / 10.0 - 1.0,
            );
            Ray::new(
                DVec3::new(3.0, 0.5, 4.0),
                DVec3::new(u - 3.0, v - 0.5, -3.9),
            )
        })
        .collect();
    let (mut closest, mut any) = (vec![None; rays.len()], vec![false; rays.len()]);
    frame.closest_hits(&rays, &mut closest, &mut scratch);
    frame.any_hits(&rays, &mut any, &mut scratch);
    let mut caps = 0;
    for ((ray, together), any) in rays.iter().zip(closest).zip(any) {
        let alone = frame.closest_hit(ray, &mut scratch);
        assert_eq!(alone.is_some(), together.is_some());
        assert_eq!(any, alone.is_some());
        if let (Some(a), Some(b)) = (alone, together) {
            assert!(
                (a.t - b.t).abs() < 1e-5 && a.surface == b.surface,
                "{a:?} {b:?}"
            );
            caps += usize::from(frame.clips.iter().any(|clip| clip.normal == a.normal));
        }
    }
    assert!(caps > 30, "{caps}");
}

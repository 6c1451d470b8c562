// How rays change from pixel to pixel and per second, and what mirrors and clear surfaces make of that: twin
// of math/differential.rs.

struct Differential {
    // Changes of the origin by the film's x and y, and by time.
    origin: mat3x3f,
    // Changes of the direction, at right angles to it.
    direction: mat3x3f,
    // Diffuse surfaces end it.
    is_there: u32,
}

// In the place of the owners of rays: one for each sample, then those of branches that wait.
@group(0) @binding(9) var<storage, read_write> differentials: array<Differential>;

// How a hit changes by the film's x and y, and by time; normals on the viewer's side.
struct Changes {
    hits: array<HitChange, 3>,
    is_there: bool,
}

// Whether highlights are to be widened; else no buffers of all this are there.
fn antialiases() -> bool {
    return picture.pixel_variance > 0.0;
}

fn no_differential() -> Differential {
    return Differential(mat3x3f(), mat3x3f(), 0u);
}

fn no_changes() -> Changes {
    return Changes(array<HitChange, 3>(), false);
}

fn differential_of(index: u32) -> Differential {
    if antialiases() {
        return differentials[index];
    }
    return no_differential();
}

// The ray goes straight on from its parameter `t`.
fn advance_differential(index: u32, t: f32) {
    if antialiases() {
        differentials[index].origin += differentials[index].direction * t;
    }
}

fn changes_by(given: Differential, direction: vec3f, t: f32, surface: LevelSet) -> array<HitChange, 3> {
    let points = given.origin + given.direction * t;
    return array(
        hit_change(surface, direction, points[0], 0.0),
        hit_change(surface, direction, points[1], 0.0),
        hit_change(surface, direction, points[2], 1.0),
    );
}

fn reflected_differential(
    given: Differential,
    direction: vec3f,
    normal: vec3f,
    changes: array<HitChange, 3>,
) -> Differential {
    var hits = changes;
    let along = dot(direction, normal);
    var behind_it = given;
    for (var k = 0u; k < 3u; k++) {
        let change = behind_it.direction[k];
        let along_change = dot(change, normal) + dot(direction, hits[k].normal);
        behind_it.origin[k] = hits[k].position;
        behind_it.direction[k] = change - (hits[k].normal * along + normal * along_change) * 2.0;
    }
    return behind_it;
}

fn refracted_differential(
    given: Differential,
    direction: vec3f,
    normal: vec3f,
    eta: f32,
    changes: array<HitChange, 3>,
) -> Differential {
    var hits = changes;
    let along = dot(direction, normal);
    let squared = 1.0 - eta * eta * (1.0 - along * along);
    if squared <= 0.0 {
        return no_differential();
    }
    let beyond = -sqrt(squared);
    let bend = eta * along - beyond;
    let bend_slope = eta - eta * eta * along / beyond;
    var behind_it = given;
    for (var k = 0u; k < 3u; k++) {
        let change = behind_it.direction[k];
        let along_change = dot(change, normal) + dot(direction, hits[k].normal);
        behind_it.origin[k] = hits[k].position;
        behind_it.direction[k] = change * eta - hits[k].normal * bend - normal * (bend_slope * along_change);
    }
    return behind_it;
}

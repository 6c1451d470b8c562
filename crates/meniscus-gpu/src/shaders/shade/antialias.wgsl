// Specular antialiasing: twin of shade/antialias.rs, and of World::changes.

const MOST_ADDED: f32 = 0.18;
const REACH: f32 = 4.0;

// In the place of hits: those of particles at the answers to first questions.
@group(0) @binding(10) var<storage, read_write> level_sets: array<LevelSet>;

// How normals are spread within one sample: twin of NormalSpread.
struct Spread {
    x: vec3f,
    y: vec3f,
    added: vec2f,
    is_there: bool,
}

fn no_spread() -> Spread {
    return Spread(vec3f(0.0), vec3f(0.0), vec2f(0.0), false);
}

fn is_on_cap(normal: vec3f) -> bool {
    for (var plane = 0u; plane < picture.cut_count; plane++) {
        if all(words[picture.cuts_at + 2u * plane].xyz == normal) {
            return true;
        }
    }
    return false;
}

// The surface around the answer to a sample's first question: twin of Frame::level_set.
fn level_set_at(index: u32, answer: Answer, time: f32) -> LevelSet {
    if is_on_cap(answer.normal) {
        return flat_surface(answer.normal);
    }
    let at = surface_word(answer.surface);
    let shape = u32(words[at].x);
    let way = way_of(answer.surface);
    if shape != PLANE && shape != SPHERE && shape != MESH {
        return level_sets[index];
    }
    if way.y == 0u {
        if shape == SPHERE {
            let center = words[at + 1u].xyz + words[at + 2u].xyz;
            let radius = (answer.position - center) + answer.position_low;
            return LevelSet(radius * -2.0, 0.0, vec3f(0.0), scaled_identity(-2.0));
        }
        return flat_surface(answer.normal);
    }
    let placement = placement_at(way, time);
    let x = point_from_pivot(placement, answer);
    var own = flat_surface(object_normal(placement, answer.normal));
    if shape == SPHERE {
        own = LevelSet(placement.linear * x * -2.0, 0.0, vec3f(0.0), scaled_identity(-2.0));
    }
    let rate = placement_rate(way, time);
    return seen_through(own, placement.linear, rate.linear, drift_of(placement, rate, x));
}

fn scaled_identity(scale: f32) -> mat3x3f {
    return mat3x3f(vec3f(scale, 0.0, 0.0), vec3f(0.0, scale, 0.0), vec3f(0.0, 0.0, scale));
}

// How the answer to a sample's first question changes.
fn changes_at(index: u32, answer: Answer, question: Question) -> Changes {
    let given = differential_of(index);
    if given.is_there == 0u {
        return no_changes();
    }
    let surface = level_set_at(index, answer, question.time);
    var changes = Changes(changes_by(given, question.direction, answer.t, surface), true);
    if answer.is_entering == 0u {
        for (var k = 0u; k < 3u; k++) {
            changes.hits[k].normal = -changes.hits[k].normal;
        }
    }
    return changes;
}

fn spread_of(normal: vec3f, direction: vec3f, changes: Changes) -> Spread {
    if !changes.is_there {
        return no_spread();
    }
    var hits = changes.hits;
    let axes = tangents(normal);
    let facing = abs(dot(normal, direction));
    let variances = vec3f(picture.pixel_variance, picture.pixel_variance, picture.time_variance);
    var xx = 0.0;
    var xy = 0.0;
    var yy = 0.0;
    for (var k = 0u; k < 3u; k++) {
        var turn = hits[k].normal * sqrt(variances[k]);
        let reach = REACH * dot(turn, direction) / facing;
        turn /= 1.0 + reach * reach;
        let a = dot(turn, axes[0]);
        let b = dot(turn, axes[1]);
        xx += 2.0 * a * a;
        xy += 2.0 * a * b;
        yy += 2.0 * b * b;
    }
    let total = xx + yy;
    if !(total > 0.0 && total < FAR) {
        return no_spread();
    }
    let half = sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
    let cos_sin = cos_sin_of_half(xx - yy, 2.0 * xy);
    let wide = axes[0] * cos_sin.x + axes[1] * cos_sin.y;
    let added = clamp(vec2f(0.5 * total - half, 0.5 * total + half), vec2f(0.0), vec2f(MOST_ADDED));
    return Spread(cross(wide, normal), wide, added, true);
}

// Cosine and sine of half the angle of a direction, between −π/2 and π/2.
fn cos_sin_of_half(x: f32, y: f32) -> vec2f {
    let size = sqrt(x * x + y * y);
    if !(size > 0.0) {
        return vec2f(1.0, 0.0);
    }
    // The larger one first: the other would lose its digits.
    let larger = sqrt(0.5 * (1.0 + abs(x) / size));
    let smaller = 0.5 * y / size / larger;
    if x >= 0.0 {
        return vec2f(larger, smaller);
    }
    return vec2f(abs(smaller), select(-larger, larger, y >= 0.0));
}

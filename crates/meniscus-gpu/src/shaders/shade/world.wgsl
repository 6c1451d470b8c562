// A surface point as integrators see it: twin of shade/world.rs, shade/interaction.rs and
// shade/world/passage.rs.

// Surfaces that lie as close together, relative to the distance, may be crossed in either order: the
// processor knows which.
const COINCIDING: f32 = 1e-5;

// What a ray in some media meets: twin of World::contact.
struct Contact {
    beyond: u32,
    is_boundary: bool,
    is_in_doubt: bool,
}

fn contact_of(answer: Answer, material: Material, media: u32, origin: vec3f) -> Contact {
    let may_be_left = material.scattering != CLEAR && material.scattering != SHEET
        && answer.is_entering == 0u && picture.medium_count > 0u;
    if may_be_left {
        return Contact(media, true, true);
    }
    if !material.is_medium {
        return Contact(media, true, false);
    }
    let near = COINCIDING * (answer.t + size_of(origin));
    let beyond = crossed(media, answer.surface, answer.is_entering != 0u);
    let is_boundary = filling(media) != filling(beyond);
    let is_at_start = !is_boundary && answer.t <= near;
    return Contact(beyond, is_boundary, answer.next_t - answer.t <= near || is_at_start);
}

// The normal on the viewer's side: that for shading, unless `of_face` or it turns away from the viewer.
fn viewed_normal(answer: Answer, direction: vec3f, of_face: bool) -> vec3f {
    let towards = select(-1.0, 1.0, answer.is_entering != 0u);
    let is_turned_away = dot(answer.shading, direction) * towards >= 0.0;
    return select(answer.shading, answer.normal, of_face || is_turned_away) * towards;
}

// Whether a direction lies on the same side of the face as of the shading normal: twin of
// Interaction::agrees.
fn agrees(answer: Answer, direction: vec3f, on_viewers_side: bool) -> bool {
    let is_outwards = on_viewers_side == (answer.is_entering != 0u);
    return all(answer.shading == answer.normal) || (dot(direction, answer.normal) > 0.0) == is_outwards;
}

// A ray behind a surface that does not turn it.
fn passed(question: Question, answer: Answer, t_max: f32) -> Question {
    let side = select(SIDE_OUTSIDE, SIDE_INSIDE, answer.is_entering != 0u);
    var behind_it =
        question_from(answer, question.direction, t_max, side, answer.surface, question.time);
    behind_it.direction_low = question.direction_low;
    return behind_it;
}

// The ray that leaves on the viewer's side or beyond.
fn leaving(answer: Answer, direction: vec3f, t_max: f32, on_viewers_side: bool, time: f32) -> Question {
    let is_outside = (answer.is_entering != 0u) == on_viewers_side;
    let side = select(SIDE_INSIDE, SIDE_OUTSIDE, is_outside);
    return question_from(answer, direction, t_max, side, answer.surface, time);
}

// A surface point, seen from one side.
struct Point {
    bsdf: Bsdf,
    // Towards the viewer, in the surface's frame.
    view: vec3f,
    x: vec3f,
    y: vec3f,
    normal: vec3f,
    // How it changes, where rays carry differentials.
    changes: Changes,
}

// The answer to the first question of sample `index`.
fn point_of(index: u32, answer: Answer, material: Material, least: f32, indices: vec2f) -> Point {
    let direction = questions[index].direction;
    // Bodies refract by the face, so that what goes in comes out.
    let normal = viewed_normal(answer, direction, material.is_medium);
    var axes = tangents(normal);
    var bsdf = bsdf_of(material, least, indices);
    let changes = changes_at(index, answer, questions[index]);
    let spread = spread_of(normal, direction, changes);
    if spread.is_there {
        axes = array(spread.x, spread.y);
        bsdf = widened(bsdf, spread.added);
    }
    var view = -vec3f(dot(axes[0], direction), dot(axes[1], direction), dot(normal, direction));
    view.z = max(view.z, 1e-5);
    return Point(bsdf, normalize(view), axes[0], axes[1], normal, changes);
}

// The differential behind the point of a ray that is mirrored or refracted there: twin of
// Interaction::differential.
fn differential_behind(index: u32, point: Point, is_refracted: bool, eta: f32) -> Differential {
    let given = differential_of(index);
    let direction = questions[index].direction;
    if !point.changes.is_there {
        return no_differential();
    }
    if is_refracted {
        return refracted_differential(given, direction, point.normal, eta, point.changes.hits);
    }
    return reflected_differential(given, direction, point.normal, point.changes.hits);
}

fn to_world(point: Point, local: vec3f) -> vec3f {
    return normalize(point.x * local.x + point.y * local.y + point.normal * local.z);
}

fn to_local(point: Point, world: vec3f) -> vec3f {
    return vec3f(dot(point.x, world), dot(point.y, world), dot(point.normal, world));
}

// The thin sheet that a ray in some media meets.
fn sheet_at(answer: Answer, material: Material, direction: vec3f, media: u32) -> Sheet {
    let cosine = -dot(viewed_normal(answer, direction, false), direction);
    return sheet_of(cosine, ior_in(media) / material.ior, material.absorption);
}

// What became of a ray towards a light.
const REACH_BLOCKED: u32 = 0u;
const REACH_ARRIVED: u32 = 1u;
const REACH_WALKS: u32 = 2u;
const REACH_IN_DOUBT: u32 = 3u;

// Light on its way from a light: what is left of it, the media it is in, whether it went through clear
// surfaces.
struct Reach {
    part: vec3f,
    media: u32,
    went_through: bool,
    outcome: u32,
}

// One step of World::reach: looks at the answer to the question for a light, and asks again where light goes
// on. `straight`: boundaries of clear media let through what they do not reflect.
fn reach_step(index: u32, given: Reach, straight: bool) -> Reach {
    let at = lights_at() + index;
    let question = questions[at];
    let answer = answers[at];
    var reach = given;
    if answer.surface == NONE {
        reach.part *= absorbed(at, reach.media, question.t_max) * emission_scale(reach.media);
        reach.outcome = REACH_ARRIVED;
        return reach;
    }
    reach.outcome = REACH_BLOCKED;
    if picture.light_walks == 0u {
        return reach;
    }
    let material = material_at(at);
    let contact = contact_of(answer, material, reach.media, question.origin);
    if contact.is_in_doubt {
        reach.outcome = REACH_IN_DOUBT;
        return reach;
    }
    reach.part *= absorbed(at, reach.media, answer.t);
    if contact.is_boundary {
        if material.scattering == SHEET {
            reach.part *= sheet_at(answer, material, question.direction, reach.media).transmitted;
        } else if material.scattering == CLEAR && straight {
            reach.went_through = true;
            let cosine = min(abs(dot(answer.normal, question.direction)), 1.0);
            let eta = ior_in(reach.media) / ior_in(contact.beyond);
            reach.part *= 1.0 - dielectric_reflectance(cosine, eta).x;
        } else {
            return reach;
        }
        if all(reach.part <= vec3f(0.0)) {
            return reach;
        }
    }
    reach.media = contact.beyond;
    // Infinity stays what it is.
    var rest = question.t_max;
    if !is_far(rest) {
        rest -= answer.t;
    }
    questions[at] = passed(question, answer, rest);
    reach.outcome = REACH_WALKS;
    return reach;
}

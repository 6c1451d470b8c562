// Rays against triangle meshes in their own coordinates, within ±1: twin of intersect/mesh.rs (S. Woop,
// C. Benthin, I. Wald, Watertight Ray/Triangle Intersection, JCGT 2 (2013) 65). Rays that pass an edge closer
// than f32 can tell are marked, and so are those that meet two faces at one place.
//
// A node's words: (lower corner, first child or triangle), (upper corner, triangles or 0). A triangle's, in
// the order of the leaves: its corners, beside each a component of its normal, then where it is smooth the
// normals of its corners.

// Rounding of a corner as a ray sees it, relative to how far it is away.
const CORNER_ERROR: f32 = 3e-7;
// How far rounding may move a crossing along the ray.
const CROSSING_ERROR: f32 = 1e-6;
const MESH_STACK: u32 = 64u;
// Where rays that ask for a side go: along no edge that people make.
const PROBE: vec3f = vec3f(0.3571829, 0.5489173, 0.7556311);

struct Mesh {
    nodes_at: u32,
    triangles_at: u32,
    triangle_words: u32,
    is_closed: bool,
}

fn mesh_of(surface: u32) -> Mesh {
    let word = words[surface_word(surface) + 1u];
    return Mesh(u32(word.x), u32(word.y), u32(word.z), word.w > 0.5);
}

struct MeshRay {
    origin: vec3f,
    // How far the origin was moved along, to the mesh.
    shift: f32,
    inverse: vec3f,
    // Axes: x and y of the sheared space, and the one that dominates the direction.
    axes: vec3u,
    // What turns the direction into (0, 0, 1).
    shear: vec3f,
    from_at: f32,
    to_at: f32,
    // Which way it may not cross, for it starts on the other side of the surface that it leaves.
    barred: u32,
}

// In `barred`: crossings inwards, outwards.
const BARS_ENTRY: u32 = 1u;
const BARS_EXIT: u32 = 2u;

// From `from_at` to `to_at` along an object's ray.
fn mesh_ray(ray: ObjectRay, from_at: f32, to_at: f32) -> MeshRay {
    let direction = ray.direction.high;
    let shift = max(length(ray.origin.high) - 2.0, 0.0);
    let way = two_product(direction, vec3f(shift));
    let moved = two_sum(ray.origin.high, way.high);
    let origin = moved.high + (moved.low + way.low + ray.origin.low + ray.direction.low * shift);
    let size = abs(direction);
    var z = 2u;
    if size.x > size.y && size.x > size.z {
        z = 0u;
    } else if size.y > size.z {
        z = 1u;
    }
    var x = (z + 1u) % 3u;
    var y = (z + 2u) % 3u;
    if direction[z] < 0.0 {
        let first = x;
        x = y;
        y = first;
    }
    let tiny = select(vec3f(1e-18), vec3f(-1e-18), direction < vec3f(0.0));
    let inverse = 1.0 / select(direction, tiny, size < vec3f(1e-18));
    let shear = vec3f(direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]);
    return MeshRay(origin, shift, inverse, vec3u(x, y, z), shear, from_at - shift, to_at - shift, 0u);
}

// A corner in sheared coordinates about the origin, and how far rounding may have moved it.
fn sheared(ray: MeshRay, corner: vec3f) -> vec4f {
    let from_origin = corner - ray.origin;
    let z = from_origin[ray.axes.z];
    return vec4f(
        from_origin[ray.axes.x] - ray.shear.x * z,
        from_origin[ray.axes.y] - ray.shear.y * z,
        ray.shear.z * z,
        CORNER_ERROR * (size_of(corner) + size_of(from_origin)),
    );
}

// Twice the signed area of the origin and an edge, and its rounding.
fn edge(p: vec4f, q: vec4f) -> vec2f {
    let reach = abs(p.x) + abs(p.y) + abs(q.x) + abs(q.y);
    return vec2f(p.x * q.y - p.y * q.x, max(p.w, q.w) * reach);
}

struct TriangleHit {
    t: f32,
    // Barycentric coordinates.
    weights: vec3f,
    is_entering: bool,
    is_hit: bool,
    // Where rounding decides whether: no farther than this, and `t` is no nearer.
    unsure_to: f32,
}

fn triangle_hit(ray: MeshRay, at: u32) -> TriangleHit {
    let a = sheared(ray, words[at].xyz);
    let b = sheared(ray, words[at + 1u].xyz);
    let c = sheared(ray, words[at + 2u].xyz);
    let u = edge(c, b);
    let v = edge(a, c);
    let w = edge(b, a);
    let areas = vec3f(u.x, v.x, w.x);
    let errors = vec3f(u.y, v.y, w.y);
    let is_above = any(areas > errors);
    let is_below = any(areas < -errors);
    if is_above && is_below {
        return TriangleHit(FAR, vec3f(0.0), false, false, -FAR);
    }
    if any(abs(areas) <= errors) {
        let nearest = min(a.z, min(b.z, c.z)) - CROSSING_ERROR;
        let farthest = max(a.z, max(b.z, c.z)) + CROSSING_ERROR;
        return TriangleHit(nearest, vec3f(0.0), is_above, false, farthest);
    }
    let weights = areas / (u.x + v.x + w.x);
    return TriangleHit(dot(weights, vec3f(a.z, b.z, c.z)), weights, is_above, true, -FAR);
}

// What a walk through a mesh's tree finds: the first crossing; how often the mesh winds around the start,
// where that is asked.
struct MeshWalk {
    t: f32,
    // The next crossing; only one that lies close behind is sure to be found.
    next_t: f32,
    triangle: u32,
    weights: vec3f,
    is_entering: bool,
    winding: i32,
    // Where it may be that the mesh is met.
    unsure_t: f32,
}

// Where a ray enters a box; FAR: it does not before `t_max`.
fn enters_box(ray: MeshRay, node: u32, t_max: f32) -> f32 {
    let first = (words[node].xyz - ray.origin) * ray.inverse;
    let second = (words[node + 1u].xyz - ray.origin) * ray.inverse;
    let low = min(first, second);
    let high = max(first, second);
    let near = max(max(low.x, low.y), max(low.z, ray.from_at));
    let far = min(min(high.x, high.y), min(high.z, t_max));
    return select(FAR, near, near <= far);
}

// `winds`: all crossings count.
fn walk_mesh(mesh: Mesh, ray: MeshRay, winds: bool) -> MeshWalk {
    var walk = MeshWalk(FAR, FAR, NONE, vec3f(0.0), false, 0, FAR);
    var waiting: array<u32, MESH_STACK>;
    var height = 1u;
    waiting[0] = 0u;
    while height > 0u {
        height--;
        let node = mesh.nodes_at + 2u * waiting[height];
        let first = u32(words[node].w);
        let count = u32(words[node + 1u].w);
        var t_max = ray.to_at;
        if !winds {
            t_max = min(t_max, walk.t + CROSSING_ERROR);
        }
        if count > 0u {
            for (var i = first; i < first + count; i++) {
                let hit = triangle_hit(ray, mesh.triangles_at + i * mesh.triangle_words);
                if hit.unsure_to >= ray.from_at && hit.t <= t_max {
                    walk.unsure_t = min(walk.unsure_t, max(hit.t, ray.from_at));
                }
                let bar = select(BARS_EXIT, BARS_ENTRY, hit.is_entering);
                let is_within = hit.t >= ray.from_at && hit.t <= t_max;
                if !hit.is_hit || !is_within || (ray.barred & bar) != 0u {
                    continue;
                }
                walk.winding += select(1, -1, hit.is_entering);
                if hit.t >= walk.t {
                    walk.next_t = min(walk.next_t, hit.t);
                    continue;
                }
                walk.next_t = walk.t;
                walk.t = hit.t;
                walk.triangle = i;
                walk.weights = hit.weights;
                walk.is_entering = hit.is_entering;
            }
            continue;
        }
        if height + 2u > MESH_STACK {
            walk.unsure_t = ray.from_at;
            return walk;
        }
        let near = enters_box(ray, mesh.nodes_at + 2u * first, t_max);
        let far = enters_box(ray, mesh.nodes_at + 2u * (first + 1u), t_max);
        // The nearer one last.
        let is_first_nearer = near < far;
        if max(near, far) < FAR {
            waiting[height] = select(first, first + 1u, is_first_nearer);
            height++;
        }
        if min(near, far) < FAR {
            waiting[height] = select(first + 1u, first, is_first_nearer);
            height++;
        }
    }
    return walk;
}

// Whether a point lies as close to the mesh as rounding can bring it.
fn is_on_mesh(mesh: Mesh, point: vec3f, tolerance: f32) -> bool {
    var waiting: array<u32, MESH_STACK>;
    var height = 1u;
    waiting[0] = 0u;
    while height > 0u {
        height--;
        let node = mesh.nodes_at + 2u * waiting[height];
        let lower = words[node];
        let upper = words[node + 1u];
        if any(point < lower.xyz - tolerance) || any(point > upper.xyz + tolerance) {
            continue;
        }
        let first = u32(lower.w);
        let count = u32(upper.w);
        if count == 0u {
            if height + 2u > MESH_STACK {
                return true;
            }
            waiting[height] = first;
            waiting[height + 1u] = first + 1u;
            height += 2u;
            continue;
        }
        for (var i = first; i < first + count; i++) {
            let at = mesh.triangles_at + i * mesh.triangle_words;
            let a = words[at].xyz;
            let b = words[at + 1u].xyz;
            let c = words[at + 2u].xyz;
            let low = min(min(a, b), c) - tolerance;
            let high = max(max(a, b), c) + tolerance;
            let is_in_box = all(point >= low) && all(point <= high);
            if is_in_box && abs(dot(face_normal(at), point - a)) <= tolerance {
                return true;
            }
        }
    }
    return false;
}

fn face_normal(at: u32) -> vec3f {
    return vec3f(words[at].w, words[at + 1u].w, words[at + 2u].w);
}

const SIDE_UNSURE: u32 = 3u;

// Which side of a mesh a point lies on; open meshes have no inside.
fn mesh_side(mesh: Mesh, point: vec3f) -> u32 {
    if !mesh.is_closed {
        return SIDE_OUTSIDE;
    }
    let probe = ObjectRay(TwoVec3(point, vec3f(0.0)), TwoVec3(PROBE, vec3f(0.0)), 1.0);
    let walk = walk_mesh(mesh, mesh_ray(probe, 0.0, FAR), true);
    if !is_far(walk.unsure_t) || walk.t <= CROSSING_ERROR {
        return SIDE_UNSURE;
    }
    return select(SIDE_OUTSIDE, SIDE_INSIDE, walk.winding > 0);
}

// Whether a start that lies at `point` of an object's ray is on the surface itself, or as close to it as
// rounding can bring it.
fn starts_on_mesh(mesh: Mesh, question: Question, surface: u32, point: vec3f, unit: f32) -> bool {
    let tolerance = ORIGIN_ERROR * (1.0 + size_of(question.origin) / unit);
    return question.side_of == surface || is_on_mesh(mesh, point, tolerance);
}

fn or_doubt(crossing: Crossing, is_in_doubt: bool) -> Crossing {
    if is_in_doubt {
        return no_crossing(true);
    }
    return crossing;
}

fn mesh_crossing(question: Question, surface: u32, span: Span, nearest: f32) -> Crossing {
    let placement = placement_at(way_of(surface), question.time);
    if span.is_empty || !placement.is_sure {
        return no_crossing(!placement.is_sure);
    }
    let mesh = mesh_of(surface);
    let object = object_ray(placement, question);
    let reach = min(nearest * (1.0 + NEXT_TO), span.leave);
    var ray = mesh_ray(object, span.enter / object.unit, in_object(object, reach));
    let direction = object.direction.high;
    let start = ray.origin + direction * ray.from_at;
    var side = stated_side(question, surface);
    if span.enter_plane != NONE {
        side = SIDE_OUTSIDE;
        if size_of(start) <= 1.0 {
            side = mesh_side(mesh, start);
        }
        if side == SIDE_UNSURE || side == SIDE_INSIDE {
            return or_doubt(
                crossing_at_cut(question, span.enter, span.enter_plane, true), side == SIDE_UNSURE,
            );
        }
    }
    var walk = walk_mesh(mesh, ray, false);
    let is_found = walk.triangle != NONE;
    // A crossing from the other side, or what may be one.
    let is_odd = (is_found && contradicts(side, walk.is_entering)) || !is_far(walk.unsure_t);
    if side != SIDE_UNKNOWN && is_odd && starts_on_mesh(mesh, question, surface, start, object.unit) {
        ray.barred = select(BARS_ENTRY, BARS_EXIT, side == SIDE_OUTSIDE);
        walk = walk_mesh(mesh, ray, false);
    }
    let is_close = !is_far(walk.next_t) && walk.next_t - walk.t <= CROSSING_ERROR;
    if is_close || (!is_far(walk.unsure_t) && walk.unsure_t <= walk.t + CROSSING_ERROR) {
        return no_crossing(true);
    }
    if walk.triangle == NONE {
        if span.leave_plane == NONE || side == SIDE_OUTSIDE || span.leave > nearest {
            return no_crossing(false);
        }
        let end = ray.origin + direction * (in_object(object, span.leave) - ray.shift);
        var end_side = SIDE_OUTSIDE;
        if size_of(end) <= 1.0 {
            end_side = mesh_side(mesh, end);
        }
        if end_side == SIDE_OUTSIDE {
            return no_crossing(false);
        }
        return or_doubt(
            crossing_at_cut(question, span.leave, span.leave_plane, false), end_side == SIDE_UNSURE,
        );
    }
    let at = mesh.triangles_at + walk.triangle * mesh.triangle_words;
    // From the corners, not along the ray: no error of a far origin.
    let corners = mat3x3f(words[at].xyz, words[at + 1u].xyz, words[at + 2u].xyz);
    let local = turned_back_exactly(placement, TwoVec3(corners * walk.weights, vec3f(0.0)));
    let there = two_sum(local.high, placement.pivot.high);
    let outward = face_normal(at);
    var crossing = no_crossing(false);
    crossing.t = (walk.t + ray.shift) * object.unit;
    crossing.next_t = select((walk.next_t + ray.shift) * object.unit, FAR, is_far(walk.next_t));
    crossing.is_entering = walk.is_entering;
    crossing.position = two_sum(there.high, there.low + local.low + placement.pivot.low);
    crossing.normal = turned_normal(placement, outward);
    crossing.shading = crossing.normal;
    if mesh.triangle_words > 3u {
        let normals = mat3x3f(words[at + 3u].xyz, words[at + 4u].xyz, words[at + 5u].xyz);
        let shading = normals * walk.weights;
        if dot(shading, shading) > 0.0 {
            crossing.shading = turned_normal(placement, shading);
        }
    }
    crossing.triangle = walk.triangle;
    return crossing;
}

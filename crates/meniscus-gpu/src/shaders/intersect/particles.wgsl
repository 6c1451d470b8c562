// Walks the tree over particles for what reaches a ray: twin of intersect/particles/. Nearest boxes come
// first, and boxes behind the stretch's end are passed over.

// By how much f32 may see a blob at the limit of what it resolves wider than it is, in its support.
const FINE_ROUNDING: f32 = 6e-5;
// References to what is still to be visited, the nearest last, and where the ray enters it.
var<private> pending: array<vec2u, STACK>;
var<private> height: u32;

fn visit_leaf(reference: u32, near: f32, from_at: f32, reach: f32) {
    let first = params.leaves_at + (reference & ~LEAF) * LEAF_WORDS;
    let header = heap(first);
    let fine_beta = bitcast<f32>(heap(first + 1u).x);
    let origin = point_relative_to(bitcast<vec3f>(header.xyz), near);
    let low = from_at - near;
    for (var lane = 0u; lane < header.w; lane++) {
        let at = first + LEAF_HEADER_WORDS + lane * BLOB_WORDS;
        let head = heap(at);
        let line = blob_along(at, head, blob_center(at, head) - origin, ray.direction);
        if line.beta >= fine_beta {
            // Too small for f32 in this leaf.
            let steepness = sqrt(line.beta / fine_beta);
            let behind = min(line.c, 0.0);
            let square = 1.0 - line.g0 + line.beta * behind * behind;
            let limit = 1.0 + FINE_ROUNDING * steepness;
            if square < limit * limit {
                trouble = IN_DOUBT;
                return;
            }
        }
        let away = clamp(line.c, low, stretch_end - near) - line.c;
        if !(line.g0 - line.beta * away * away > 0.0) {
            continue;
        }
        if count == 0u {
            base = near;
        } else if near < base - params.longest {
            // What was met so far lies far behind: count from here.
            let shift = base - near;
            for (var i = 0u; i < count; i++) {
                met_blobs[first_met + i * WORKGROUP].x += shift;
            }
            base = near;
        }
        if count == params.capacity {
            make_room(from_at);
            if trouble != MISS {
                return;
            }
        }
        let c = line.c + (near - base);
        keep(count, vec4f(c, line.beta, line.g0, blob_weight(at)), at);
        count++;
        let enter = base + (c - sqrt(line.g0 / line.beta));
        stretch_start = min(stretch_start, max(enter, from_at));
        stretch_end = min(stretch_end, stretch_start + reach);
    }
}

fn open_node(node: u32, from_at: f32) {
    let at = node * NODE_WORDS;
    let bottom = height;
    for (var half = 0u; half < 2u; half++) {
        let children = heap(at + CHILDREN_AT + half);
        if children.x == NONE {
            break;
        }
        let x = slab(at, 0u, half, ray.origin.x, inverse.x);
        let y = slab(at, 1u, half, ray.origin.y, inverse.y);
        let z = slab(at, 2u, half, ray.origin.z, inverse.z);
        let near = max(max(x[0], y[0]), max(z[0], vec4f(from_at)));
        let far = min(min(x[1], y[1]), min(z[1], vec4f(stretch_end)));
        for (var slot = 0u; slot < 4u; slot++) {
            if children[slot] == NONE || !(near[slot] <= far[slot]) {
                continue;
            }
            if height == STACK {
                trouble = IN_DOUBT;
                return;
            }
            var place = height;
            while place > bottom && bitcast<f32>(pending[place - 1u].y) < near[slot] {
                pending[place] = pending[place - 1u];
                place--;
            }
            pending[place] = vec2u(children[slot], bitcast<u32>(near[slot]));
            height++;
        }
    }
}

// Gathers what reaches the ray in the stretch that begins with the first support behind `from_at`.
fn gather(from_at: f32, reach: f32) {
    count = 0u;
    base = from_at;
    stretch_start = ray.length;
    stretch_end = ray.length;
    trouble = MISS;
    pending[0] = vec2u(0u, bitcast<u32>(from_at));
    height = 1u;
    while height > 0u && trouble == MISS {
        height--;
        let entry = pending[height];
        let near = bitcast<f32>(entry.y);
        if near > stretch_end {
            continue;
        }
        if (entry.x & LEAF) != 0u {
            visit_leaf(entry.x, near, from_at, reach);
        } else {
            open_node(entry.x, from_at);
        }
    }
}

fn prepare() {
    prepare_slabs();
}

fn blob_there(word: u32, along: f32) -> BlobThere {
    let leaf = word - (word - params.leaves_at) % LEAF_WORDS;
    let center = bitcast<vec3f>(heap(leaf).xyz);
    let head = heap(word);
    let point = point_relative_to(center, base) + ray.direction * along;
    let y = blob_transform(word, head, point - blob_center(word, head));
    return BlobThere(
        1.0 - dot(y, y),
        blob_weight(word),
        blob_index(word),
        blob_transform_transposed(word, head, y),
    );
}

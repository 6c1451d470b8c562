// All blobs of a field that reach a point, one by one: add_blob(word, its first word, from its centre, the same
// in its metric, 1 − q) hears of each. Twin of FieldAt::for_each_blob_at.

// By how much boxes are wider, for rounding, in coordinates.
const BOX_ROUNDING: f32 = 1e-6;

var<private> pending: array<u32, STACK>;
// Whether all were looked at, and their sums have enough digits.
var<private> is_sure: bool;
// Where the field stands at the question's time, if it has a way.
var<private> placement: Placement;

// Readies the field for a question's time.
fn stand_at(secs: f32) {
    let time = clamp(secs, field_place.open, field_place.close);
    ray.since_middle_secs = time - 0.5 * (field_place.open + field_place.close);
    ray.elapsed = 0.0;
    if field_place.close > field_place.open {
        ray.elapsed = (time - field_place.open) / (field_place.close - field_place.open);
    }
    let way = way_of(field_place.surface);
    if way.y > 0u {
        placement = placement_at(way, secs);
    }
    is_sure = true;
}

// A point in the field's space, from one in the stages'.
fn in_field(high: vec3f, low: vec3f) -> TwoVec3 {
    if way_of(field_place.surface).y > 0u {
        return point_in_object(placement, TwoVec3(high, low));
    }
    let moved = two_sum(high, -field_place.offset);
    return two_sum(moved.high, moved.low + (low - field_place.offset_low));
}

fn add_leaf(reference: u32, point: TwoVec3) {
    let first = params.leaves_at + (reference & ~LEAF) * LEAF_WORDS;
    let header = heap(first);
    let from_center = two_sum(point.high, -bitcast<vec3f>(header.xyz));
    let local = from_center.high + (from_center.low + point.low);
    for (var lane = 0u; lane < header.w; lane++) {
        let at = first + LEAF_HEADER_WORDS + lane * BLOB_WORDS;
        let head = heap(at);
        let d = local - blob_center(at, head);
        let y = blob_transform(at, head, d);
        let g = 1.0 - dot(y, y);
        if g > 0.0 {
            add_blob(at, head, d, y, g);
        }
    }
}

// Looks at all blobs that reach a local point.
fn gather(point: TwoVec3) {
    let margin = BOX_ROUNDING * size_of(point.high);
    let lower = point.high - margin;
    let upper = point.high + margin;
    pending[0] = 0u;
    var height = 1u;
    while height > 0u {
        height--;
        let reference = pending[height];
        if (reference & LEAF) != 0u {
            add_leaf(reference, point);
            continue;
        }
        let node = reference * NODE_WORDS;
        for (var half = 0u; half < 2u; half++) {
            let children = heap(node + CHILDREN_AT + half);
            if children.x == NONE {
                break;
            }
            var holds = vec4<bool>(true);
            for (var axis = 0u; axis < 3u; axis++) {
                holds &= bounds_at(node, axis * 2u + half) <= vec4f(upper[axis]);
                holds &= bounds_at(node, axis * 2u + 6u + half) >= vec4f(lower[axis]);
            }
            for (var slot = 0u; slot < 4u; slot++) {
                if children[slot] == NONE || !holds[slot] {
                    continue;
                }
                if height == STACK {
                    is_sure = false;
                    return;
                }
                pending[height] = children[slot];
                height++;
            }
        }
    }
}

// As in intersect/hit.wgsl.
fn is_whole() -> bool {
    var rounds = 0u;
    for (var i = 0u; i < params.capacity; i++) {
        rounds++;
    }
    return rounds == params.capacity;
}

// Radix sort of 64-bit keys, eight bits at a time, stable: equal keys stay in order. Ranks within a
// workgroup are counted in bit masks, so no subgroups are needed (Merrill & Grimshaw 2011, §4, for the
// steps).

struct SortParams {
    count: u32,
    blocks: u32,
    // Lowest bit of the digit.
    shift: u32,
}

@group(0) @binding(0) var<uniform> params: SortParams;
@group(0) @binding(1) var<storage, read> keys: array<vec2u>;
@group(0) @binding(2) var<storage, read> values: array<u32>;
@group(0) @binding(3) var<storage, read_write> sorted_keys: array<vec2u>;
@group(0) @binding(4) var<storage, read_write> sorted_values: array<u32>;
// How many keys have a digit in a block; then how many have it in the blocks before.
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;
// How many keys have a digit.
@group(0) @binding(6) var<storage, read_write> totals: array<u32>;

const DIGITS: u32 = 256u;
// Keys of a block, in rounds of one per invocation.
const ROUNDS: u32 = 16u;
const MASK_WORDS: u32 = DIGITS / 32u;

fn digit_of(key: vec2u) -> u32 {
    let word = select(key.x, key.y, params.shift >= 32u);
    return (word >> (params.shift & 31u)) & (DIGITS - 1u);
}

var<workgroup> block_counts: array<atomic<u32>, DIGITS>;

@compute @workgroup_size(DIGITS)
fn count(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    atomicStore(&block_counts[lane], 0u);
    workgroupBarrier();
    for (var round = 0u; round < ROUNDS; round++) {
        let index = (group.x * ROUNDS + round) * DIGITS + lane;
        if index < params.count {
            atomicAdd(&block_counts[digit_of(keys[index])], 1u);
        }
    }
    workgroupBarrier();
    counts[lane * params.blocks + group.x] = atomicLoad(&block_counts[lane]);
}

var<workgroup> sums: array<u32, DIGITS>;

// Sum of the values of all lanes up to and with this one.
fn sum_up_to(lane: u32, value: u32) -> u32 {
    sums[lane] = value;
    workgroupBarrier();
    for (var step = 1u; step < DIGITS; step <<= 1u) {
        var before = 0u;
        if lane >= step {
            before = sums[lane - step];
        }
        workgroupBarrier();
        sums[lane] += before;
        workgroupBarrier();
    }
    return sums[lane];
}

// One workgroup per digit.
@compute @workgroup_size(DIGITS)
fn scan(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let row = group.x * params.blocks;
    var before = 0u;
    for (var first = 0u; first < params.blocks; first += DIGITS) {
        let block = first + lane;
        var value = 0u;
        if block < params.blocks {
            value = counts[row + block];
        }
        let sum = sum_up_to(lane, value);
        if block < params.blocks {
            counts[row + block] = before + sum - value;
        }
        before += sums[DIGITS - 1u];
        workgroupBarrier();
    }
    if lane == 0u {
        totals[group.x] = before;
    }
}

// Which lanes have a digit.
var<workgroup> masks: array<atomic<u32>, 2048>;
// Where the next key with a digit goes.
var<workgroup> next: array<u32, DIGITS>;

@compute @workgroup_size(DIGITS)
fn scatter(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let total = totals[lane];
    next[lane] = sum_up_to(lane, total) - total + counts[lane * params.blocks + group.x];
    for (var round = 0u; round < ROUNDS; round++) {
        for (var word = 0u; word < MASK_WORDS; word++) {
            atomicStore(&masks[lane * MASK_WORDS + word], 0u);
        }
        workgroupBarrier();
        let index = (group.x * ROUNDS + round) * DIGITS + lane;
        let is_key = index < params.count;
        var key = vec2u(0u);
        var digit = 0u;
        if is_key {
            key = keys[index];
            digit = digit_of(key);
            atomicOr(&masks[digit * MASK_WORDS + lane / 32u], 1u << (lane & 31u));
        }
        workgroupBarrier();
        if is_key {
            let own = lane / 32u;
            let lower = (1u << (lane & 31u)) - 1u;
            var place = next[digit];
            place += countOneBits(atomicLoad(&masks[digit * MASK_WORDS + own]) & lower);
            for (var word = 0u; word < own; word++) {
                place += countOneBits(atomicLoad(&masks[digit * MASK_WORDS + word]));
            }
            sorted_keys[place] = key;
            sorted_values[place] = values[index];
        }
        workgroupBarrier();
        for (var word = 0u; word < MASK_WORDS; word++) {
            next[lane] += countOneBits(atomicLoad(&masks[lane * MASK_WORDS + word]));
        }
        workgroupBarrier();
    }
}

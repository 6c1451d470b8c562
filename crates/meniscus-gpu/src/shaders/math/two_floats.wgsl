// Sums and products of two f32 with their rounding error, where a GPU has no f64 (Dekker 1971).

struct TwoVec3 {
    high: vec3f,
    low: vec3f,
}

// a + b and what rounding took (Knuth).
fn two_sum(a: vec3f, b: vec3f) -> TwoVec3 {
    let sum = a + b;
    let b_seen = sum - a;
    return TwoVec3(sum, (a - (sum - b_seen)) + (b - b_seen));
}

// The leading half of the digits.
fn leading(a: vec3f) -> vec3f {
    return bitcast<vec3f>(bitcast<vec3u>(a) & vec3u(0xfffff000u));
}

// a · b and what rounding took, by halves whose products are exact; fused multiply and add is not
// sure to be fused everywhere.
fn two_product(a: vec3f, b: vec3f) -> TwoVec3 {
    let product = a * b;
    let a_lead = leading(a);
    let b_lead = leading(b);
    let a_rest = a - a_lead;
    let b_rest = b - b_lead;
    let error = ((a_lead * b_lead - product) + a_lead * b_rest + a_rest * b_lead) + a_rest * b_rest;
    return TwoVec3(product, error);
}

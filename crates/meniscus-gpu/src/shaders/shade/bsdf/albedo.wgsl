// How much light a rough boundary reflects in all: tables of the library, twin of shade/bsdf/albedo.rs.

// The entry below and the part of the way to the next one.
fn albedo_place(part: f32) -> vec2f {
    let position = clamp(part, 0.0, 1.0) * f32(ALBEDO_ENTRIES - 1u);
    let below = min(floor(position), f32(ALBEDO_ENTRIES - 2u));
    return vec2f(below, position - below);
}

fn albedo_in_row(table: u32, row: u32, column: vec2f) -> f32 {
    let first = row * ALBEDO_ENTRIES + u32(column.x);
    return mix(number(table, first), number(table, first + 1u), column.y);
}

fn albedo_at(table: u32, cosine: f32, roughness: f32) -> f32 {
    let row = albedo_place(roughness);
    let column = albedo_place(sqrt(max(cosine, 0.0)));
    let below = albedo_in_row(table, u32(row.x), column);
    return mix(below, albedo_in_row(table, u32(row.x) + 1u, column), row.y);
}

fn albedo_mean(table: u32, roughness: f32) -> f32 {
    let row = albedo_place(roughness);
    let first = ALBEDO_ENTRIES * ALBEDO_ENTRIES + u32(row.x);
    return mix(number(table, first), number(table, first + 1u), row.y);
}

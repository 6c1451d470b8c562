// An image all around: twin of frame/environment/. Numbers: columns, rows, the first texel's word; vectors:
// the image's right, the zenith, its middle. The parts of the rows follow the texels.

// Column and row, as parts of width and height.
fn image_place(emitter: Emitter, direction: vec3f) -> vec2f {
    let right = dot(emitter.first, direction);
    let up = dot(emitter.second, direction);
    let forward = dot(emitter.third, direction);
    let cosine = clamp(up, -1.0, 1.0);
    let from_zenith = arc_tan2(sqrt((1.0 - cosine) * (1.0 + cosine)), cosine);
    return vec2f(0.5 + arc_tan2(right, forward) / TAU, from_zenith / PI);
}

fn image_texel(emitter: Emitter, column: i32, row: i32) -> vec4f {
    let width = i32(emitter.a);
    let x = (column % width + width) % width;
    let y = clamp(row, 0, i32(emitter.b) - 1);
    return words[u32(emitter.at) + u32(y * width + x)];
}

fn image_radiance(emitter: Emitter, direction: vec3f) -> vec3f {
    let place = image_place(emitter, direction);
    let x = place.x * emitter.a - 0.5;
    let y = clamp(place.y * emitter.b - 0.5, 0.0, emitter.b - 1.0);
    let left = i32(floor(x));
    let above = i32(floor(y));
    let part = vec2f(x - floor(x), y - floor(y));
    let upper = mix(image_texel(emitter, left, above), image_texel(emitter, left + 1, above), part.x);
    let lower = mix(image_texel(emitter, left, above + 1), image_texel(emitter, left + 1, above + 1), part.x);
    return mix(upper, lower, part.y).xyz * emitter.radiance;
}

// Part of the light of the rows before `row`.
fn rows_before(emitter: Emitter, row: u32) -> f32 {
    if row == 0u {
        return 0.0;
    }
    return number(u32(emitter.at) + u32(emitter.a) * u32(emitter.b), row - 1u);
}

// Part of the light of a row before `column`.
fn columns_before(emitter: Emitter, row: u32, column: u32) -> f32 {
    if column == 0u {
        return 0.0;
    }
    return image_texel(emitter, i32(column) - 1, i32(row)).w;
}

// cos at the upper edge of a row.
fn row_top(emitter: Emitter, row: u32) -> f32 {
    return cos_sin(PI * f32(row) / emitter.b).x;
}

// Solid angle of a texel.
fn texel_solid(emitter: Emitter, row: u32) -> f32 {
    // cos a − cos b without loss of digits next to the poles.
    let middle = PI * (f32(row) + 0.5) / emitter.b;
    let half = 0.5 * PI / emitter.b;
    return 2.0 * cos_sin(middle).y * cos_sin(half).y * TAU / emitter.a;
}

fn image_density(emitter: Emitter, direction: vec3f) -> f32 {
    let place = image_place(emitter, direction);
    let row = min(u32(place.y * emitter.b), u32(emitter.b) - 1u);
    let column = min(u32(max(place.x, 0.0) * emitter.a), u32(emitter.a) - 1u);
    let row_part = rows_before(emitter, row + 1u) - rows_before(emitter, row);
    let part = columns_before(emitter, row, column + 1u) - columns_before(emitter, row, column);
    return row_part * part / texel_solid(emitter, row);
}

fn image_sample(emitter: Emitter, u: vec2f) -> LightSample {
    // The first row, then column, whose sum lies above the number.
    var low = 0u;
    var high = u32(emitter.b) - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if rows_before(emitter, middle + 1u) > u.y {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    let row = low;
    low = 0u;
    high = u32(emitter.a) - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if columns_before(emitter, row, middle + 1u) > u.x {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    let column = low;
    let rows = vec2f(rows_before(emitter, row), rows_before(emitter, row + 1u));
    let columns = vec2f(columns_before(emitter, row, column), columns_before(emitter, row, column + 1u));
    let parts = vec2f(columns.y - columns.x, rows.y - rows.x);
    if !(parts.x > 0.0 && parts.y > 0.0) {
        return no_light();
    }
    let through = clamp((u - vec2f(columns.x, rows.x)) / parts, vec2f(0.0), vec2f(0.9999999));
    let top = row_top(emitter, row);
    let cosine = top + (row_top(emitter, row + 1u) - top) * through.y;
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    let azimuth = ((f32(column) + through.x) / emitter.a - 0.5) * TAU;
    let turn = cos_sin(azimuth);
    let around = emitter.first * turn.y + emitter.third * turn.x;
    let towards = normalize(around * sine + emitter.second * cosine);
    let density = parts.x * parts.y / texel_solid(emitter, row);
    return LightSample(towards, FAR, image_radiance(emitter, towards) / density, density, true);
}

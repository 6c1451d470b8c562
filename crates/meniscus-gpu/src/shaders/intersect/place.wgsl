// Where the field stands that a stage is about.

struct FieldPlace {
    // The field's origin relative to that of the stages, as a sum of two f32.
    offset: vec3f,
    surface: u32,
    offset_low: vec3f,
    // 0: first surfaces, 1: lights.
    kind: u32,
    // Local box around all supports; when the field's shutter opens and closes.
    lower: vec3f,
    open: f32,
    upper: vec3f,
    close: f32,
}

@group(0) @binding(7) var<uniform> field_place: FieldPlace;

//! Shaders are put together from files, one per subject and named as their CPU twins; what varies is
//! which kernel, which primitive, whether blobs move, and some numbers in front.

use meniscus::field::BlobField;
use meniscus::kernel::Kernel;

/// Rays that one workgroup traces.
pub(crate) const WORKGROUP: u32 = 64;

/// Records of a ray that asks for all its crossings.
pub(crate) const CROSSINGS: u32 = 8;

/// What blobs do while the shutter is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FieldMotion {
    /// Nothing.
    Still,
    /// They move.
    Moves,
    /// They move, turn and stretch: ellipsoids.
    Turns,
}

impl FieldMotion {
    /// That of a field.
    pub fn of(field: &BlobField) -> Self {
        match &field.motion {
            None => Self::Still,
            Some(motion) if motion.turns() => Self::Turns,
            Some(_) => Self::Moves,
        }
    }

    /// Whether there is any.
    pub fn moves(self) -> bool {
        self != Self::Still
    }

    /// Words of it that a blob has.
    pub(crate) fn words(self) -> usize {
        match self {
            Self::Still => 0,
            Self::Moves => 2,
            Self::Turns => 5,
        }
    }
}

/// What a shader is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ShaderKind {
    /// Kernel of the field.
    pub kernel: Kernel,
    /// Ellipsoids, else balls.
    pub ellipsoids: bool,
    /// What its blobs do while the shutter is open.
    pub motion: FieldMotion,
    /// Storage buffers that hold the field.
    pub chunks: u32,
    /// Words (16 bytes) per full buffer, as a power of two.
    pub chunk_bits: u32,
    /// References that a ray may keep for later.
    pub stack: u32,
}

/// The formula of a kernel.
pub(crate) fn kernel_source(kernel: Kernel) -> &'static str {
    match kernel {
        Kernel::Quartic => include_str!("shaders/kernel/quartic.wgsl"),
        Kernel::Sextic => include_str!("shaders/kernel/sextic.wgsl"),
        Kernel::Octic => include_str!("shaders/kernel/octic.wgsl"),
        Kernel::Wyvill => include_str!("shaders/kernel/wyvill.wgsl"),
    }
}

/// What all shaders have that walk the tree of a field, its buffers from binding `first_chunk` on.
pub(crate) fn field_parts(kind: &ShaderKind, first_chunk: u32) -> [String; 7] {
    let field = Heap {
        binding: first_chunk,
        chunks: kind.chunks,
        chunk_bits: kind.chunk_bits,
    };
    let primitive = match kind.ellipsoids {
        false => include_str!("shaders/primitive/ball.wgsl"),
        true => include_str!("shaders/primitive/ellipsoid.wgsl"),
    };
    let motion = match kind.motion {
        FieldMotion::Still => include_str!("shaders/field/still.wgsl"),
        FieldMotion::Moves | FieldMotion::Turns => include_str!("shaders/field/moving.wgsl"),
    };
    let turn = match kind.motion {
        FieldMotion::Still | FieldMotion::Moves => include_str!("shaders/field/rigid.wgsl"),
        FieldMotion::Turns => include_str!("shaders/field/turning.wgsl"),
    };
    let rates = constants([("RATE_WORDS", kind.motion.words() as u32)]);
    let texts = [
        include_str!("shaders/field/blobs.wgsl"),
        kernel_source(kind.kernel),
        primitive,
        motion,
        turn,
        include_str!("shaders/accel/particles.wgsl"),
    ];
    let [blobs, kernel, primitive, motion, turn, tree] = texts.map(str::to_owned);
    let blobs = rates + &blobs;
    [
        field.reader("heap"),
        blobs,
        kernel,
        primitive,
        motion,
        turn,
        tree,
    ]
}

/// The binding of a field's parameters.
pub(crate) fn params_at(binding: u32) -> String {
    format!("@group(0) @binding({binding}) var<uniform> params: Params;\n")
}

/// The whole text of a tracing shader.
pub fn sources(kind: &ShaderKind) -> String {
    [
        numbers(kind),
        params_at(0),
        include_str!("shaders/math/two_floats.wgsl").to_owned(),
        field_parts(kind, FIRST_CHUNK).join("\n"),
        include_str!("shaders/intersect/solve.wgsl").to_owned(),
        include_str!("shaders/intersect/hit.wgsl").to_owned(),
        include_str!("shaders/intersect/particles.wgsl").to_owned(),
        include_str!("shaders/intersect/stretches.wgsl").to_owned(),
        include_str!("shaders/intersect/crossings.wgsl").to_owned(),
    ]
    .join("\n")
}

/// No node, blob, surface.
pub(crate) const NONE: (&str, u32) = ("NONE", u32::MAX);

/// Numbers in front of a shader.
pub(crate) fn constants<'n>(numbers: impl IntoIterator<Item = (&'n str, u32)>) -> String {
    let line = |(name, number)| format!("const {name}: u32 = {number}u;\n");
    numbers.into_iter().map(line).collect()
}

fn numbers(kind: &ShaderKind) -> String {
    constants([
        NONE,
        ("WORKGROUP", WORKGROUP),
        ("STACK", kind.stack),
        ("CROSSINGS", CROSSINGS),
    ])
}

/// First binding of the field's buffers.
const FIRST_CHUNK: u32 = 5;

/// An array of words over several buffers, since a binding has a largest size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Heap {
    /// First binding.
    pub(crate) binding: u32,
    /// Buffers.
    pub(crate) chunks: u32,
    /// Words per full buffer, as a power of two.
    pub(crate) chunk_bits: u32,
}

impl Heap {
    /// The function `name(word)` that reads a word.
    pub(crate) fn reader(&self, name: &str) -> String {
        let read = |chunk: u32, place: &str| format!("return {name}{chunk}[{place}];");
        self.declared(name, "read")
            + &format!("fn {name}(word: u32) -> vec4u {{\n")
            + &self.at_chunk(read)
    }

    /// The function `name(word, value)` that writes a word.
    pub(crate) fn writer(&self, name: &str) -> String {
        let write = |chunk: u32, place: &str| format!("{name}{chunk}[{place}] = value;");
        self.declared(name, "read_write")
            + &format!("fn {name}(word: u32, value: vec4u) {{\n")
            + &self.at_chunk(write)
    }

    fn declared(&self, name: &str, access: &str) -> String {
        let mut text = String::new();
        for chunk in 0..self.chunks {
            let binding = self.binding + chunk;
            text += &format!(
                "@group(0) @binding({binding}) var<storage, {access}> {name}{chunk}: array<vec4u>;\n"
            );
        }
        text + "\n"
    }

    fn at_chunk(&self, statement: impl Fn(u32, &str) -> String) -> String {
        if self.chunks == 1 {
            return format!("    {}\n}}\n", statement(0, "word"));
        }
        let bits = self.chunk_bits;
        let mask = (1_u32 << bits) - 1;
        let mut text = format!("    let place = word & {mask}u;\n    switch word >> {bits}u {{\n");
        for chunk in 0..self.chunks - 1 {
            let statement = statement(chunk, "place");
            text += &format!("        case {chunk}u: {{ {statement} }}\n");
        }
        let last = statement(self.chunks - 1, "place");
        text + &format!("        default: {{ {last} }}\n    }}\n}}\n")
    }
}

/// A step of a tree's build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BuildStep {
    /// Places along the curve.
    Curve,
    /// Their sort.
    Sort,
    /// Leaves.
    Leaves,
    /// Nodes, level by level.
    Nodes,
}

impl BuildStep {
    /// Every step.
    pub const ALL: [Self; 4] = [Self::Curve, Self::Sort, Self::Leaves, Self::Nodes];
}

/// What the shaders are made for that build a tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BuildKind {
    /// Ellipsoids, else balls.
    pub ellipsoids: bool,
    /// Whether blobs move while the shutter is open.
    pub moves: bool,
    /// Storage buffers that hold the blobs.
    pub raw_chunks: u32,
    /// Storage buffers that hold the tree.
    pub tree_chunks: u32,
    /// Words (16 bytes) per full buffer, as a power of two.
    pub chunk_bits: u32,
}

impl BuildKind {
    /// The whole text of a step's shader.
    pub fn sources(&self, step: BuildStep) -> String {
        let heap = |binding, chunks| Heap {
            binding,
            chunks,
            chunk_bits: self.chunk_bits,
        };
        let raw = |binding| heap(binding, self.raw_chunks).reader("raw");
        let tree = |binding| heap(binding, self.tree_chunks).writer("put");
        let parts = match step {
            BuildStep::Curve => vec![
                self.numbers(),
                raw(3),
                include_str!("shaders/accel/build/curve.wgsl").to_owned(),
            ],
            BuildStep::Sort => vec![include_str!("shaders/accel/build/sort.wgsl").to_owned()],
            BuildStep::Leaves => vec![
                self.numbers(),
                raw(3),
                tree(3 + self.raw_chunks),
                include_str!("shaders/accel/build/leaves.wgsl").to_owned(),
            ],
            BuildStep::Nodes => vec![
                self.numbers(),
                tree(2),
                include_str!("shaders/accel/build/nodes.wgsl").to_owned(),
            ],
        };
        parts.join("\n")
    }

    /// Words of a box at all ends of the shutter that differ.
    pub(crate) fn box_words(&self) -> u32 {
        if self.moves { 4 } else { 2 }
    }

    fn numbers(&self) -> String {
        let Self {
            ellipsoids, moves, ..
        } = self;
        let shape = if *ellipsoids { 3 } else { 2 };
        let rates = if *moves { 2 } else { 0 };
        let extent_at = shape + rates;
        let raw = extent_at + if *moves { 2 } else { 1 };
        let boxes = self.box_words();
        format!(
            "const WORKGROUP: u32 = {WORKGROUP}u;\nconst ELLIPSOIDS: bool = {ellipsoids};\n\
             const MOVES: bool = {moves};\nconst SHAPE_WORDS: u32 = {shape}u;\n\
             const RATE_WORDS: u32 = {rates}u;\nconst EXTENT_AT: u32 = {extent_at}u;\n\
             const RAW_WORDS: u32 = {raw}u;\nconst BOX_WORDS: u32 = {boxes}u;\n"
        )
    }
}

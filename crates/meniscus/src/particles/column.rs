//! A named column of numbers, in the type that the file stores.

/// One property of all particles: `components` numbers per particle, interleaved.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The name in the file.
    pub name: String,
    /// Numbers per particle: 1 scalar, 3 vector, 6 or 9 tensor; never 0.
    pub components: usize,
    /// The numbers, particle by particle.
    pub data: ColumnData,
}

macro_rules! column_data {
    ($($variant:ident $type:ty, $name:literal;)*) => {
        /// Numbers in the type that the file stores.
        #[derive(Debug, Clone, PartialEq)]
        pub enum ColumnData {
            $(#[doc = concat!("Values of type ", $name, ".")] $variant(Vec<$type>),)*
        }

        impl ColumnData {
            /// How many numbers there are.
            pub fn len(&self) -> usize {
                match self { $(Self::$variant(values) => values.len(),)* }
            }

            /// Whether there is no number.
            pub fn is_empty(&self) -> bool {
                self.len() == 0
            }

            /// The element type's name: `f32`, `u8`, …
            pub fn type_name(&self) -> &'static str {
                match self { $(Self::$variant(_) => $name,)* }
            }

            /// Number `i` as f64 (integers beyond 2⁵³ round).
            ///
            /// # Panics
            /// If `i` is out of range.
            pub fn get(&self, i: usize) -> f64 {
                match self { $(Self::$variant(values) => values[i] as f64,)* }
            }

            /// Appends numbers `range` as little-endian bytes.
            pub(super) fn put_le_bytes(&self, range: std::ops::Range<usize>, bytes: &mut Vec<u8>) {
                match self { $(Self::$variant(values) => {
                    for value in &values[range] {
                        bytes.extend(value.to_le_bytes());
                    }
                })* }
            }

            fn read(&self, first: usize, stride: usize, out: &mut [f64]) {
                match self { $(Self::$variant(values) => {
                    for (value, out) in values[first..].iter().step_by(stride).zip(out) {
                        *out = *value as f64;
                    }
                })* }
            }

            /// Writes number `i` with as many digits as it takes to read it back exactly.
            pub(super) fn write_text(
                &self,
                i: usize,
                out: &mut impl std::io::Write,
            ) -> std::io::Result<()> {
                match self { $(Self::$variant(values) => write!(out, "{:?}", values[i]),)* }
            }

            /// Values chosen particle by particle: from row `row` of `other` where the flag is true,
            /// else of these. What the types do not share is converted, saturating.
            pub(super) fn picked(
                &self,
                other: &Self,
                rows: impl Iterator<Item = (bool, usize)>,
                components: usize,
            ) -> Self {
                match self { $(Self::$variant(values) => {
                    let theirs = match other {
                        Self::$variant(theirs) => Some(theirs),
                        _ => None,
                    };
                    let pick = |(is_other, row): (bool, usize), component: usize| -> $type {
                        let at = row * components + component;
                        match (is_other, theirs) {
                            (false, _) => values[at],
                            (true, Some(theirs)) => theirs[at],
                            (true, None) => other.get(at) as $type,
                        }
                    };
                    let picked: Vec<$type> = rows
                        .flat_map(|row| (0..components).map(move |component| (row, component)))
                        .map(|(row, component)| pick(row, component))
                        .collect();
                    picked.into()
                })* }
            }

            fn select(&mut self, rows: &[usize], components: usize) {
                match self { $(Self::$variant(values) => {
                    *values = rows
                        .iter()
                        .flat_map(|&row| &values[row * components..(row + 1) * components])
                        .copied()
                        .collect();
                })* }
            }
        }

        $(impl From<Vec<$type>> for ColumnData {
            fn from(values: Vec<$type>) -> Self {
                Self::$variant(values)
            }
        })*
    };
}
column_data! {
    I8 i8, "i8";
    U8 u8, "u8";
    I16 i16, "i16";
    U16 u16, "u16";
    I32 i32, "i32";
    U32 u32, "u32";
    I64 i64, "i64";
    U64 u64, "u64";
    F32 f32, "f32";
    F64 f64, "f64";
}

impl Column {
    /// A column of `components` interleaved numbers per particle.
    pub fn new(name: impl Into<String>, components: usize, data: impl Into<ColumnData>) -> Self {
        Self {
            name: name.into(),
            components,
            data: data.into(),
        }
    }

    /// Number of particles covered.
    pub fn rows(&self) -> usize {
        self.data.len() / self.components
    }

    /// Component `component` of particle `row` as f64.
    ///
    /// # Panics
    /// If `row` or `component` is out of range.
    pub fn get(&self, row: usize, component: usize) -> f64 {
        debug_assert!(component < self.components);
        self.data.get(row * self.components + component)
    }

    /// Component `component` of the `out.len()` particles from row `first` on, as f64.
    ///
    /// # Panics
    /// If `first` or `component` is out of range.
    pub fn read(&self, first: usize, component: usize, out: &mut [f64]) {
        debug_assert!(component < self.components);
        self.data
            .read(first * self.components + component, self.components, out);
    }

    /// Keeps these rows, in this order.
    pub(super) fn select(&mut self, rows: &[usize]) {
        self.data.select(rows, self.components);
    }
}

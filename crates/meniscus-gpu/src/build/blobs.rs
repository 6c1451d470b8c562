//! A field as words of 16 bytes, blob by blob: what a leaf holds of it, with the place relative to the
//! field's origin, then its half extents with the class of its size, and where it moves what one f32
//! cannot hold of its place.

use crate::chunks::Word;
use crate::pack::{blob_words, pack_blob};
use crate::shader::FieldMotion;
use glam::Vec3;
use meniscus::accel::particles::layout::columns;
use meniscus::accel::particles::size_class;
use meniscus::field::BlobField;
use meniscus::primitive::{Ball, Ellipsoid, Primitive, Shapes};
use rayon::prelude::*;

/// Numbers of a blob at most: ellipsoids that move.
const MOST_COLUMNS: usize = 17;

/// The blobs of a field, ready to be sent.
pub(crate) struct RawBlobs {
    pub(crate) words: Vec<Word>,
    /// Corners of the box around their places.
    pub(crate) places: [Vec3; 2],
}

/// Words of a blob.
pub(crate) fn raw_words(field: &BlobField) -> usize {
    let motion = FieldMotion::of(field);
    let leaf_words = match field.shapes {
        Shapes::Balls(_) => blob_words::<Ball>(motion),
        Shapes::Ellipsoids(_) => blob_words::<Ellipsoid>(motion),
    };
    leaf_words + if motion.moves() { 2 } else { 1 }
}

impl RawBlobs {
    /// Those of `field`.
    pub(crate) fn of(field: &BlobField) -> Self {
        match field.shapes {
            Shapes::Balls(_) => Self::of_primitive::<Ball>(field),
            Shapes::Ellipsoids(_) => Self::of_primitive::<Ellipsoid>(field),
        }
    }

    fn of_primitive<P: Primitive>(field: &BlobField) -> Self {
        let per_blob = raw_words(field);
        let mut words = vec![[0; 4]; per_blob * field.len()];
        let places = words
            .par_chunks_mut(per_blob)
            .enumerate()
            .with_min_len(1 << 12)
            .map(|(i, words)| {
                let place = pack::<P>(field, i, words);
                [place; 2]
            })
            .reduce(
                || [Vec3::INFINITY, Vec3::NEG_INFINITY],
                |a, b| [a[0].min(b[0]), a[1].max(b[1])],
            );
        Self { words, places }
    }
}

/// Packs a blob; returns its place.
fn pack<P: Primitive>(field: &BlobField, i: usize, words: &mut [Word]) -> Vec3 {
    let mut numbers = [0.0_f32; MOST_COLUMNS];
    let columns = columns::<P>();
    let (exact, rates) = match &field.motion {
        None => (field.center(i).as_dvec3(), None),
        Some(motion) => {
            let middle = motion.middle_secs();
            let [velocity, half] = motion.rates(i);
            let rates = [velocity + half * (2.0 * middle), half].map(|rate| rate.as_vec3());
            (field.at(middle).center(i), Some(rates))
        }
    };
    let place = exact.as_vec3();
    numbers[..3].copy_from_slice(&place.to_array());
    P::pack(&field.shapes, i, &mut numbers[3..3 + P::COLUMNS]);
    numbers[columns - 2] = field.weights[i];
    if let Some([velocity, half]) = rates {
        numbers[columns..columns + 3].copy_from_slice(&velocity.to_array());
        numbers[columns + 3..columns + 6].copy_from_slice(&half.to_array());
    }
    let motion = FieldMotion::of(field);
    let leaf_words = blob_words::<P>(motion);
    pack_blob::<P>(&mut words[..leaf_words], motion, |k| {
        if k == columns - 1 {
            i as u32
        } else {
            numbers[k].to_bits()
        }
    });
    let [x, y, z] = field.shapes.half_extents(i).map(f32::to_bits);
    words[leaf_words] = [x, y, z, size_class(field.shapes.mean_radius(i)) as u32];
    if rates.is_some() {
        let low = (exact - place.as_dvec3()).as_vec3().to_array();
        let [x, y, z] = low.map(f32::to_bits);
        words[leaf_words + 1] = [x, y, z, 0];
    }
    place
}

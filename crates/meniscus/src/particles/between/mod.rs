//! Particles at a moment between two frames.
//!
//! A particle that both frames have follows the cubic Hermite curve through its two positions with its
//! velocities there; where velocities are missing, or do not fit the displacements, those of the
//! differences between frames. One that only the later frame has moves as it does there and grows,
//! one that only the earlier frame has shrinks: [`Role::SupportScale`] says how far.

mod keys;
mod motion;
mod shapes;

use super::{Column, ColumnData, Particles, Role};
use glam::DVec3;
use keys::Keys;
use motion::{Around, Motion, disagreement, usable, vectors};
use std::sync::Arc;

/// The column that says how much of its support a particle has.
const SUPPORT_SCALE: &str = "support_scale";
/// What has less of its support is left out: f32 and eyes see nothing of it.
const LEAST_SCALE: f64 = 1.0 / 64.0;

/// What makes a particle of one frame the same as one of another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Identity {
    /// The column of ids, [`Role::Id`].
    Ids,
    /// The row of its file: molecules and their trajectories list the same atoms in the same order.
    Rows,
}

/// A frame and its moment.
#[derive(Debug, Clone)]
pub struct Moment {
    /// What errors call it, such as its file.
    pub name: String,
    /// The particles.
    pub particles: Arc<Particles>,
    /// The time, in the unit that velocities count in.
    pub time: f64,
}

/// How frames are joined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BetweenSettings {
    /// What makes particles the same.
    pub identity: Identity,
    /// Factor that turns the velocities of the file into its unit of length per unit of time.
    pub velocity_scale: f64,
}

/// Frames that cannot be joined.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BetweenError {
    /// No ids.
    #[error(
        "{frame}: no column of ids to know the particles by in the next frame: expected a column \
         `id` (or particle_id, ids, pid, gid, idx); there are {there}"
    )]
    NoIds {
        /// The frame.
        frame: String,
        /// The columns there are.
        there: String,
    },
    /// One id, two particles.
    #[error("{frame}: column `{column}` has id {id} twice, in rows {first} and {second}")]
    Duplicate {
        /// The frame.
        frame: String,
        /// The column.
        column: String,
        /// The id.
        id: f64,
        /// Row of the first particle.
        first: u32,
        /// Row of the second.
        second: u32,
    },
}

/// A particle of the pair: its index in the frames that have it.
#[derive(Debug, Clone, Copy)]
enum Place {
    Both(usize, usize),
    EarlierOnly(usize),
    LaterOnly(usize),
}

/// Two frames, joined.
#[derive(Debug, Clone)]
pub struct Pair {
    earlier: Arc<Particles>,
    later: Arc<Particles>,
    places: Vec<Place>,
    motions: Vec<Motion>,
    disagreement: Option<f64>,
}

impl Pair {
    /// Joins frame `earlier` to `later`. The frames before and after them, where there are any, help to
    /// estimate velocities that the files do not give. The times of all must rise.
    ///
    /// # Errors
    /// When particles have no ids or share one.
    pub fn new(
        before: Option<&Moment>,
        earlier: &Moment,
        later: &Moment,
        after: Option<&Moment>,
        settings: &BetweenSettings,
    ) -> Result<Self, BetweenError> {
        let keys = |moment: &Moment| Keys::new(moment, settings.identity);
        let (earlier_keys, later_keys) = (keys(earlier)?, keys(later)?);
        let (a, b) = (&*earlier.particles, &*later.particles);
        let mut places = Vec::with_capacity(a.len());
        for (index, key) in earlier_keys.of_particle.iter().enumerate() {
            places.push(match later_keys.index_of.get(key) {
                Some(&there) => Place::Both(index, there),
                None => Place::EarlierOnly(index),
            });
        }
        for (index, key) in later_keys.of_particle.iter().enumerate() {
            if !earlier_keys.index_of.contains_key(key) {
                places.push(Place::LaterOnly(index));
            }
        }
        let interval = later.time - earlier.time;
        let speed = settings.velocity_scale * interval;
        let mut velocities = [
            vectors(a, Role::Velocity, speed),
            vectors(b, Role::Velocity, speed),
        ];
        let disagreement = disagreement(a, b, &places, &velocities);
        if disagreement.is_some() {
            velocities = [None, None];
        }
        let around = Around {
            before: before.map(|m| Ok((m, keys(m)?))).transpose()?,
            after: after.map(|m| Ok((m, keys(m)?))).transpose()?,
            earlier,
            later,
        };
        let push = settings.velocity_scale * interval * interval;
        let accelerations = [
            vectors(a, Role::Acceleration, push),
            vectors(b, Role::Acceleration, push),
        ];
        let of = |list: &Option<Vec<DVec3>>, index: usize| list.as_ref().map(|list| list[index]);
        let motions = places
            .iter()
            .map(|&place| match place {
                Place::Both(i, j) => {
                    let (start, end) = (a.positions[i], b.positions[j]);
                    let differences =
                        || around.displacements(earlier_keys.of_particle[i], start, end);
                    let given = of(&velocities[0], i).zip(of(&velocities[1], j));
                    let (leaving, arriving) = given.unwrap_or_else(differences);
                    Motion::Through {
                        start,
                        end,
                        leaving,
                        arriving,
                    }
                }
                Place::EarlierOnly(i) => Motion::Alone {
                    at: 0.0,
                    position: a.positions[i],
                    velocity: of(&velocities[0], i).unwrap_or_else(|| {
                        around.velocity_before(earlier_keys.of_particle[i], a.positions[i])
                    }),
                    acceleration: usable(&velocities[0], &accelerations[0], i),
                },
                Place::LaterOnly(j) => Motion::Alone {
                    at: 1.0,
                    position: b.positions[j],
                    velocity: of(&velocities[1], j).unwrap_or_else(|| {
                        around.velocity_after(later_keys.of_particle[j], b.positions[j])
                    }),
                    acceleration: usable(&velocities[1], &accelerations[1], j),
                },
            })
            .collect();
        Ok(Self {
            earlier: earlier.particles.clone(),
            later: later.particles.clone(),
            places,
            motions,
            disagreement,
        })
    }

    /// Where velocities and displacements disagree so much that the former are not used: the factor
    /// that would make velocities fit.
    pub fn fitting_velocity_scale(&self) -> Option<f64> {
        self.disagreement.map(|ratio| 1.0 / ratio)
    }

    /// The particles at `fraction` of the interval, 0 to 1: those of both frames and those that leave,
    /// in the earlier frame's order, then those that come. Columns of floats are blended (those that
    /// describe shapes turn), of integers taken from the nearer frame; columns that one frame lacks are
    /// left out.
    pub fn at(&self, fraction: f64) -> Particles {
        let u = fraction.clamp(0.0, 1.0);
        let scale = |place: &Place| match place {
            Place::Both(..) => 1.0,
            Place::EarlierOnly(_) => 1.0 - u,
            Place::LaterOnly(_) => u,
        };
        let kept: Vec<usize> = (0..self.places.len())
            .filter(|&i| scale(&self.places[i]) >= LEAST_SCALE)
            .collect();
        let (a, b) = (&self.earlier, &self.later);
        let places: Vec<Place> = kept.iter().map(|&i| self.places[i]).collect();
        let mut columns: Vec<Column> = a
            .columns
            .iter()
            .filter_map(|column| {
                let other = b.column(&column.name)?;
                let is_alike =
                    other.components == column.components && column.name != SUPPORT_SCALE;
                is_alike.then(|| blended(column, other, &places, u))
            })
            .collect();
        shapes::turn(&mut columns, [a, b], &places, u);
        let owned = [a, b].map(|particles| particles.role(Role::SupportScale));
        let own = |side: usize, index: usize| owned[side].as_ref().map(|own| own.get(index, 0));
        let scales: Vec<f32> = places
            .iter()
            .map(|place| {
                let own = match *place {
                    Place::Both(i, j) => own(0, i).zip(own(1, j)).map(|(x, y)| x + (y - x) * u),
                    Place::EarlierOnly(i) => own(0, i),
                    Place::LaterOnly(j) => own(1, j),
                };
                (scale(place) * own.unwrap_or(1.0)) as f32
            })
            .collect();
        if scales.iter().any(|&scale| scale != 1.0) {
            columns.push(Column::new(SUPPORT_SCALE, 1, scales));
        }
        Particles {
            positions: kept.iter().map(|&i| self.motions[i].position(u)).collect(),
            rows: places
                .iter()
                .map(|place| match *place {
                    Place::Both(i, _) | Place::EarlierOnly(i) => a.rows[i],
                    Place::LaterOnly(j) => b.rows[j],
                })
                .collect(),
            columns,
        }
    }
}

/// A column at a fraction of the interval.
fn blended(a: &Column, b: &Column, places: &[Place], fraction: f64) -> Column {
    let components = a.components;
    let blend = |place: &Place, component: usize| match *place {
        Place::Both(i, j) => {
            let (from, to) = (a.get(i, component), b.get(j, component));
            from + (to - from) * fraction
        }
        Place::EarlierOnly(i) => a.get(i, component),
        Place::LaterOnly(j) => b.get(j, component),
    };
    let pairs = places
        .iter()
        .flat_map(|place| (0..components).map(move |component| (place, component)));
    let data: ColumnData = match (&a.data, &b.data) {
        (ColumnData::F32(_), _) => pairs
            .map(|(place, component)| blend(place, component) as f32)
            .collect::<Vec<f32>>()
            .into(),
        (ColumnData::F64(_), _) => pairs
            .map(|(place, component)| blend(place, component))
            .collect::<Vec<f64>>()
            .into(),
        _ => {
            let nearer = places.iter().map(|place| match *place {
                Place::Both(i, _) if fraction < 0.5 => (false, i),
                Place::Both(_, j) | Place::LaterOnly(j) => (true, j),
                Place::EarlierOnly(i) => (false, i),
            });
            a.data.picked(&b.data, nearer, components)
        }
    };
    Column {
        name: a.name.clone(),
        components,
        data,
    }
}

#[cfg(test)]
mod tests;

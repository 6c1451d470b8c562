//! Which particle of one frame is which of another.

use super::{BetweenError, Identity, Moment};
use crate::particles::{Particles, Role};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Names of the particles of a frame.
pub(super) struct Keys {
    pub(super) of_particle: Vec<u64>,
    pub(super) index_of: HashMap<u64, usize>,
}

impl Keys {
    pub(super) fn new(moment: &Moment, identity: Identity) -> Result<Self, BetweenError> {
        let particles = &*moment.particles;
        let (column, of_particle): (_, Vec<u64>) = match identity {
            Identity::Rows => (
                "row",
                particles.rows.iter().map(|&row| row.into()).collect(),
            ),
            Identity::Ids => {
                let ids = particles.role(Role::Id).and_then(|ids| ids.first_column());
                let ids = ids.ok_or_else(|| BetweenError::NoIds {
                    frame: moment.name.clone(),
                    there: columns_of(particles),
                })?;
                // + 0: there is one zero.
                let key = |row| (ids.get(row, 0) + 0.0).to_bits();
                (&*ids.name, (0..particles.len()).map(key).collect())
            }
        };
        let mut index_of = HashMap::with_capacity(of_particle.len());
        for (index, &key) in of_particle.iter().enumerate() {
            match index_of.entry(key) {
                Entry::Vacant(entry) => {
                    entry.insert(index);
                }
                Entry::Occupied(entry) => {
                    return Err(BetweenError::Duplicate {
                        frame: moment.name.clone(),
                        column: column.to_owned(),
                        id: match identity {
                            Identity::Ids => f64::from_bits(key),
                            Identity::Rows => key as f64,
                        },
                        first: particles.rows[*entry.get()],
                        second: particles.rows[index],
                    });
                }
            }
        }
        Ok(Self {
            of_particle,
            index_of,
        })
    }
}

pub(super) fn columns_of(particles: &Particles) -> String {
    let names: Vec<&str> = particles.columns.iter().map(|c| c.name.as_str()).collect();
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

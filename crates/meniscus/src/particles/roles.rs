//! Which columns mean what: radius, velocity, … under the names that files usually give them.
//!
//! To teach a new name: one entry in `Role::usual`.

use super::{Attribute, ColumnData, Particles};

/// A meaning that a column can have for us.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Role {
    /// Particle radius, in the file's unit; one component.
    Radius,
    /// Velocity, in the file's unit per second; three components.
    Velocity,
    /// Acceleration, in the file's unit per second squared; three components.
    Acceleration,
    /// A number that stays with a particle from frame to frame; one component.
    Id,
    /// Colour, 0 to 1; three components, or four with alpha.
    Color,
    /// The metric M of an ellipsoid's q = dᵀMd; six components or nine.
    Metric,
    /// How much of its support a particle has, 0 to 1: one that comes or goes; one component.
    SupportScale,
}

/// The usual names of one role.
struct Usual {
    /// How many components a column may have to play the role.
    components: &'static [usize],
    /// Names of whole columns, the preferred first, with the factor that turns them into the role.
    columns: &'static [(&'static str, f64)],
    /// Names of scalar columns that play the role together.
    groups: &'static [&'static [&'static str]],
}

impl Role {
    /// Every role.
    pub const ALL: [Self; 7] = [
        Self::Radius,
        Self::Velocity,
        Self::Acceleration,
        Self::Id,
        Self::Color,
        Self::Metric,
        Self::SupportScale,
    ];

    /// The name under which [`Particles::attribute`] knows the role.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radius => "radius",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Id => "id",
            Self::Color => "color",
            Self::Metric => "metric",
            Self::SupportScale => "support_scale",
        }
    }

    /// The role of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.name() == name)
    }

    /// Where names are ambiguous: Houdini's `pscale` is a radius; `size` and `scale` may be radii or
    /// diameters and `h` or `smoothing_length` a support, so none of them counts; `u v w` count as a
    /// velocity only when all three are there; `F` (a deformation gradient) is no metric.
    fn usual(self) -> Usual {
        match self {
            Self::Radius => Usual {
                components: &[1],
                columns: &[
                    ("radius", 1.0),
                    ("pscale", 1.0),
                    ("particle_radius", 1.0),
                    ("ParticleRadius", 1.0),
                    ("radii", 1.0),
                    ("diameter", 0.5),
                ],
                groups: &[],
            },
            Self::Velocity => Usual {
                components: &[3],
                columns: &[
                    ("velocity", 1.0),
                    ("velocities", 1.0),
                    ("vel", 1.0),
                    ("v", 1.0),
                ],
                groups: &[
                    &["vx", "vy", "vz"],
                    &["v_x", "v_y", "v_z"],
                    &["velocity_x", "velocity_y", "velocity_z"],
                    &["velocityX", "velocityY", "velocityZ"],
                    &["vel_x", "vel_y", "vel_z"],
                    &["velx", "vely", "velz"],
                    &["u", "v", "w"],
                ],
            },
            Self::Acceleration => Usual {
                components: &[3],
                columns: &[
                    ("acceleration", 1.0),
                    ("accelerations", 1.0),
                    ("accel", 1.0),
                    ("acc", 1.0),
                    ("a", 1.0),
                ],
                groups: &[
                    &["ax", "ay", "az"],
                    &["a_x", "a_y", "a_z"],
                    &["acceleration_x", "acceleration_y", "acceleration_z"],
                    &["accelerationX", "accelerationY", "accelerationZ"],
                    &["accel_x", "accel_y", "accel_z"],
                    &["acc_x", "acc_y", "acc_z"],
                    &["au", "av", "aw"],
                ],
            },
            Self::Id => Usual {
                components: &[1],
                columns: &[
                    ("id", 1.0),
                    ("particle_id", 1.0),
                    ("particleid", 1.0),
                    ("ids", 1.0),
                    ("pid", 1.0),
                    ("gid", 1.0),
                    ("idx", 1.0),
                ],
                groups: &[],
            },
            Self::Color => Usual {
                components: &[3, 4],
                columns: &[
                    ("Cd", 1.0),
                    ("color", 1.0),
                    ("colour", 1.0),
                    ("colors", 1.0),
                    ("rgb", 1.0),
                    ("rgba", 1.0),
                ],
                groups: &[
                    &["red", "green", "blue", "alpha"],
                    &["red", "green", "blue"],
                    &["r", "g", "b", "a"],
                    &["r", "g", "b"],
                    &["diffuse_red", "diffuse_green", "diffuse_blue"],
                ],
            },
            Self::Metric => Usual {
                components: &[6, 9],
                columns: &[
                    ("metric", 1.0),
                    ("metric_tensor", 1.0),
                    ("anisotropy", 1.0),
                    ("G", 1.0),
                ],
                groups: &[],
            },
            Self::SupportScale => Usual {
                components: &[1],
                columns: &[("support_scale", 1.0)],
                groups: &[],
            },
        }
    }
}

impl Particles {
    /// The columns that play `role`, under their usual names: first as one column (in the spelling of
    /// the table, then in any case), then as a group of scalar columns. Integer colours of 8 and 16
    /// bits come out as 0 to 1.
    pub fn role(&self, role: Role) -> Option<Attribute<'_>> {
        let usual = role.usual();
        let column_as = |same: fn(&str, &str) -> bool| {
            usual.columns.iter().find_map(|&(name, scale)| {
                let column = self.columns.iter().find(|column| {
                    same(&column.name, name) && usual.components.contains(&column.components)
                })?;
                Some(Attribute::of_column(column).scaled(scale))
            })
        };
        let found = column_as(|a, b| a == b)
            .or_else(|| column_as(str::eq_ignore_ascii_case))
            .or_else(|| {
                usual
                    .groups
                    .iter()
                    .find_map(|names| self.scalars(role.name(), names))
            })
            .or_else(|| {
                usual.columns.iter().find_map(|(name, _)| {
                    self.group(name)
                        .filter(|group| usual.components.contains(&group.components()))
                })
            })?;
        let scale = match (role, found.first_column().map(|column| &column.data)) {
            (Role::Color, Some(ColumnData::U8(_))) => 1.0 / 255.0,
            (Role::Color, Some(ColumnData::U16(_))) => 1.0 / 65535.0,
            _ => 1.0,
        };
        Some(found.scaled(scale))
    }
}

#[cfg(test)]
mod tests;

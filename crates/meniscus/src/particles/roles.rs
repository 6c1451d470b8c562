//! Which columns mean what: radius, velocity, … under the names that files usually give them.
//!
//! To teach a new name: one entry in `usual.rs`.

mod usual;

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
    /// Gradient of the velocity about the particle, row by row, in 1/second: how its shape turns and
    /// stretches; nine components.
    VelocityGradient,
    /// Angular velocity of the particle's shape, in radians per second; three components.
    AngularVelocity,
    /// A number that stays with a particle from frame to frame; one component.
    Id,
    /// Colour, 0 to 1; three components, or four with alpha.
    Color,
    /// The metric M of an ellipsoid's q = dᵀMd; six components or nine.
    Metric,
    /// Radii of an ellipsoid along its axes, in the file's unit; three components.
    Radii,
    /// Axes of an ellipsoid, three vectors of three components; where no radii are given their lengths
    /// are the radii.
    Axes,
    /// A unit quaternion that turns the particle's own axes into those of space; x, y, z, w.
    Orientation,
    /// The deformation gradient F, row by row; nine components.
    Deformation,
    /// Anisotropic displacements U of an atom, in the file's unit squared; six components: U₁₁ U₂₂ U₃₃
    /// U₁₂ U₁₃ U₂₃.
    Displacements,
    /// How much of its support a particle has, 0 to 1: one that comes or goes; one component.
    SupportScale,
}

impl Role {
    /// Every role.
    pub const ALL: [Self; 14] = [
        Self::Radius,
        Self::Velocity,
        Self::Acceleration,
        Self::VelocityGradient,
        Self::AngularVelocity,
        Self::Id,
        Self::Color,
        Self::Metric,
        Self::Radii,
        Self::Axes,
        Self::Orientation,
        Self::Deformation,
        Self::Displacements,
        Self::SupportScale,
    ];

    /// The name under which [`Particles::attribute`] knows the role.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radius => "radius",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::VelocityGradient => "velocity_gradient",
            Self::AngularVelocity => "angular_velocity",
            Self::Id => "id",
            Self::Color => "color",
            Self::Metric => "metric",
            Self::Radii => "radii",
            Self::Axes => "axes",
            Self::Orientation => "orientation",
            Self::Deformation => "deformation_gradient",
            Self::Displacements => "anisou",
            Self::SupportScale => "support_scale",
        }
    }

    /// The role of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.name() == name)
    }
}

impl Role {
    /// Whether the first component of a column of this name belongs behind the others.
    pub(super) fn is_scalar_first(self, name: &str) -> bool {
        self.usual().scalar_first.contains(&name)
    }
}

impl Particles {
    /// The columns that play `role`, under their usual names: first as one column (in the spelling of
    /// the table, then in any case), then as a group of columns. Integer colours of 8 and 16
    /// bits come out as 0 to 1.
    pub fn role(&self, role: Role) -> Option<Attribute<'_>> {
        let usual = role.usual();
        let column_as = |same: fn(&str, &str) -> bool| {
            usual.columns.iter().find_map(|&(name, scale)| {
                let column = self.columns.iter().find(|column| {
                    same(&column.name, name) && usual.components.contains(&column.components)
                })?;
                let attribute = Attribute::of_column(column).scaled(scale);
                Some(if role.is_scalar_first(name) {
                    attribute.rotated_left()
                } else {
                    attribute
                })
            })
        };
        let found = column_as(|a, b| a == b)
            .or_else(|| column_as(str::eq_ignore_ascii_case))
            .or_else(|| {
                usual
                    .groups
                    .iter()
                    .find_map(|names| self.together(role.name(), names, usual.each(names)))
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

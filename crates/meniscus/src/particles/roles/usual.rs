//! The names that files usually give their columns.

use super::Role;

/// The usual names of one role.
pub(super) struct Usual {
    /// How many components a column may have to play the role.
    pub(super) components: &'static [usize],
    /// Names of whole columns, the preferred first, with the factor that turns them into the role.
    pub(super) columns: &'static [(&'static str, f64)],
    /// Names of columns that play the role together.
    pub(super) groups: &'static [&'static [&'static str]],
    /// Those among `columns` whose first component belongs behind the others.
    pub(super) scalar_first: &'static [&'static str],
}

impl Usual {
    const NONE: Self = Self {
        components: &[],
        columns: &[],
        groups: &[],
        scalar_first: &[],
    };

    /// How many components each column of a group has.
    pub(super) fn each(&self, group: &[&str]) -> usize {
        let whole = self.components.iter().find(|&&n| n % group.len() == 0);
        whole.map_or(1, |n| n / group.len())
    }
}

impl Role {
    /// Where names are ambiguous: Houdini's `pscale` is a radius; `size` and `scale` may be radii or
    /// diameters and `h` or `smoothing_length` a support, so none of them counts; `u v w` count as a
    /// velocity only when all three are there; `F` is a deformation gradient and no metric; `C` of nine
    /// components is the velocity gradient of APIC and Houdini's `w` an angular velocity; `scale` of
    /// three components is Houdini's factor on `pscale` or a splat's logarithm, so it counts as no
    /// radii. Quaternions come with their scalar last unless the name is known for the other order.
    pub(super) fn usual(self) -> Usual {
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
                ..Usual::NONE
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
                ..Usual::NONE
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
                ..Usual::NONE
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
                ..Usual::NONE
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
                ..Usual::NONE
            },
            Self::Metric => Usual {
                components: &[6, 9],
                columns: &[
                    ("metric", 1.0),
                    ("metric_tensor", 1.0),
                    ("anisotropy", 1.0),
                    ("G", 1.0),
                ],
                ..Usual::NONE
            },
            Self::Radii => Usual {
                components: &[3],
                columns: &[
                    ("radii", 1.0),
                    ("semi_axes", 1.0),
                    ("semiaxes", 1.0),
                    ("aspherical_shape", 1.0),
                    ("Aspherical Shape", 1.0),
                ],
                ..Usual::NONE
            },
            Self::Axes => Usual {
                components: &[9],
                columns: &[("axes", 1.0), ("principal_axes", 1.0)],
                groups: &[
                    &["axis1", "axis2", "axis3"],
                    &["axis_1", "axis_2", "axis_3"],
                    &["axis_a", "axis_b", "axis_c"],
                ],
                ..Usual::NONE
            },
            Self::Orientation => Usual {
                components: &[4],
                columns: &[
                    ("orientation", 1.0),
                    ("orient", 1.0),
                    ("quaternion", 1.0),
                    ("quat", 1.0),
                    ("rotation", 1.0),
                    ("quaternion_xyzw", 1.0),
                    ("quat_xyzw", 1.0),
                    ("quaternion_wxyz", 1.0),
                    ("quat_wxyz", 1.0),
                    ("orientation_wxyz", 1.0),
                    ("rotation_quaternion", 1.0),
                ],
                groups: &[
                    &["qx", "qy", "qz", "qw"],
                    &["q_x", "q_y", "q_z", "q_w"],
                    &["quat_x", "quat_y", "quat_z", "quat_w"],
                    &[
                        "orientation_x",
                        "orientation_y",
                        "orientation_z",
                        "orientation_w",
                    ],
                    &[
                        "Orientation.X",
                        "Orientation.Y",
                        "Orientation.Z",
                        "Orientation.W",
                    ],
                    &["quati", "quatj", "quatk", "quatw"],
                    &["q1", "q2", "q3", "q0"],
                ],
                scalar_first: &[
                    "quaternion_wxyz",
                    "quat_wxyz",
                    "orientation_wxyz",
                    "rotation_quaternion",
                ],
            },
            Self::Deformation => Usual {
                components: &[9],
                columns: &[
                    ("deformation_gradient", 1.0),
                    ("DeformationGradient", 1.0),
                    ("defgrad", 1.0),
                    ("def_grad", 1.0),
                    ("F", 1.0),
                ],
                ..Usual::NONE
            },
            Self::VelocityGradient => Usual {
                components: &[9],
                columns: &[
                    ("velocity_gradient", 1.0),
                    ("VelocityGradient", 1.0),
                    ("grad_v", 1.0),
                    ("gradv", 1.0),
                    ("C", 1.0),
                ],
                ..Usual::NONE
            },
            Self::AngularVelocity => Usual {
                components: &[3],
                columns: &[
                    ("angular_velocity", 1.0),
                    ("AngularVelocity", 1.0),
                    ("angvel", 1.0),
                    ("omega", 1.0),
                    ("w", 1.0),
                ],
                groups: &[
                    &["omega_x", "omega_y", "omega_z"],
                    &["omegax", "omegay", "omegaz"],
                ],
                ..Usual::NONE
            },
            Self::Displacements => Usual {
                components: &[6],
                columns: &[("anisou", 1.0), ("U_aniso", 1.0)],
                groups: &[&["U11", "U22", "U33", "U12", "U13", "U23"]],
                ..Usual::NONE
            },
            Self::SupportScale => Usual {
                components: &[1],
                columns: &[("support_scale", 1.0)],
                ..Usual::NONE
            },
        }
    }
}

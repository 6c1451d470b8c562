//! Shapes half way between two frames: turned evenly and stretched evenly.
//!
//! Numbers of a tensor that are blended one by one make a shape that turns thinner or rounder on its
//! way, and a turned gradient smaller. So quaternions turn evenly about one axis; a deformation gradient
//! is taken apart into a turn and a stretch, which change evenly each; the axes of a metric turn while
//! its radii change by even factors, along the shortest of such ways that leads from the one ellipsoid
//! to the other (Jung, Schwartzman & Groisser 2015). What cannot be taken apart is blended.

use super::Place;
use crate::math::symmetric::eigen;
use crate::math::turning::{taken_apart, turn_between, turned};
use crate::particles::{Attribute, Column, ColumnData, Particles, Role};
use glam::{DMat3, DQuat, DVec3};
use std::ops::Range;

/// What describes shapes that turn.
const SHAPES: [Role; 4] = [
    Role::Orientation,
    Role::Deformation,
    Role::Metric,
    Role::Axes,
];

/// Most numbers of such a role.
const MOST: usize = 9;

type Numbers = [f64; MOST];

/// Puts the shapes of particles that both frames have in the place of `columns`' blended numbers; rows
/// of `columns` are those of `places`.
pub(super) fn turn(
    columns: &mut [Column],
    [earlier, later]: [&Particles; 2],
    places: &[Place],
    fraction: f64,
) {
    for role in SHAPES {
        let (Some(from), Some(to)) = (earlier.role(role), later.role(role)) else {
            continue;
        };
        let count = from.components();
        let Some(targets) = targets(columns, &from).filter(|_| to.components() == count) else {
            continue;
        };
        let Some(form) = Form::of(role, [&from, &to], places) else {
            continue;
        };
        let numbers = |of: &Attribute<'_>, row: usize| {
            let mut numbers = [0.0; MOST];
            for (k, number) in numbers[..count].iter_mut().enumerate() {
                *number = of.get(row, k);
            }
            numbers
        };
        for (row, place) in places.iter().enumerate() {
            let Place::Both(i, j) = *place else {
                continue;
            };
            let between = form.between(numbers(&from, i), numbers(&to, j), fraction);
            let Some(between) = between.filter(|numbers| numbers.iter().all(|x| x.is_finite()))
            else {
                continue;
            };
            for (&(column, component), number) in targets.iter().zip(between) {
                let Column {
                    components, data, ..
                } = &mut columns[column];
                let at = row * *components + component;
                match data {
                    ColumnData::F32(values) => values[at] = number as f32,
                    ColumnData::F64(values) => values[at] = number,
                    _ => {}
                }
            }
        }
    }
}

/// Where the numbers of `role` stand in `columns`; `None` where one is missing.
fn targets(columns: &[Column], role: &Attribute<'_>) -> Option<Vec<(usize, usize)>> {
    let count = role.components();
    if !(4..=MOST).contains(&count) {
        return None;
    }
    role.sources()
        .map(|(name, component)| {
            let column = columns.iter().position(|column| column.name == name)?;
            Some((column, component))
        })
        .collect::<Option<Vec<_>>>()
        .filter(|targets| targets.len() == count)
}

/// How numbers describe a shape.
#[derive(Debug, Clone, Copy)]
enum Form {
    /// x y z w.
    Quaternion,
    /// Row by row.
    Gradient,
    /// Where xx xy xz yx yy yz zx zy zz stand.
    Metric([usize; 9]),
    /// One axis after the other.
    Axes,
}

/// xx xy xz yy yz zz, VTK's xx yy zz xy yz xz, and all nine.
const PLAIN: [usize; 9] = [0, 1, 2, 1, 3, 4, 2, 4, 5];
const VTK: [usize; 9] = [0, 3, 5, 3, 1, 4, 5, 4, 2];
const FULL: [usize; 9] = [0, 1, 2, 3, 4, 5, 6, 7, 8];

impl Form {
    fn of(role: Role, ends: [&Attribute<'_>; 2], places: &[Place]) -> Option<Self> {
        match (role, ends[0].components()) {
            (Role::Orientation, 4) => Some(Self::Quaternion),
            (Role::Deformation, 9) => Some(Self::Gradient),
            (Role::Axes, 9) => Some(Self::Axes),
            (Role::Metric, 9) => Some(Self::Metric(FULL)),
            (Role::Metric, 6) => {
                // In the order in which more particles have one, as fields read them.
                let definite = |order: [usize; 9]| {
                    let is_definite = |end: &Attribute<'_>, row: usize| {
                        let mut numbers = [0.0; MOST];
                        for (k, number) in numbers[..6].iter_mut().enumerate() {
                            *number = end.get(row, k);
                        }
                        principal(symmetric(&numbers, &order)).is_some()
                    };
                    let of_place = |place: &Place| match *place {
                        Place::Both(i, j) => is_definite(ends[0], i) && is_definite(ends[1], j),
                        Place::EarlierOnly(_) | Place::LaterOnly(_) => false,
                    };
                    places.iter().filter(|place| of_place(place)).count()
                };
                let is_vtk = definite(VTK) > definite(PLAIN);
                Some(Self::Metric(if is_vtk { VTK } else { PLAIN }))
            }
            _ => None,
        }
    }

    fn between(self, from: Numbers, to: Numbers, part: f64) -> Option<Numbers> {
        match self {
            Self::Quaternion => quaternion(from, to, part),
            Self::Gradient => {
                let square = |numbers: &Numbers| DMat3::from_cols_array(numbers).transpose();
                let between = gradient(square(&from), square(&to), part)?;
                Some(between.transpose().to_cols_array())
            }
            Self::Axes => axes(from, to, part),
            Self::Metric(order) => {
                let [from, to] = [from, to].map(|numbers| symmetric(&numbers, &order));
                let between = metric(from, to, part)?.to_cols_array();
                let mut numbers = [0.0; MOST];
                for (place, number) in order.into_iter().zip(between) {
                    numbers[place] = number;
                }
                Some(numbers)
            }
        }
    }
}

fn quaternion(from: Numbers, to: Numbers, part: f64) -> Option<Numbers> {
    let of = |n: Numbers| DQuat::from_xyzw(n[0], n[1], n[2], n[3]);
    let (from, to) = (of(from), of(to));
    let lengths = [from.length(), to.length()];
    let is_turn = lengths.iter().all(|&length| length > 0.0);
    is_turn.then(|| {
        let turn = turned(from / lengths[0], to / lengths[1], part);
        let turn = turn * (lengths[0] + (lengths[1] - lengths[0]) * part);
        let mut numbers = [0.0; MOST];
        numbers[..4].copy_from_slice(&turn.to_array());
        numbers
    })
}

/// Only what a gradient makes of a ball counts, which its negative does as well.
fn gradient(from: DMat3, to: DMat3, part: f64) -> Option<DMat3> {
    let parts = [from, to].map(|matrix| {
        let is_regular = matrix.determinant() != 0.0;
        is_regular.then(|| taken_apart(matrix * matrix.determinant().signum()))
    });
    let [Some((turn, stretch)), Some((to_turn, to_stretch))] = parts else {
        return None;
    };
    let stretch = stretch + (to_stretch - stretch) * part;
    Some(DMat3::from_quat(turned(turn, to_turn, part)) * stretch)
}

/// An axis and its opposite are the same.
fn axes(from: Numbers, to: Numbers, part: f64) -> Option<Numbers> {
    let (from, mut to) = (DMat3::from_cols_array(&from), DMat3::from_cols_array(&to));
    for k in 0..3 {
        if from.col(k).dot(to.col(k)) < 0.0 {
            *to.col_mut(k) = -to.col(k);
        }
    }
    let sign = from.determinant().signum();
    if from.determinant() * to.determinant() <= 0.0 {
        return None;
    }
    let (turn, stretch) = taken_apart(from * sign);
    let (to_turn, to_stretch) = taken_apart(to * sign);
    let stretch = stretch + (to_stretch - stretch) * part;
    let between = DMat3::from_quat(turned(turn, to_turn, part)) * stretch * sign;
    Some(between.to_cols_array())
}

fn symmetric(numbers: &Numbers, order: &[usize; 9]) -> DMat3 {
    let matrix = DMat3::from_cols_array(&order.map(|place| numbers[place]));
    (matrix + matrix.transpose()) * 0.5
}

/// The logarithms of the eigenvalues of a positive definite matrix, and its axes, right-handed.
fn principal(matrix: DMat3) -> Option<(DVec3, DMat3)> {
    let finite = matrix.to_cols_array().iter().all(|x| x.is_finite());
    let (values, mut axes) = finite.then(|| eigen(matrix))?;
    if axes.determinant() < 0.0 {
        axes.z_axis = -axes.z_axis;
    }
    let logarithms = DVec3::new(values.x.ln(), values.y.ln(), values.z.ln());
    (values.min_element() > 0.0 && logarithms.is_finite()).then_some((logarithms, axes))
}

/// The orders in which axes may be taken.
const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [2, 1, 0],
    [1, 0, 2],
];

/// Signs that axes may be given, up to the one that makes them right-handed.
const SIGNS: Range<u32> = 0..4;

/// The metric part of the way: of all that turn axes to axes and change radii by even factors, the way
/// with the least sum of squares of the angle and of the radii's logarithms.
fn metric(from: DMat3, to: DMat3, part: f64) -> Option<DMat3> {
    let ((from_logs, from_axes), (to_logs, to_axes)) = (principal(from)?, principal(to)?);
    let from_turn = DQuat::from_mat3(&from_axes);
    let mut best = (f64::INFINITY, from_turn, from_logs);
    for order in ORDERS {
        for signs in SIGNS {
            let sign = |bit: u32| if signs >> bit & 1 == 1 { -1.0 } else { 1.0 };
            let [x, y, z] = order.map(|k| to_axes.col(k));
            let mut axes = DMat3::from_cols(x * sign(0), y * sign(1), z);
            if axes.determinant() < 0.0 {
                axes.z_axis = -z;
            }
            let turn = DQuat::from_mat3(&axes);
            let turn = if from_turn.dot(turn) < 0.0 {
                -turn
            } else {
                turn
            };
            let logs = DVec3::from_array(order.map(|k| to_logs[k]));
            let (_, angle) = turn_between(from_turn, turn);
            // Eigenvalues are 1/radius².
            let cost = angle * angle + 0.25 * (logs - from_logs).length_squared();
            if cost < best.0 {
                best = (cost, turn, logs);
            }
        }
    }
    let (_, to_turn, to_logs) = best;
    let axes = DMat3::from_quat(turned(from_turn, to_turn, part));
    let logs = from_logs + (to_logs - from_logs) * part;
    let values = DVec3::new(logs.x.exp(), logs.y.exp(), logs.z.exp());
    Some(axes * DMat3::from_diagonal(values) * axes.transpose())
}

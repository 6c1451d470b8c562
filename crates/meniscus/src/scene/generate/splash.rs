//! The crown that a drop throws up from a puddle.
//!
//! Kinematic, after Yarin and Weiss (1995): a ring moves outward from the impact and throws liquid up
//! as it goes; whatever has left the ring flies on its own parabola. The rim, which left first, breaks
//! into jets and drops.

use super::Generated;
use super::ballistic::{self, GRAVITY, Motion};
use super::random::Random;
use super::staging::Staging;
use crate::math::aabb::DAabb;
use crate::scene::BlobSettings;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// When the crown looks best, in seconds after the impact.
const STILL_SECS: f64 = 0.24;
/// Until when the ring throws liquid up, in seconds after the impact.
const THROW_SECS: f64 = 0.235;
/// Jets around the rim.
const JETS: usize = 17;
/// 2π over the golden ratio squared: successive multiples spread evenly over the circle.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Shares of the particles: the crown's sheet, its rim with the jets, free drops; the rest is puddle.
const SHEET_SHARE: f64 = 0.24;
const RIM_SHARE: f64 = 0.07;
const DROPS_SHARE: f64 = 0.07;

/// Radius of the ring `secs` after the impact, in metres.
fn ring_radius(secs: f64) -> f64 {
    0.27 + 0.50 * secs.sqrt()
}

/// Speeds, outward and upward, at which the ring throws liquid at `secs`.
fn throw_speeds(secs: f64) -> (f64, f64) {
    let rest = 1.0 - secs / 0.30;
    (1.15 * rest + 0.10, 3.1 * rest)
}

/// Distance from the middle and height at `STILL_SECS` of what left the ring at `secs`.
fn profile_at_still(secs: f64) -> (f64, f64) {
    let (outward, upward) = throw_speeds(secs);
    let flight = STILL_SECS - secs;
    (
        ring_radius(secs) + outward * flight,
        (upward + 0.5 * GRAVITY.y * flight) * flight,
    )
}

/// When the ring throws which part of the sheet, such that the sheet is evenly covered at
/// [`STILL_SECS`]: cumulative areas over equal steps of time.
struct ThrowTimes {
    cumulative_area: Vec<f64>,
}

impl ThrowTimes {
    const STEPS: usize = 512;

    fn new() -> Self {
        let mut cumulative_area = vec![0.0];
        let mut area = 0.0;
        let secs = |step: usize| THROW_SECS * step as f64 / Self::STEPS as f64;
        for step in 0..Self::STEPS {
            let (r0, y0) = profile_at_still(secs(step));
            let (r1, y1) = profile_at_still(secs(step + 1));
            area += PI * (r0 + r1) * ((r1 - r0) * (r1 - r0) + (y1 - y0) * (y1 - y0)).sqrt();
            cumulative_area.push(area);
        }
        Self { cumulative_area }
    }

    fn area(&self) -> f64 {
        self.cumulative_area[Self::STEPS]
    }

    /// The time by which the share `u` of the sheet's area has been thrown.
    fn at(&self, u: f64) -> f64 {
        let wanted = u * self.area();
        let step = self
            .cumulative_area
            .partition_point(|&area| area <= wanted)
            .clamp(1, Self::STEPS);
        let (before, after) = (self.cumulative_area[step - 1], self.cumulative_area[step]);
        let within = (wanted - before) / (after - before);
        THROW_SECS * (step as f64 - 1.0 + within) / Self::STEPS as f64
    }
}

/// Unevenness of the crown around its circle.
struct Unevenness {
    phases: [f64; 4],
    jet_angles: Vec<f64>,
    jet_strengths: Vec<f64>,
}

impl Unevenness {
    fn new(random: &mut Random) -> Self {
        let step = TAU / JETS as f64;
        Self {
            phases: [(); 4].map(|()| random.range(0.0, TAU)),
            jet_angles: (0..JETS)
                .map(|jet| step * (jet as f64 + random.range(-0.22, 0.22)))
                .collect(),
            jet_strengths: (0..JETS).map(|_| random.range(0.45, 1.0)).collect(),
        }
    }

    /// Factor of the throwing speed at `angle`.
    fn speed_factor(&self, angle: f64) -> f64 {
        1.0 + 0.022 * (2.0 * angle + self.phases[0]).cos()
            + 0.018 * (5.0 * angle + self.phases[1]).cos()
            + 0.012 * (9.0 * angle + self.phases[2]).cos()
    }

    /// How strongly the jets pull the rim at `angle`: a bump around each jet.
    fn pull(&self, angle: f64) -> f64 {
        let width = 0.42 * TAU / JETS as f64;
        self.jet_angles
            .iter()
            .zip(&self.jet_strengths)
            .map(|(&jet, &strength)| {
                let distance = (angle - jet + PI).rem_euclid(TAU) - PI;
                let q = 1.0 - distance * distance / (width * width);
                strength * q.max(0.0) * q.max(0.0)
            })
            .sum()
    }
}

/// One particle: at rest in the puddle, then on a parabola, then at rest where it landed.
struct Flight {
    origin: DVec3,
    velocity: DVec3,
    launch_secs: f64,
    rest_height: f64,
}

impl Flight {
    fn resting(position: DVec3) -> Self {
        Self {
            origin: position,
            velocity: DVec3::ZERO,
            launch_secs: f64::INFINITY,
            rest_height: position.y,
        }
    }

    fn at(&self, time_secs: f64) -> Motion {
        let flight_secs = time_secs - self.launch_secs;
        if flight_secs <= 0.0 {
            return Motion::resting(self.origin);
        }
        // Falls back to the rest height at the later root of h + v t + g t²/2 = 0.
        let above = self.origin.y - self.rest_height;
        let (rise, g) = (self.velocity.y, -GRAVITY.y);
        let landing_secs = (rise + (rise * rise + 2.0 * g * above.max(0.0)).sqrt()) / g;
        if flight_secs < landing_secs {
            return Motion::launched(self.origin, self.velocity, flight_secs);
        }
        let landed = self.origin + self.velocity * landing_secs;
        Motion::resting(DVec3::new(landed.x, self.rest_height, landed.z))
    }
}

fn outward(angle: f64) -> DVec3 {
    DVec3::new(angle.cos(), 0.0, angle.sin())
}

/// `count` flights: puddle, sheet, rim and drops, with the spacing of the sheet at its best moment.
fn flights(count: usize, random: &mut Random) -> (Vec<Flight>, f64) {
    let share = |share: f64| (count as f64 * share) as usize;
    let (sheet, rim, drops) = (share(SHEET_SHARE), share(RIM_SHARE), share(DROPS_SHARE));
    let puddle = count - sheet - rim - drops;
    let times = ThrowTimes::new();
    let spacing = (times.area() / (count as f64 * SHEET_SHARE)).sqrt();
    let uneven = Unevenness::new(random);

    let mut flights = Vec::with_capacity(count);
    add_puddle(&mut flights, puddle, spacing, &uneven);
    for i in 0..sheet {
        let launch_secs = times.at((i as f64 + 0.5) / sheet as f64);
        let angle = (i as f64 * GOLDEN_ANGLE).rem_euclid(TAU);
        let (out, up) = throw_speeds(launch_secs);
        // The jets reach into the upper part of the sheet.
        let scallop = 0.10 * uneven.pull(angle) * (1.0 - launch_secs / 0.06).max(0.0);
        let factor = uneven.speed_factor(angle) + scallop;
        flights.push(Flight {
            origin: outward(angle) * ring_radius(launch_secs),
            velocity: (outward(angle) * out + DVec3::Y * up) * factor,
            launch_secs,
            rest_height: 0.0,
        });
    }
    add_rim(&mut flights, rim, spacing, &uneven, random);
    add_drops(&mut flights, drops, spacing, &uneven, random);
    (flights, spacing)
}

/// Two layers of an evenly covered disc with an uneven outline.
fn add_puddle(flights: &mut Vec<Flight>, count: usize, spacing: f64, uneven: &Unevenness) {
    let layers = [0.0, -0.8 * spacing];
    let per_layer = count.div_ceil(layers.len());
    let radius = spacing * (per_layer as f64 / PI).sqrt();
    for i in 0..count {
        let (layer, k) = (i % layers.len(), i / layers.len());
        let angle = k as f64 * GOLDEN_ANGLE + PI * layer as f64;
        let share = ((k as f64 + 0.5) / per_layer as f64).sqrt();
        let outline = 1.0
            + 0.035 * (3.0 * angle + uneven.phases[3]).cos()
            + 0.02 * (7.0 * angle + uneven.phases[1]).cos();
        let distance = radius * share * (1.0 + (outline - 1.0) * share);
        // Waves that run ahead of the ring.
        let ahead = (distance - ring_radius(STILL_SECS)).max(0.0);
        let wave = 0.018 * (-ahead / 0.22).exp() * (TAU * ahead / 0.17).sin();
        flights.push(Flight::resting(
            outward(angle) * distance + DVec3::Y * (wave + layers[layer]),
        ));
    }
}

/// A torus that leaves the ring first and is drawn out into jets.
fn add_rim(
    flights: &mut Vec<Flight>,
    count: usize,
    spacing: f64,
    uneven: &Unevenness,
    random: &mut Random,
) {
    let (out, up) = throw_speeds(0.0);
    for i in 0..count {
        let jet = i % JETS;
        // Half of the rim gathers in the jets: the further out, the closer to the jet's axis.
        let in_jet = i % 2 == 0;
        let along = if in_jet { random.unit() } else { 0.0 };
        let angle = if in_jet {
            let width = 0.25 * TAU / JETS as f64 * (1.0 - along).powi(2);
            uneven.jet_angles[jet] + width * random.range(-1.0, 1.0)
        } else {
            (i as f64 * GOLDEN_ANGLE).rem_euclid(TAU)
        };
        let factor = uneven.speed_factor(angle)
            + 0.10 * uneven.pull(angle)
            + 0.17 * along * uneven.jet_strengths[jet];
        let thickness = random.in_ball() * spacing * (0.9 - 0.5 * along);
        flights.push(Flight {
            origin: outward(angle) * ring_radius(0.0) + DVec3::new(thickness.x, 0.0, thickness.z),
            velocity: (outward(angle) * out + DVec3::Y * (up + thickness.y / STILL_SECS)) * factor,
            launch_secs: 0.0,
            rest_height: 0.0,
        });
    }
}

/// Drops that have left the jets, each a compact cluster that flies as one, and a large one that
/// falls after the first.
fn add_drops(
    flights: &mut Vec<Flight>,
    count: usize,
    spacing: f64,
    uneven: &Unevenness,
    random: &mut Random,
) {
    let large = count / 3;
    // At STILL_SECS 0.95 m above the middle, having fallen for a third of a second.
    let fallen_secs = 1.0 / 3.0;
    let start = DVec3::Y * 0.95 - GRAVITY * (0.5 * fallen_secs * fallen_secs);
    add_drop(
        flights,
        large,
        spacing,
        start,
        DVec3::ZERO,
        STILL_SECS - fallen_secs,
    );

    let (out, up) = throw_speeds(0.0);
    let mut left = count - large;
    let mut drop = 0;
    while left > 0 {
        let jet = drop % JETS;
        let far = 1.0 + (drop / JETS) as f64;
        let u = random.unit();
        let size = ((4.0 + 0.012 * count as f64 * u * u * u) as usize).min(left);
        let angle = uneven.jet_angles[jet] + random.range(-0.04, 0.04) * far;
        let factor =
            1.03 + 0.27 * uneven.jet_strengths[jet] + 0.08 * (far - 1.0) + random.range(0.0, 0.09);
        let velocity = (outward(angle) * out * random.range(0.95, 1.15) + DVec3::Y * up) * factor;
        add_drop(
            flights,
            size,
            spacing,
            outward(angle) * ring_radius(0.0),
            velocity,
            0.0,
        );
        left -= size;
        drop += 1;
    }
}

/// `count` particles in a compact cluster around `center`.
fn add_drop(
    flights: &mut Vec<Flight>,
    count: usize,
    spacing: f64,
    center: DVec3,
    velocity: DVec3,
    launch_secs: f64,
) {
    let reach = (count as f64).cbrt().ceil() as i32 + 1;
    let mut lattice: Vec<(i32, u64, DVec3)> = Vec::new();
    for x in -reach..=reach {
        for y in -reach..=reach {
            for z in -reach..=reach {
                // Face-centred cubic: the rounder of the simple packings. Points at the same distance
                // come in scattered order, so that the last, unfinished shell has no thick side.
                if (x + y + z) % 2 == 0 {
                    let point = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                    let scattered = (lattice.len() as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                    lattice.push((x * x + y * y + z * z, scattered, point));
                }
            }
        }
    }
    lattice.sort_by_key(|&(distance_squared, scattered, _)| (distance_squared, scattered));
    for (_, _, point) in lattice.into_iter().take(count) {
        flights.push(Flight {
            origin: center + point * (spacing * 0.5f64.sqrt()),
            velocity,
            launch_secs,
            rest_height: 0.0,
        });
    }
}

/// `count` particles at `time_secs` after the impact.
pub(super) fn generate(count: usize, seed: u64, time_secs: Option<f64>) -> Generated {
    let mut random = Random::new(seed);
    let (flights, spacing) = flights(count, &mut random);
    let time_secs = time_secs.unwrap_or(STILL_SECS);
    let motions: Vec<Motion> = flights.iter().map(|flight| flight.at(time_secs)).collect();
    let blobs = BlobSettings {
        radius: Some(0.56 * spacing),
        ..BlobSettings::default()
    };
    let bounds = DAabb {
        min: DVec3::new(-0.85, -0.09, -0.68),
        max: DVec3::new(0.85, 1.03, 0.68),
    };
    let scene = Staging {
        blobs,
        bounds,
        towards_eye: DVec3::new(0.25, 0.42, 1.0),
        up: DVec3::Y,
        light: DVec3::new(0.45, 0.75, 0.55),
        preset: "water",
        ground: true,
    }
    .scene();
    Generated {
        particles: ballistic::particles(&motions, (0..count as u32).collect()),
        scene,
    }
}

//! Colour maps: from a number in [0, 1] to a colour.
//!
//! To add a map: one variant of [`ColorMap`], its line in [`ColorMap::ALL`] and in `srgb`.

use super::color::linear_from_srgb;
use serde::{Deserialize, Serialize};

/// A colour map by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorMap {
    /// Blue to green to yellow, perceptually uniform.
    #[default]
    Viridis,
    /// Black to purple to light yellow, perceptually uniform.
    Magma,
    /// Black to red to yellow, perceptually uniform.
    Inferno,
    /// Blue to pink to yellow, perceptually uniform.
    Plasma,
    /// Blue to yellow, the same for all colour vision.
    Cividis,
    /// Rainbow with even lightness steps.
    Turbo,
    /// Black to white, even steps of sRGB.
    Gray,
    /// Blue over light gray to red, for values around a middle (Moreland 2009).
    Coolwarm,
    /// White to blue.
    Blues,
    /// Red over yellow to blue, for values around a middle.
    Spectral,
}

impl ColorMap {
    /// Every map.
    pub const ALL: [Self; 10] = [
        Self::Viridis,
        Self::Magma,
        Self::Inferno,
        Self::Plasma,
        Self::Cividis,
        Self::Turbo,
        Self::Gray,
        Self::Coolwarm,
        Self::Blues,
        Self::Spectral,
    ];

    /// The name in files and flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::Magma => "magma",
            Self::Inferno => "inferno",
            Self::Plasma => "plasma",
            Self::Cividis => "cividis",
            Self::Turbo => "turbo",
            Self::Gray => "gray",
            Self::Coolwarm => "coolwarm",
            Self::Blues => "blues",
            Self::Spectral => "spectral",
        }
    }

    /// The map of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|map| map.name() == name)
    }

    /// The sRGB code at `t` in [0, 1].
    pub fn srgb(self, t: f64) -> [u8; 3] {
        let gradient = match self {
            Self::Viridis => colorous::VIRIDIS,
            Self::Magma => colorous::MAGMA,
            Self::Inferno => colorous::INFERNO,
            Self::Plasma => colorous::PLASMA,
            Self::Cividis => colorous::CIVIDIS,
            Self::Turbo => colorous::TURBO,
            Self::Blues => colorous::BLUES,
            Self::Spectral => colorous::SPECTRAL,
            Self::Gray => return [(t * 255.0).round() as u8; 3],
            Self::Coolwarm => return coolwarm(t).map(|c| (c * 255.0).round() as u8),
        };
        gradient.eval_continuous(t).into_array()
    }

    /// The map as a table of linear colours.
    pub fn table(self) -> ColorTable {
        let last = (ColorTable::ENTRIES - 1) as f64;
        let entry = |i: usize| {
            self.srgb(i as f64 / last)
                .map(|code| linear_from_srgb(f64::from(code) / 255.0) as f32)
        };
        ColorTable {
            entries: (0..ColorTable::ENTRIES).map(entry).collect(),
        }
    }
}

/// A colour map evaluated at even steps: linear Rec. 709, to be read with [`ColorTable::at`].
#[derive(Debug, Clone, PartialEq)]
pub struct ColorTable {
    entries: Vec<[f32; 3]>,
}

impl ColorTable {
    /// Number of entries: the resolution at which the perceptual maps are published.
    pub const ENTRIES: usize = 256;

    /// All entries.
    pub fn entries(&self) -> &[[f32; 3]] {
        &self.entries
    }

    /// The linear colour at `t`, interpolated; below 0 and above 1 the ends, NaN the start.
    pub fn at(&self, t: f32) -> [f32; 3] {
        let last = self.entries.len() - 1;
        let inside = if t > 0.0 { t.min(1.0) } else { 0.0 };
        let position = inside * last as f32;
        let below = (position as usize).min(last - 1);
        let fraction = position - below as f32;
        let [a, b] = [self.entries[below], self.entries[below + 1]];
        std::array::from_fn(|c| a[c] + (b[c] - a[c]) * fraction)
    }
}

/// Moreland's smooth cool-warm map in sRGB: polar CIELAB ("Msh") interpolation between a blue and a
/// red through an unsaturated middle (Moreland, Diverging Color Maps for Scientific Visualization,
/// 2009, §5 and the source listing).
fn coolwarm(t: f64) -> [f64; 3] {
    // Msh of the two ends, sRGB (59, 76, 192) and (180, 4, 38), and their hue after the spin that
    // keeps the change towards the unsaturated middle even.
    const COOL: [f64; 3] = [80.0, 1.08, -1.1];
    const WARM: [f64; 3] = [80.0, 1.08, 0.5];
    const MIDDLE: f64 = 88.0;
    let spin = |[m, s, h]: [f64; 3]| {
        let turn = s * (MIDDLE * MIDDLE - m * m).sqrt() / (m * s.sin());
        if h > -std::f64::consts::FRAC_PI_3 {
            h + turn
        } else {
            h - turn
        }
    };
    let (end, weight) = if t < 0.5 {
        (COOL, 1.0 - 2.0 * t)
    } else {
        (WARM, 2.0 * t - 1.0)
    };
    let m = MIDDLE + (end[0] - MIDDLE) * weight;
    let s = end[1] * weight;
    let middle_hue = spin(end);
    let h = middle_hue + (end[2] - middle_hue) * weight;
    srgb_from_lab([m * s.cos(), m * s.sin() * h.cos(), m * s.sin() * h.sin()])
}

/// Encoded sRGB in [0, 1] of a CIELAB colour under D65.
fn srgb_from_lab([l, a, b]: [f64; 3]) -> [f64; 3] {
    let fy = (l + 16.0) / 116.0;
    let inverse = |f: f64| {
        if f > 6.0 / 29.0 {
            f * f * f
        } else {
            (f - 16.0 / 116.0) / 7.787
        }
    };
    let x = 0.9505 * inverse(fy + a / 500.0);
    let y = inverse(fy);
    let z = 1.089 * inverse(fy - b / 200.0);
    [
        3.2406 * x - 1.5372 * y - 0.4986 * z,
        -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z,
    ]
    .map(|linear: f64| {
        let linear = linear.clamp(0.0, 1.0);
        if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_have_their_published_ends_and_middle() {
        let published = [
            (ColorMap::Viridis, [[68, 1, 84], [253, 231, 37]]),
            (ColorMap::Magma, [[0, 0, 4], [252, 253, 191]]),
            (ColorMap::Inferno, [[0, 0, 4], [252, 255, 164]]),
            (ColorMap::Plasma, [[13, 8, 135], [240, 249, 33]]),
            (ColorMap::Gray, [[0, 0, 0], [255, 255, 255]]),
            (ColorMap::Coolwarm, [[59, 76, 192], [180, 4, 38]]),
        ];
        for (map, [low, high]) in published {
            for (t, code) in [(0.0, low), (1.0, high)] {
                for (ours, theirs) in map.srgb(t).into_iter().zip(code) {
                    let apart = i32::from(ours) - theirs;
                    assert!(apart.abs() <= 1, "{} at {t}: {:?}", map.name(), map.srgb(t));
                }
            }
        }
        assert_eq!(ColorMap::Coolwarm.srgb(0.5), [221, 221, 221]);
    }

    #[test]
    fn names_round_trip() {
        for map in ColorMap::ALL {
            assert_eq!(ColorMap::from_name(map.name()), Some(map));
        }
        assert_eq!(ColorMap::from_name("jet"), None);
    }

    #[test]
    fn tables_interpolate_clamp_and_survive_nan() {
        let table = ColorMap::Viridis.table();
        assert_eq!(table.at(-3.0), table.at(0.0));
        assert_eq!(table.at(f32::INFINITY), table.at(1.0));
        assert_eq!(table.at(f32::NAN), table.at(0.0));
        let [a, b] = [table.at(10.0 / 255.0), table.at(11.0 / 255.0)];
        let middle = table.at(10.5 / 255.0);
        for c in 0..3 {
            assert!((middle[c] - 0.5 * (a[c] + b[c])).abs() < 1e-5);
        }
    }

    #[test]
    fn sequential_maps_brighten_all_the_way() {
        use ColorMap::{Cividis, Gray, Inferno, Magma, Plasma, Viridis};
        for map in [Viridis, Magma, Inferno, Plasma, Cividis, Gray] {
            let table = map.table();
            let luminance = |i: usize| {
                let [r, g, b] = table.at(i as f32 / 63.0);
                0.2126 * r + 0.7152 * g + 0.0722 * b
            };
            for i in 1..64 {
                assert!(luminance(i) > luminance(i - 1), "{} at {i}/63", map.name());
            }
        }
    }
}

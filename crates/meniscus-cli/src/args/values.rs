//! Words of the command line that are more than one number.

use std::fmt;
use std::str::FromStr;

fn numbers<const N: usize>(text: &str, what: &str) -> Result<[f64; N], String> {
    let parts: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse::<f64>())
        .collect::<Result<_, _>>()
        .map_err(|_| format!("expected {what}"))?;
    let found = parts.len();
    let numbers: [f64; N] = parts
        .try_into()
        .map_err(|_| format!("expected {what}, found {found} numbers"))?;
    if numbers.iter().all(|number| number.is_finite()) {
        Ok(numbers)
    } else {
        Err(format!("expected {what}, all finite"))
    }
}

/// `x,y,z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Triple(pub [f64; 3]);

impl FromStr for Triple {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        numbers(text, "three numbers x,y,z").map(Self)
    }
}

/// `a,b` with a < b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ValueRange(pub [f64; 2]);

impl FromStr for ValueRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let range = numbers(text, "two numbers low,high")?;
        if range[0] < range[1] {
            Ok(Self(range))
        } else {
            Err("the first number must be the smaller one".to_owned())
        }
    }
}

/// `WIDTHxHEIGHT` in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Size(pub [u32; 2]);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected WIDTHxHEIGHT, as in 1280x720".to_owned();
        let (width, height) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
        let side = |text: &str| text.trim().parse::<u32>().map_err(|_| wrong());
        Ok(Self([side(width)?, side(height)?]))
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.0[0], self.0[1])
    }
}

/// `x,y,width,height` in pixels, from the top left corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct RegionArg(pub [u32; 4]);

impl FromStr for RegionArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected x,y,width,height in pixels from the top left corner".to_owned();
        let parts: Vec<u32> = text
            .split(',')
            .map(|part| part.trim().parse().map_err(|_| wrong()))
            .collect::<Result<_, _>>()?;
        parts.try_into().map(Self).map_err(|_| wrong())
    }
}

/// `a-b`: samples a to b of each pixel, counted from 0, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SampleRange {
    /// First sample.
    pub first: u32,
    /// Last sample.
    pub last: u32,
}

impl FromStr for SampleRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected a-b, as in 0-7 (samples count from 0)".to_owned();
        let (first, last) = text.split_once('-').ok_or_else(wrong)?;
        let number = |text: &str| text.trim().parse::<u32>().map_err(|_| wrong());
        let range = Self {
            first: number(first)?,
            last: number(last)?,
        };
        if range.first > range.last {
            return Err("the first sample comes after the last".to_owned());
        }
        Ok(range)
    }
}

/// `key.path=value` of a scene file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Setting {
    /// Dotted path, such as `surface.0.threshold`.
    pub path: String,
    /// The value as written.
    pub value: String,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((path, value)) if !path.trim().is_empty() => Ok(Self {
                path: path.trim().to_owned(),
                value: value.trim().to_owned(),
            }),
            _ => Err("expected key.path=value, as in surface.0.threshold=0.5".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_and_wrong_ones_refused() {
        assert_eq!("-1, 2,3e-1".parse(), Ok(Triple([-1.0, 2.0, 0.3])));
        for wrong in ["1,2", "1,2,3,4", "a,b,c", "1,2,inf", ""] {
            assert!(wrong.parse::<Triple>().is_err(), "{wrong}");
        }
        assert_eq!("-1,1".parse(), Ok(ValueRange([-1.0, 1.0])));
        for wrong in ["1,1", "2,1", "1", "nan,1"] {
            assert!(wrong.parse::<ValueRange>().is_err(), "{wrong}");
        }
        assert_eq!("640x480".parse(), Ok(Size([640, 480])));
        for wrong in ["640", "640x-1", "x", "1e3x1", "99999999999x1"] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong}");
        }
        assert_eq!("1,2,3,4".parse(), Ok(RegionArg([1, 2, 3, 4])));
        assert!("1,2,3".parse::<RegionArg>().is_err());
        assert_eq!("0-7".parse(), Ok(SampleRange { first: 0, last: 7 }));
        for wrong in ["7", "3-1", "-3", "a-b"] {
            assert!(wrong.parse::<SampleRange>().is_err(), "{wrong}");
        }
        let setting: Setting = "a.b = x=1".parse().unwrap();
        assert_eq!((&*setting.path, &*setting.value), ("a.b", "x=1"));
        assert!("=1".parse::<Setting>().is_err());
    }
}

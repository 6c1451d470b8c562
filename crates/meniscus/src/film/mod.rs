//! The film: named channels, tone curve, image files.
//!
//! A backend renders (pixel rectangle, sample range) into a [`Film`] over that rectangle and
//! [`Film::merge`] puts films together. Colour, coverage and albedo are sums of fixed-point
//! integers, which no order of addition can change; geometry comes from the sample nearest the pixel
//! centre. So a picture is the same bit for bit however its tiles and sample ranges were dealt out.

mod aside;
mod channel;
mod cues;
mod denoise;
mod error;
mod exr;
mod image;
mod legend;
mod picture;
mod region;
mod tone;
mod white;

pub use aside::write_aside;
pub use channel::{
    AovStyle, AttributeInfo, CHANNELS, CURVATURE, ChannelError, ChannelInfo, ChannelSet, MOTION,
    NO_INDEX, PixelSample, Plane, Source, Storage, SurfaceSample,
};
pub use error::FilmError;
pub use image::{BitDepth, Image, Pixels};
pub use legend::Legend;
pub use picture::{Film, PlaneData};
pub use region::Region;
pub use tone::{Curve, Tone, filmic, srgb_from_linear};
pub use white::WhitePoint;

//! The film: named channels, pixel filter, tone curve, image files.

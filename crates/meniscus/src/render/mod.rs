//! Rendering: a backend that turns (pixel rectangle, sample range) of a frame into film.

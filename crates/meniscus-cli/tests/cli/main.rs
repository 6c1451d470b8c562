//! The program as its users run it.

mod bad_input;
mod bench;
mod company;
mod denoise;
mod exact;
mod film;
mod generate;
mod gpu;
mod info;
mod interrupt;
mod motion;
mod options;
mod render;
mod run;
mod sequence;
mod shapes;
mod trace;

//! Filter expressions and selections of frames.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meniscus::particles::filter::Filter;
use meniscus::particles::sequence::FrameSelection;
use meniscus::particles::{Column, Particles};

fuzz_target!(|text: &str| {
    if let Ok(filter) = Filter::parse(text) {
        let mut particles = Particles::from_positions(vec![[0.0, 1.0, -2.0].into(); 3]);
        particles.columns = vec![
            Column::new("v", 3, vec![0.5_f32; 9]),
            Column::new("id", 1, vec![1_i32, 2, 3]),
        ];
        if let Ok(keep) = filter.keep(&particles) {
            assert_eq!(keep.len(), 3);
        }
    }
    if let Ok(selection) = text.parse::<FrameSelection>() {
        let again: FrameSelection = selection
            .to_string()
            .parse()
            .expect("what it prints it reads");
        assert_eq!(again.contains(7), selection.contains(7));
    }
});

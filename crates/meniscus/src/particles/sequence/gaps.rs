//! Frames that are missing in the middle of a sequence.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// By how much frame numbers usually rise: the most frequent distance of neighbours, the smallest
/// among equals; 1 where there are fewer than two numbers. `numbers` rise.
pub fn usual_step(numbers: &[u64]) -> u64 {
    let mut counts = BTreeMap::new();
    for pair in numbers.windows(2) {
        let distance = pair[1].saturating_sub(pair[0]);
        if distance > 0 {
            *counts.entry(distance).or_insert(0_usize) += 1;
        }
    }
    let most = counts.values().max().copied();
    counts
        .into_iter()
        .find(|(_, count)| Some(*count) == most)
        .map_or(1, |(distance, _)| distance)
}

/// The numbers missing between neighbours of `numbers`, which rise by `step` where none is missing.
/// Distances that are no multiple of the step are no gaps.
pub fn gaps(numbers: &[u64], step: u64) -> Vec<RangeInclusive<u64>> {
    let step = step.max(1);
    numbers
        .windows(2)
        .filter(|pair| pair[1] > pair[0])
        .filter(|pair| {
            let distance = pair[1] - pair[0];
            distance > step && distance.is_multiple_of(step)
        })
        .map(|pair| pair[0] + step..=pair[1] - step)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_numbers_are_found_whatever_the_step() {
        assert_eq!(usual_step(&[]), 1);
        assert_eq!(usual_step(&[7]), 1);
        let numbers = [1, 2, 4, 5, 9];
        assert_eq!(usual_step(&numbers), 1);
        assert_eq!(gaps(&numbers, 1), [3..=3, 6..=8]);
        let numbers = [0, 10, 20, 40, 50, 50, 55];
        assert_eq!(usual_step(&numbers), 10);
        assert_eq!(gaps(&numbers, 10), [30..=30]);
        assert_eq!(usual_step(&[1, 2, 4]), 1);
        assert!(gaps(&[2, 4, 6], 2).is_empty());
        assert_eq!(gaps(&[0, u64::MAX], 1), [1..=u64::MAX - 1]);
    }
}

//! Sums of parts that threads compute, added in the order of the parts: the same digits whichever thread is faster.

use rayon::prelude::*;
use std::ops::Range;

/// Returns the sum of `parts`, in their order, from `zero` on.
pub fn in_order<T: Send>(
    parts: impl IndexedParallelIterator<Item = T>,
    zero: T,
    add: impl Fn(T, T) -> T,
) -> T {
    parts.collect::<Vec<T>>().into_iter().fold(zero, add)
}

/// Returns the sum of `part` over all numbers of a `range`, by groups of neighbours: few intermediate sums, always the same ones. `part` adds its number to a sum.
pub fn of_range<T: Send>(
    range: Range<usize>,
    zero: impl Fn() -> T + Sync,
    part: impl Fn(T, usize) -> T + Sync,
    add: impl Fn(T, T) -> T,
) -> T {
    /// Numbers of a group.
    const GROUP: usize = 64;
    let groups = (0..range.len().div_ceil(GROUP)).into_par_iter().map(|group| {
        let first = range.start + group * GROUP;
        (first..(first + GROUP).min(range.end)).fold(zero(), &part)
    });
    in_order(groups, zero(), add)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_have_the_same_digits_with_any_number_of_threads() {
        let value =
            |i: usize| (i as f64 * 0.618_034).fract().powi(7) * if i.is_multiple_of(3) { -1.0 } else { 1.0 };
        let sums = || {
            let one = in_order((0..10_000).into_par_iter().map(value), 0.0, |a, b| a + b);
            [one, of_range(5..10_000, || 0.0, |sum, i| sum + value(i), |a, b| a + b)]
        };
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(sums)
        };
        let expected: f64 = (0..10_000).map(value).sum();
        for threads in 1..6 {
            assert_eq!(with(threads), with(1));
            assert_eq!(with(threads)[0], expected);
        }
        assert_eq!(of_range(3..3, || 1.0, |sum, _| sum, |a, b| a * b), 1.0, "nothing");
    }
}

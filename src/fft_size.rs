//! Sizes at which Fourier transforms are fast: rustfft has vector code for the factors 2, 3 and 5.

/// Returns the smallest size from `n` up with no prime factor above 5.
pub fn fast_size(n: usize) -> usize {
    (n.max(1)..).find(|&m| is_fast(m)).unwrap_or(n)
}

/// Returns true if `n` ≥ 1 has no prime factor above 5.
pub fn is_fast(n: usize) -> bool {
    let divided = |mut rest: usize, prime: &usize| {
        while rest > 0 && rest.is_multiple_of(*prime) {
            rest /= prime;
        }
        rest
    };
    [2, 3, 5].iter().fold(n, divided) == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fast_sizes_have_small_factors() {
        assert_eq!([0, 1, 7, 11, 121, 3999].map(fast_size), [1, 1, 8, 12, 125, 4000]);
        assert!(!is_fast(0) && !is_fast(29 * 128));
    }
}

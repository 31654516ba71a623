//! Lengths that transforms are cheap at.

/// The cheapest length that is not below `n`: 2^a·3^b, or with 5s where that saves a seventh.
///
/// A power of five costs about twice a power of two or three (measured at 250³ against 256³), primes four times.
///
/// ```
/// use amcheck::convolution::good_size;
/// assert_eq!([1, 5, 17, 250, 257, 513].map(good_size), [1, 5, 18, 256, 288, 576]);
/// ```
pub fn good_size(n: usize) -> usize {
    let plain = smooth_at_least(n, &[2, 3]);
    let with_five = smooth_at_least(n, &[2, 3, 5]);
    if with_five * 8 <= plain * 7 { with_five } else { plain }
}

/// As [`good_size`] and even, as the first axis of a real transform wants it.
pub fn good_even_size(n: usize) -> usize {
    let mut size = good_size(n.max(2));
    while !size.is_multiple_of(2) {
        size = good_size(size + 1);
    }
    size
}

fn smooth_at_least(n: usize, primes: &[usize]) -> usize {
    (n.max(1)..)
        .find(|&candidate| {
            let mut rest = candidate;
            primes.iter().for_each(|&p| {
                while rest.is_multiple_of(p) {
                    rest /= p;
                }
            });
            rest == 1
        })
        .unwrap_or(n)
}

//! SHA-256 (FIPS 180-4), by which a page names the script and the styles that a browser may run.

/// Bytes of a block.
const BLOCK: usize = 64;

/// Returns the first 32 bits of the fraction of `root`.
fn fraction(root: f64) -> u32 {
    (root.fract() * 2f64.powi(32)) as u32
}

/// Returns the first 64 prime numbers.
fn primes() -> [u32; 64] {
    let mut all = (2u32..).filter(|n| (2..*n).all(|d| n % d != 0));
    std::array::from_fn(|_| all.next().unwrap_or_default())
}

/// Returns the sum of `bytes`.
pub fn sha256(bytes: &[u8]) -> [u8; 32] {
    let primes = primes();
    // 5.3.3 and 4.2.2: fractions of square roots and of cubic roots. Both have 32 correct bits in 64-bit floats.
    let mut state: [u32; 8] = std::array::from_fn(|i| fraction(f64::from(primes[i]).sqrt()));
    let constants = primes.map(|prime| fraction(f64::from(prime).cbrt()));
    // 5.1.1: a one, zeros, and the number of bits.
    let mut padded = bytes.to_vec();
    padded.push(0x80);
    padded.resize((padded.len() + 8).next_multiple_of(BLOCK) - 8, 0);
    padded.extend((8 * bytes.len() as u64).to_be_bytes());
    for block in padded.as_chunks::<BLOCK>().0 {
        compress(&mut state, block, &constants);
    }
    bytemuck::cast(state.map(u32::to_be_bytes))
}

/// Adds a block to the state (6.2.2).
fn compress(state: &mut [u32; 8], block: &[u8; BLOCK], constants: &[u32; 64]) {
    let mut words = [0u32; 64];
    for (word, bytes) in words.iter_mut().zip(block.as_chunks::<4>().0) {
        *word = u32::from_be_bytes(*bytes);
    }
    let turned = |x: u32, by: [u32; 3]| x.rotate_right(by[0]) ^ x.rotate_right(by[1]) ^ x.rotate_right(by[2]);
    for t in 16..64 {
        let (x, y) = (words[t - 15], words[t - 2]);
        let early = x.rotate_right(7) ^ x.rotate_right(18) ^ (x >> 3);
        let late = y.rotate_right(17) ^ y.rotate_right(19) ^ (y >> 10);
        words[t] = words[t - 16].wrapping_add(early).wrapping_add(words[t - 7]).wrapping_add(late);
    }
    let [mut a, mut b, mut c, mut d, mut e, mut f, mut g, mut h] = *state;
    for (constant, word) in constants.iter().zip(words) {
        let chosen = (e & f) ^ (!e & g);
        let first = h.wrapping_add(turned(e, [6, 11, 25])).wrapping_add(chosen);
        let first = first.wrapping_add(*constant).wrapping_add(word);
        let majority = (a & b) ^ (a & c) ^ (b & c);
        let second = turned(a, [2, 13, 22]).wrapping_add(majority);
        (h, g, f, e) = (g, f, e, d.wrapping_add(first));
        (d, c, b, a) = (c, b, a, first.wrapping_add(second));
    }
    for (sum, letter) in state.iter_mut().zip([a, b, c, d, e, f, g, h]) {
        *sum = sum.wrapping_add(letter);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_standard() {
        let hex = |text: &str| sha256(text.as_bytes()).map(|byte| format!("{byte:02x}")).concat();
        // The examples of NIST for one block, for two, and the sum of nothing.
        assert_eq!(hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        assert_eq!(
            hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"
        );
        assert_eq!(hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    }
}

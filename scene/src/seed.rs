//! Randomness by key, never by order.
//!
//! Every object of a scene has a path (`city/block/17/house/3`). Its random stream is `ChaCha8` keyed by the hash of that
//! path, so drawing more numbers for a tree cannot move a house. Words become floats, ranges and permutations by the few
//! lines below and not by a library's, whose values may change between minor versions.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng};

/// The key of one object's randomness: a 256-bit hash of the scene's seed and the object's path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SeedPath {
    key: [u8; 32],
}

impl SeedPath {
    /// The root of everything that one seed decides. `domain` separates uses that must not be correlated.
    pub fn root(domain: &str, seed: u64) -> Self {
        let mut hasher = blake3::Hasher::new_derive_key("satseed 2026 seed path v1");
        hasher.update(&seed.to_le_bytes());
        hasher.update(domain.as_bytes());
        Self { key: *hasher.finalize().as_bytes() }
    }

    /// The path one name further down.
    #[must_use]
    pub fn child(&self, name: &str) -> Self {
        self.extend(b'n', name.as_bytes())
    }

    /// The path one index further down. `index(3)` and `child("3")` differ.
    #[must_use]
    pub fn index(&self, index: u64) -> Self {
        self.extend(b'i', &index.to_le_bytes())
    }

    fn extend(&self, kind: u8, bytes: &[u8]) -> Self {
        let mut hasher = blake3::Hasher::new_keyed(&self.key);
        hasher.update(&[kind]);
        hasher.update(bytes);
        Self { key: *hasher.finalize().as_bytes() }
    }

    /// The random stream of this path, from its beginning.
    pub fn rng(&self) -> Rng {
        Rng { chacha: ChaCha8Rng::from_seed(self.key) }
    }

    /// 64 bits of the key: a seed for hashed noise.
    pub fn hash_u64(&self) -> u64 {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(&self.key[..8]);
        u64::from_le_bytes(bytes)
    }

    /// 32 bits of the key: a seed for hashed noise.
    pub fn hash_u32(&self) -> u32 {
        self.hash_u64() as u32
    }
}

/// The random stream of one [`SeedPath`].
pub struct Rng {
    chacha: ChaCha8Rng,
}

impl Rng {
    /// 64 uniform bits.
    pub fn next_u64(&mut self) -> u64 {
        self.chacha.next_u64()
    }

    /// Uniform in [0, 1), on the lattice of 2^-53.
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Uniform in [from, to).
    pub fn range(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Uniform in -1..1.
    pub fn signed(&mut self) -> f64 {
        self.range(-1.0, 1.0)
    }

    /// True with probability `p`.
    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// Uniform in 0..n without bias (Lemire 2019, multiply and reject). `n` must not be 0.
    pub fn below(&mut self, n: u64) -> u64 {
        assert!(n > 0, "a draw from an empty range");
        let threshold = n.wrapping_neg() % n;
        loop {
            let wide = u128::from(self.next_u64()) * u128::from(n);
            if wide as u64 >= threshold {
                return (wide >> 64) as u64;
            }
        }
    }

    /// A uniformly drawn element. The slice must not be empty.
    pub fn pick<'a, T>(&mut self, items: &'a [T]) -> &'a T {
        &items[self.below(items.len() as u64) as usize]
    }

    /// An index drawn with the given weights (not negative, not all zero).
    pub fn weighted(&mut self, weights: &[f64]) -> usize {
        let total: f64 = weights.iter().sum();
        let mut left = self.unit() * total;
        for (i, w) in weights.iter().enumerate() {
            left -= w;
            if left < 0.0 {
                return i;
            }
        }
        weights.iter().rposition(|w| *w > 0.0).unwrap_or(0)
    }

    /// Fisher-Yates, from the end.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i as u64 + 1) as usize);
        }
    }

    /// Standard normal (Box-Muller, one of the pair).
    pub fn normal(&mut self) -> f64 {
        let u = 1.0 - self.unit();
        let v = self.unit();
        (-2.0 * libm::log(u)).sqrt() * libm::cos(core::f64::consts::TAU * v)
    }

    /// Lognormal by its median and the standard deviation of its logarithm.
    pub fn lognormal(&mut self, median: f64, sigma_log: f64) -> f64 {
        median * libm::exp(sigma_log * self.normal())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_vectors() {
        let root = SeedPath::root("test", 42);
        let mut rng = root.child("tree").index(7).rng();
        let words: Vec<u64> = (0..3).map(|_| rng.next_u64()).collect();
        assert_eq!(words, GOLDEN_WORDS);
        let mut rng = root.rng();
        assert_eq!(rng.unit().to_bits(), GOLDEN_UNIT);
        assert_eq!(rng.below(1000), GOLDEN_BELOW);
        assert_eq!(rng.normal().to_bits(), GOLDEN_NORMAL);
        let mut order: Vec<u32> = (0..8).collect();
        rng.shuffle(&mut order);
        assert_eq!(order, GOLDEN_ORDER);
    }

    const GOLDEN_WORDS: [u64; 3] = [11_021_619_687_728_765_229, 14_063_674_305_849_695_475, 9_133_903_188_481_918_050];
    const GOLDEN_UNIT: u64 = 4_603_289_489_603_515_215;
    const GOLDEN_BELOW: u64 = 147;
    const GOLDEN_NORMAL: u64 = 4_608_386_194_028_300_821;
    const GOLDEN_ORDER: [u32; 8] = [5, 7, 4, 2, 0, 6, 1, 3];

    #[test]
    fn paths_do_not_collide() {
        let root = SeedPath::root("test", 1);
        assert_ne!(root.child("3"), root.index(3));
        assert_ne!(root.child("ab").child("c"), root.child("a").child("bc"));
        assert_ne!(SeedPath::root("a", 1), SeedPath::root("b", 1));
        assert_ne!(SeedPath::root("a", 1), SeedPath::root("a", 2));
    }

    #[test]
    fn draws_are_fair() {
        let mut rng = SeedPath::root("fair", 3).rng();
        let mut counts = [0_u32; 7];
        for _ in 0..70_000 {
            counts[rng.below(7) as usize] += 1;
        }
        // Six sigma of a binomial with n = 70,000, p = 1/7 is 556.
        assert!(counts.iter().all(|c| c.abs_diff(10_000) < 556), "{counts:?}");
        let (mut sum, mut square) = (0.0, 0.0);
        for _ in 0..100_000 {
            let x = rng.normal();
            sum += x;
            square += x * x;
        }
        assert!((sum / 1e5).abs() < 0.02 && (square / 1e5 - 1.0).abs() < 0.03);
    }
}

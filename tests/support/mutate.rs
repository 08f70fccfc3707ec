//! Changed files: what a stranger, a bad disk or a slip of the hand makes of sound ones.

use satseed_scene::Rng;

/// Changes bytes in one to four places: a byte, a bit, a part taken out or doubled, lines turned round, one of `words` put in.
pub(crate) fn mutate(bytes: &mut Vec<u8>, words: &[&str], rng: &mut Rng) {
    for _ in 0..=rng.below(4) {
        let at = rng.below(bytes.len() as u64 + 1) as usize;
        let end = (at + 1 + rng.below(24) as usize).min(bytes.len());
        match rng.below(6) {
            0 if at < bytes.len() => bytes[at] = rng.below(256) as u8,
            1 if at < bytes.len() => bytes[at] ^= 1 << rng.below(8),
            2 => drop(bytes.drain(at..end)),
            3 => {
                let copy = bytes[at..end].to_vec();
                let to = rng.below(bytes.len() as u64 + 1) as usize;
                drop(bytes.splice(to..to, copy));
            }
            4 => {
                let line_ends: Vec<_> = (0..bytes.len()).filter(|i| bytes[*i] == b'\n').collect();
                if let [first, .., last] = line_ends[..] {
                    bytes.rotate_left(if rng.chance(0.5) { first + 1 } else { last + 1 });
                }
            }
            _ => drop(bytes.splice(at..at, rng.pick(words).bytes())),
        }
    }
}

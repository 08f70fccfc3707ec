//! The last line of a page that follows from a dataset: of which dataset it tells, and that it is whole.

/// What a page's last line says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seal {
    /// The root hash of the dataset that the page shows.
    pub root_hash: String,
}

const START: &[u8] = b"<!-- of ";
const BETWEEN: &str = ", all above has BLAKE3 ";
const END: &str = " -->\n";

impl Seal {
    /// A page with its last line.
    pub fn put(mut page: Vec<u8>, root_hash: &str) -> Vec<u8> {
        let hash = blake3::hash(&page).to_hex();
        page.extend(START);
        page.extend(format!("{root_hash}{BETWEEN}{hash}{END}").bytes());
        page
    }

    /// The seal of a page; none where it has none, or is not what it was when it was sealed.
    pub fn of(page: &[u8]) -> Option<Self> {
        const LENGTH: usize = START.len() + 64 + BETWEEN.len() + 64 + END.len();
        let (above, line) = page.split_at_checked(page.len().checked_sub(LENGTH)?)?;
        let line = std::str::from_utf8(line.strip_prefix(START)?).ok()?;
        let (root_hash, hash) = line.strip_suffix(END)?.split_once(BETWEEN)?;
        (blake3::hash(above).to_hex().as_str() == hash).then(|| Self { root_hash: root_hash.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_breaks_it() {
        let root_hash = "ab".repeat(32);
        let page = Seal::put(b"<p>page</p>\n".to_vec(), &root_hash);
        assert_eq!(Seal::of(&page), Some(Seal { root_hash }));
        for i in 0..page.len() {
            let mut changed = page.clone();
            changed[i] ^= 1;
            // The dataset that it names is not under its own hash; whoever reads it compares that one.
            let other = Seal::of(&changed).is_none_or(|seal| seal.root_hash != "ab".repeat(32));
            assert!(other, "byte {i}");
            assert_eq!(Seal::of(&page[..i]), None);
        }
        assert_eq!(Seal::of(b""), None);
    }
}

//! What a dataset tells of itself: a card for people (`README.md`) and Croissant metadata for programs.
//!
//! Both follow from the dataset and the program's lock file alone, byte for byte.

mod croissant;
mod text;

use crate::dataset::{
    CARD, CROISSANT, Dataset, ReadError, Seal, Store, StoreError, Summary, WriteError, put_same, summarise,
};

/// Why there is no card.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CardError {
    /// The dataset cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A file cannot be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Another one stands there.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// What both pages tell.
struct Facts {
    summary: Summary,
    /// Of the resolved recipe: the lines `# satseed VERSION` and `# plan HASH`.
    program: String,
    plan: String,
    recipe_blake3: String,
    /// Of the lock file that this program was built with: every library by version and hash.
    lock_blake3: String,
}

/// Writes a finished dataset's card and its Croissant metadata, where they are not there and whole, on the current rayon
/// pool. The caller holds the folder's lock.
///
/// # Errors
/// Where the dataset cannot be read or the store fails.
pub fn ensure_card(store: &dyn Store) -> Result<(), CardError> {
    let dataset = Dataset::open(store)?;
    let standing = |path: &str| match store.get(path) {
        Ok(content) => Ok(Some(content)),
        Err(StoreError::NotFound { .. }) => Ok(None),
        Err(other) => Err(other),
    };
    let (card, croissant) = (standing(CARD)?, standing(CROISSANT)?);
    if let (Some(card), Some(croissant)) = (&card, &croissant) {
        let whole = Seal::of(card).is_some_and(|seal| seal.root_hash == dataset.root_hash().hex());
        if whole && String::from_utf8_lossy(card).contains(blake3::hash(croissant).to_hex().as_str()) {
            return Ok(());
        }
    }
    let facts = Facts::of(&dataset)?;
    let new_croissant = croissant::text(&facts, &store.get(crate::dataset::MANIFEST)?);
    let new_card = text::card(&facts, dataset.records(), &blake3::hash(new_croissant.as_bytes()).to_hex());
    let sealed = Seal::put(new_card.into_bytes(), &facts.summary.root_hash);
    for (path, old, new) in [(CROISSANT, croissant, new_croissant.into_bytes()), (CARD, card, sealed)] {
        if old.is_some_and(|old| old != new) {
            store.discard(path)?;
        }
        // Another machine may have finished the same dataset meanwhile.
        put_same(store, path, &new)?;
    }
    Ok(())
}

impl Facts {
    fn of(dataset: &Dataset<'_>) -> Result<Self, ReadError> {
        let recipe = dataset.records().first().map(|r| dataset.text(r, "recipe")).transpose()?.unwrap_or_default();
        let line = |start: &str| {
            let found = recipe.lines().find_map(|l| l.strip_prefix(start));
            found.unwrap_or("unknown").to_owned()
        };
        Ok(Self {
            summary: summarise(dataset)?,
            program: format!("satseed {}", line("# satseed ")),
            plan: line("# plan "),
            recipe_blake3: blake3::hash(recipe.as_bytes()).to_hex().to_string(),
            lock_blake3: blake3::hash(include_bytes!("../../Cargo.lock")).to_hex().to_string(),
        })
    }
}

//! What `verify` found, in words and for programs.

use serde::Serialize;

/// What is wrong with a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fault {
    /// It should be there.
    Missing,
    /// It should not be there.
    Extra,
    /// It is shorter than recorded.
    Truncated,
    /// Its content is not what was recorded.
    Changed,
    /// It holds what another file of the dataset should hold.
    Swapped,
    /// Its content is as recorded, but contradicts itself or another file.
    Contradiction,
    /// It differs from what its seed makes.
    NotReproduced,
}

impl Fault {
    /// Its word in reports.
    pub fn word(self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::Extra => "extra",
            Self::Truncated => "truncated",
            Self::Changed => "changed",
            Self::Swapped => "swapped",
            Self::Contradiction => "contradiction",
            Self::NotReproduced => "not-reproduced",
        }
    }
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Finding {
    /// Which file.
    pub path: String,
    /// What is wrong with it.
    pub fault: Fault,
    /// In words.
    pub detail: String,
}

impl Finding {
    pub(in crate::dataset) fn new(path: impl Into<String>, fault: Fault, detail: impl Into<String>) -> Self {
        Self { path: path.into(), fault, detail: detail.into() }
    }
}

/// What `verify` found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Report {
    /// Hash of the manifest that the dataset was held against; none where it has none yet.
    pub root_hash: Option<String>,
    /// Samples that were looked at.
    pub samples: usize,
    /// Samples that the plan has and the dataset has not yet.
    pub samples_to_make: usize,
    /// Files that were read.
    pub files: usize,
    /// Their bytes.
    pub bytes: u64,
    /// Everything that is wrong, by path.
    pub findings: Vec<Finding>,
    /// What should be known but is no fault.
    pub notes: Vec<String>,
}

impl Report {
    /// Whether nothing is wrong.
    pub fn is_fine(&self) -> bool {
        self.findings.is_empty()
    }

    /// Adds what a further check found.
    pub fn add(&mut self, findings: Vec<Finding>) {
        self.findings.extend(findings);
        self.findings.sort();
        self.findings.dedup();
    }
}

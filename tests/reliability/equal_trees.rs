//! The same tree whatever the shards, threads and surroundings.

use super::bench::{Bench, assert_same, succeeds, text, tree};
use std::path::Path;

#[test]
fn runs_shards_threads_and_surroundings_give_equal_trees() {
    let bench = Bench::new();
    let expected = bench.undisturbed(&[]);
    let out = bench.out("elsewhere");
    let mut other = bench.generate(&out, &["--jobs", "3"]);
    other.current_dir("/").env("LC_ALL", "tr_TR.UTF-8").env("TZ", "Asia/Kathmandu").env("TMPDIR", "/nowhere");
    let printed = succeeds(&mut other).stdout;
    assert_same(&tree(&out), &expected, "elsewhere");
    let root = &expected[Path::new("manifest.blake3")];
    assert_eq!(text(&printed).trim(), &text(root)[..64]);

    let shards = bench.out("shards");
    for shard in ["2/3", "3/3", "2/3", "1/3"] {
        succeeds(&mut bench.generate(&shards, &["--shard", shard, "--jobs", "1"]));
    }
    assert!(!shards.join("manifest.jsonl").exists(), "only merge joins");
    assert_eq!(succeeds(&mut bench.merge(&shards, &[])).stdout, printed);
    assert_same(&tree(&shards), &expected, "three shards in one folder");
}

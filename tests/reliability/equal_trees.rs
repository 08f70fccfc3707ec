//! The same tree whatever the shards, threads and surroundings.

use super::bench::{Bench, Tree, assert_same, succeeds, text, tree};
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
    assert_same(&tree(&shards), &expected, "three shards in one folder");
    // Shards on machines of their own: the union of their files, without what the last one derives.
    let mut union = Tree::new();
    for shard in ["1/3", "2/3", "3/3"] {
        let own = bench.out(&format!("own-{}", &shard[..1]));
        succeeds(&mut bench.generate(&own, &["--shard", shard]));
        for (path, content) in tree(&own) {
            let other = union.insert(path.clone(), content.clone());
            assert!(other.is_none_or(|o| o == content), "{} differs between shards", path.display());
        }
    }
    let derived = |p: &Path| {
        p.ends_with("part.jsonl")
            || ["manifest.jsonl", "manifest.blake3", "gallery.html", "README.md", "croissant.json"]
                .iter()
                .any(|file| p.starts_with(file))
    };
    union.retain(|p, _| !derived(p));
    let samples: Tree = expected.into_iter().filter(|(p, _)| !derived(p)).collect();
    assert_same(&union, &samples, "the shards' union");
}

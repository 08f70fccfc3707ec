//! Kills, signals, and a second process on the same folder.

use super::bench::{
    Bench, Draws, SLOW, assert_same, in_a_sample, stderr_of, succeeds, text, tree, tree_has_a_record, wait_for_a_sample,
};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// How many samples were begun.
fn begun(out: &Path) -> usize {
    let folders = |path: &Path| -> Vec<PathBuf> {
        let all = fs::read_dir(path).into_iter().flatten().flatten().map(|e| e.path());
        all.filter(|p| p.is_dir()).collect()
    };
    folders(out).iter().map(|scene| folders(scene).len()).sum()
}

/// How many samples are recorded.
fn records(out: &Path) -> usize {
    tree(out).keys().filter(|path| path.ends_with("sample.json")).count()
}

/// Kills a run at random moments again and again until it is complete, until `kills` kills are done. Every third kill
/// comes at a random moment of the whole run, the others at a random moment of the time that a sample takes to write,
/// since a scene takes longer to build than its samples to write.
fn kill_and_resume(kills: usize) {
    let bench = Bench::new();
    let out = bench.out("undisturbed");
    let started = Instant::now();
    let mut child = bench.generate(&out, &[]).spawn().unwrap();
    while begun(&out) == 0 && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_micros(200));
    }
    let first = Instant::now();
    while !tree_has_a_record(&out) && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_micros(200));
    }
    let one_sample = first.elapsed();
    assert!(child.wait().unwrap().success());
    let whole = started.elapsed();
    let expected = tree(&out);
    let (mut done, mut in_samples, mut rounds) = (0, 0, 0);
    let mut draws = Draws(7);
    // On a slow machine a kill comes late and misses its sample, so it goes on until half of the kills have met one.
    let enough = |done: usize, in_samples: usize| done >= kills && 2 * in_samples >= kills;
    while !enough(done, in_samples) {
        assert!(done < 4 * kills, "only {in_samples} of {done} kills met a sample's writes");
        let out = bench.out(&format!("killed-{rounds}"));
        rounds += 1;
        loop {
            let before = begun(&out);
            let mut child = bench.generate(&out, &[]).spawn().unwrap();
            if done % 3 == 0 {
                std::thread::sleep(whole.mul_f64(draws.unit()));
            } else {
                while begun(&out) == before && child.try_wait().unwrap().is_none() {
                    std::thread::sleep(Duration::from_micros(200));
                }
                std::thread::sleep(one_sample.mul_f64(draws.unit()));
            }
            // SIGKILL; an error means that it has ended by itself.
            child.kill().unwrap();
            let status = child.wait().unwrap();
            if status.success() {
                break;
            }
            assert_eq!(status.code(), None, "killed, not failed: {}", stderr_of(&mut child));
            done += 1;
            in_samples += usize::from(in_a_sample(&out));
            if enough(done, in_samples) {
                succeeds(&mut bench.generate(&out, &[]));
                break;
            }
        }
        assert_same(&tree(&out), &expected, &format!("after {done} kills"));
        fs::remove_dir_all(&out).unwrap();
    }
    eprintln!("{done} kills in {rounds} runs, {in_samples} of them in the middle of a sample");
}

#[test]
fn kills_lose_nothing() {
    kill_and_resume(12);
}

#[test]
#[ignore = "long: 200 kills"]
fn two_hundred_kills_lose_nothing() {
    kill_and_resume(200);
}

#[test]
fn signals_stop_at_a_samples_border() {
    let bench = Bench::new();
    let out = bench.out("stopped");
    for (round, signal) in ["-TERM", "-INT"].into_iter().enumerate() {
        let mut child = bench.generate(&out, &SLOW).spawn().unwrap();
        if round == 0 {
            wait_for_a_sample(&out, &mut child);
        } else {
            std::thread::sleep(Duration::from_millis(100));
        }
        let sent = Command::new("kill").arg(signal).arg(child.id().to_string()).status().unwrap();
        assert!(sent.success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(75), "{}", text(&output.stderr));
        let standing = records(&out);
        let told = format!("border, {standing} of 12 pairs stand: run the same command again");
        assert!(standing < 12 && text(&output.stderr).contains(&told), "{}", text(&output.stderr));
        assert!(!in_a_sample(&out), "stopped within a sample");
        assert!(!out.join("manifest.jsonl").exists());
    }
    succeeds(&mut bench.generate(&out, &SLOW));
    assert_same(&tree(&out), &bench.undisturbed(&SLOW), "after two signals");
}

#[test]
fn a_second_process_is_refused_and_a_dead_owners_lock_is_taken_over() {
    let bench = Bench::new();
    let out = bench.out("shared");
    let mut first = bench.generate(&out, &SLOW).spawn().unwrap();
    wait_for_a_sample(&out, &mut first);
    let second = bench.generate(&out, &SLOW).output().unwrap();
    assert_eq!(second.status.code(), Some(2));
    assert!(text(&second.stderr).contains("another satseed is writing into"), "{}", text(&second.stderr));
    first.kill().unwrap();
    first.wait().unwrap();
    succeeds(&mut bench.generate(&out, &SLOW));
    assert_same(&tree(&out), &bench.undisturbed(&SLOW), "after the owner's death");
}

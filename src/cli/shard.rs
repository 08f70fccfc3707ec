//! Which shard: as told, or as the engine of a job array tells its tasks.

use anyhow::{Context as _, bail};
use satseed::plan::{MAX_SHARDS, Shard};
use std::str::FromStr;

/// What `--shard` says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShardChoice {
    /// `I/N`
    Given(Shard),
    /// `auto`, `auto/N`
    Auto(Option<u32>),
}

impl FromStr for ShardChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('/') {
            None if text == "auto" => Ok(Self::Auto(None)),
            Some(("auto", count)) => match count.parse() {
                Ok(count) if (1..=MAX_SHARDS).contains(&count) => Ok(Self::Auto(Some(count))),
                _ => Err(format!("auto/N takes an N from 1 to {MAX_SHARDS}, not \"{count}\"")),
            },
            _ => text.parse().map(Self::Given).map_err(|e: satseed::plan::ShardError| e.to_string()),
        }
    }
}

impl ShardChoice {
    /// The shard, with what the environment's variables say.
    pub(crate) fn resolve(self, variable: &dyn Fn(&str) -> Option<String>) -> anyhow::Result<Shard> {
        let count = match self {
            Self::Given(shard) => return Ok(shard),
            Self::Auto(count) => count,
        };
        let number = |name: &str| -> anyhow::Result<Option<u32>> {
            let parse = |text: String| text.trim().parse().with_context(|| format!("{name} is no number: `{text}`"));
            variable(name).map(parse).transpose()
        };
        let (slurm, kubernetes) = (number("SLURM_ARRAY_TASK_ID")?, number("JOB_COMPLETION_INDEX")?);
        let (index, count) = match (slurm, kubernetes, count) {
            (Some(id), _, None) => {
                let known = "Slurm tells its array tasks: SLURM_ARRAY_TASK_COUNT";
                let count = number("SLURM_ARRAY_TASK_COUNT")?.with_context(|| format!("{known} is not set"))?;
                let first = number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(1);
                let last = number("SLURM_ARRAY_TASK_MAX")?.unwrap_or(first.saturating_add(count.saturating_sub(1)));
                if u64::from(first) + u64::from(count) != u64::from(last) + 1 {
                    bail!(
                        "the array has {count} tasks from {first} to {last}, so some are left out: say how many shards there \
                         are with --shard auto/N, and submit indices from 1 to N"
                    );
                }
                (id.checked_sub(first).and_then(|i| i.checked_add(1)), count)
            }
            (Some(id), _, Some(count)) => (Some(id), count),
            (None, Some(index), Some(count)) => (index.checked_add(1), count),
            (None, Some(_), None) => {
                bail!(
                    "a Kubernetes job does not tell how many completions it has: write --shard auto/N with that number"
                )
            }
            (None, None, _) => bail!(
                "--shard auto reads SLURM_ARRAY_TASK_ID or JOB_COMPLETION_INDEX, but neither is set: it is for tasks of a job \
                 array; write --shard I/N"
            ),
        };
        let shard = index.and_then(|index| Shard::new(index, count));
        shard.with_context(|| match index {
            Some(index) => format!("this is task {index} of {count}, but shards are from 1 to N: submit such an array"),
            None => "the task's number is before the array's first: the environment contradicts itself".to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolved(choice: &str, variables: &[(&str, &str)]) -> Result<Shard, String> {
        let variable = |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| (*value).to_owned());
        choice.parse::<ShardChoice>().unwrap().resolve(&variable).map_err(|e| format!("{e:#}"))
    }

    const SLURM: [&str; 4] =
        ["SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_MAX"];

    fn slurm(values: [&str; 4]) -> Vec<(&'static str, &str)> {
        SLURM.into_iter().zip(values).collect()
    }

    #[test]
    fn a_task_knows_its_shard() {
        let shard = |i, n| Ok(Shard::new(i, n).unwrap());
        assert_eq!(resolved("2/8", &slurm(["5", "9", "1", "9"])), shard(2, 8), "what is written counts");
        assert_eq!(resolved("auto", &slurm(["1", "4", "1", "4"])), shard(1, 4));
        assert_eq!(resolved("auto", &slurm(["3", "4", "0", "3"])), shard(4, 4), "arrays may begin with 0");
        assert_eq!(resolved("auto", &slurm(["7", "4", "5", "8"])), shard(3, 4));
        assert_eq!(resolved("auto", &slurm(["7", "4", "5", "8"])[..3]), shard(3, 4));
        assert_eq!(resolved("auto/64", &slurm(["7", "1", "7", "7"])), shard(7, 64), "one task submitted again");
        assert_eq!(resolved("auto/3", &[("JOB_COMPLETION_INDEX", "0")]), shard(1, 3));
        assert_eq!(resolved("auto/3", &[("JOB_COMPLETION_INDEX", "2")]), shard(3, 3));
    }

    #[test]
    fn what_cannot_be_is_told() {
        let told = |choice, variables: &[(&str, &str)]| resolved(choice, variables).unwrap_err();
        assert!(told("auto", &[]).contains("neither is set"));
        assert!(told("auto/4", &[]).contains("neither is set"));
        assert!(told("auto", &[("JOB_COMPLETION_INDEX", "0")]).contains("--shard auto/N"));
        assert!(told("auto/3", &[("JOB_COMPLETION_INDEX", "3")]).contains("task 4 of 3"));
        assert!(told("auto", &slurm(["3", "2", "3", "7"])).contains("some are left out"));
        assert!(told("auto", &slurm(["x", "2", "1", "2"])).contains("no number: `x`"));
        assert!(told("auto", &[("SLURM_ARRAY_TASK_ID", "1")]).contains("SLURM_ARRAY_TASK_COUNT is not set"));
        assert!(told("auto/4", &slurm(["0", "4", "0", "3"])).contains("task 0 of 4"));
        for bad in ["auto/", "auto/0", "auto/x", "auto/1000000", "automatic", "", "5"] {
            assert!(bad.parse::<ShardChoice>().is_err(), "{bad}");
        }
    }
}

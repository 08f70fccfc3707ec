//! Shards over machines of different speed, with the measured costs of scenes and pairs.

use satseed::plan::{Costs, Plan, Shard};
use satseed::recipe::{Changes, Recipe};

/// What each shard of a plan costs, ms of a core.
fn shard_costs(recipe: &Recipe, plan: &Plan, count: u32) -> Vec<u64> {
    let costs = Costs::of(recipe);
    let cost = |shard: Shard| {
        let share = |share: &satseed::plan::Share| costs.scene(&plan.scenes[share.scene]).of_pairs(share.pairs.len());
        shard.of(recipe, plan).iter().map(share).sum()
    };
    (1..=count).map(|index| cost(Shard::new(index, count).unwrap())).collect()
}

/// When the last machine is done, if each takes the next shard as soon as it is free, as the engine of a job array has it.
fn makespan(shards: &[u64], speeds: &[f64]) -> f64 {
    let mut free_at = vec![0.0; speeds.len()];
    for ms in shards {
        let (machine, _) = free_at.iter().enumerate().min_by(|a, b| f64::total_cmp(a.1, b.1)).unwrap();
        free_at[machine] += *ms as f64 / speeds[machine];
    }
    free_at.into_iter().fold(0.0, f64::max)
}

#[test]
fn machines_of_different_speed_end_together() {
    for preset in ["satunreal", "satseed"] {
        let recipe = Recipe::load(preset, &Changes::default()).unwrap();
        let plan = Plan::new(&recipe).unwrap();
        let whole = Costs::of(&recipe).plan_ms(&plan) as f64;
        for speeds in [
            &[1.0, 1.0][..],
            &[1.0, 2.0],
            &[1.0, 3.0],
            &[1.0, 1.3, 2.0, 4.0],
            &[1.0, 1.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0],
        ] {
            // As docs/cluster.md advises: sixteen shards a machine.
            let count = 16 * speeds.len() as u32;
            let shards = shard_costs(&recipe, &plan, count);
            // The time of machines that share the work of one undivided run to the last second.
            let balanced = whole / speeds.iter().sum::<f64>();
            let took = makespan(&shards, speeds) / balanced;
            let extra = shards.iter().sum::<u64>() as f64 / whole;
            eprintln!("{preset}: {count} shards on speeds {speeds:?}: {took:.3} of balanced, work {extra:.3}");
            assert!(took <= 1.15, "{preset}, {speeds:?}: {took}");
            assert!(took >= 0.999, "nobody is faster than balanced: {took}");
        }
    }
}

#[test]
fn shards_of_a_plan_cost_the_same() {
    let recipe = Recipe::load("satunreal", &Changes::default()).unwrap();
    let plan = Plan::new(&recipe).unwrap();
    for count in [2, 7, 64, 256] {
        let shards = shard_costs(&recipe, &plan, count);
        let whole = Costs::of(&recipe).plan_ms(&plan) as f64;
        let dearest = *shards.iter().max().unwrap() as f64;
        // At most one pair and one scene more than the mean of an undivided run.
        let costs = Costs::of(&recipe);
        let slack = plan.scenes.iter().map(|s| costs.scene(s).of_pairs(1)).max().unwrap() as f64;
        assert!(dearest <= whole / f64::from(count) + 2.0 * slack, "{count}: {dearest} of {whole}");
    }
}

//! Rays side by side get the answers that they get alone, to the last bit, with every instruction set.

use super::scenes::{ALTITUDES_M, FAMILIES, member};
use glam::DVec3;
use satseed_scene::{Ray, Rng, SeedPath};
use satseed_tracer::{Hit, InstructionSet, Origin, Tracer, tile_order};

/// Answers of one tracer to all kinds of questions.
#[derive(PartialEq, Debug)]
struct Answers {
    seen: Vec<Option<Hit>>,
    occluded: Vec<bool>,
    shaded: Vec<bool>,
    around: Vec<Option<Hit>>,
}

struct Questions {
    rays: Vec<Ray>,
    target: DVec3,
    sun: DVec3,
    /// A direction for each ray, on either side of a surface.
    around: Vec<DVec3>,
}

fn side_by_side(tracer: &Tracer, q: &Questions) -> Answers {
    let seen = tracer.closest_all(&q.rays);
    let starts: Vec<Origin> = seen.iter().flatten().map(Origin::on).collect();
    let with = |direction: DVec3| starts.iter().map(|s| (*s, direction)).collect::<Vec<_>>();
    let around: Vec<_> = starts.iter().copied().zip(q.around.iter().copied()).collect();
    Answers {
        occluded: tracer.occluded_all(&with(q.target)),
        shaded: tracer.blocked_all(&with(q.sun)),
        around: tracer.closest_from_all(&around),
        seen,
    }
}

fn alone(tracer: &Tracer, q: &Questions) -> Answers {
    let seen: Vec<_> = q.rays.iter().map(|r| tracer.closest(r, tracer.reach_m(r.origin))).collect();
    let starts: Vec<Origin> = seen.iter().flatten().map(Origin::on).collect();
    Answers {
        occluded: starts.iter().map(|s| tracer.occluded(s, q.target)).collect(),
        shaded: starts.iter().map(|s| tracer.blocked(s, q.sun, tracer.reach_m(s.point()))).collect(),
        around: starts
            .iter()
            .zip(&q.around)
            .map(|(s, d)| tracer.closest_from(s, *d, tracer.reach_m(s.point())))
            .collect(),
        seen,
    }
}

fn direction(rng: &mut Rng) -> DVec3 {
    DVec3::new(rng.signed(), rng.signed(), rng.signed()).try_normalize().unwrap_or(DVec3::X)
}

#[test]
fn side_by_side_as_alone_with_every_instruction_set() {
    let sets: Vec<InstructionSet> = InstructionSet::ALL.into_iter().filter(|s| s.is_available()).collect();
    let mut hits = 0;
    for family in &FAMILIES {
        for (altitude_m, seed) in ALTITUDES_M.into_iter().flat_map(|a| (0..3).map(move |s| (a, 500 + s))) {
            let (scene, rig) = member(family, seed, altitude_m);
            let mut rng = SeedPath::root(family.name, seed).child("questions").rng();
            let camera = &rig.left;
            let mut rays = Vec::new();
            for top in (0..camera.height_px).step_by(16) {
                for left in (0..camera.width_px).step_by(16) {
                    let cells = tile_order(16.min(camera.width_px - left), 16.min(camera.height_px - top));
                    rays.extend(cells.map(|(x, y)| camera.ray(f64::from(left + x), f64::from(top + y))));
                }
            }
            // Some that go any way, and some along the axes.
            for k in 0..200 {
                let target = direction(&mut rng) * 10.0;
                let from = direction(&mut rng) * 300.0;
                rays.push(Ray { origin: from, direction: (target - from).normalize() });
                if k < 60 {
                    rays.push(Ray { origin: DVec3::new(rng.signed(), rng.signed(), 50.0), direction: DVec3::NEG_Z });
                }
            }
            let questions = Questions {
                target: rig.right.position_m,
                sun: DVec3::new(rng.signed(), rng.signed(), rng.unit() + 0.05).normalize(),
                around: rays.iter().map(|_| direction(&mut rng)).collect(),
                rays,
            };
            let expected = alone(&Tracer::new(&scene).with_instructions(InstructionSet::Portable), &questions);
            hits += expected.seen.iter().flatten().count();
            for set in &sets {
                let tracer = Tracer::new(&scene).with_instructions(*set);
                let place = format!("{} {seed} at {altitude_m} m with {set:?}", family.name);
                assert!(alone(&tracer, &questions) == expected, "alone: {place}");
                assert!(side_by_side(&tracer, &questions) == expected, "side by side: {place}");
            }
        }
    }
    assert!(hits > 30_000, "only {hits} hits tested anything");
}

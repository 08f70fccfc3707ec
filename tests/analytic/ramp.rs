//! A ramp: gentle, steep enough to hide from a camera, rising either way.

use crate::analytic::bodies::Wedge;
use crate::analytic::boxes::{PLACEMENTS, report, rigs, wedge_scene};
use crate::analytic::closed_form::{Tally, check};

#[test]
fn ramps() {
    for (what, x0, x1, height, near, far) in [
        ("gentle, rising right", -40.0, 40.0, 20.0, [-100.0, 100.0], [-61_700.0, 61_700.0]),
        ("gentle, rising left", 41.25, -38.75, 20.0, [-100.0, 100.0], [-61_700.0, 61_700.0]),
        // Slope 8: hidden from a camera more than altitude / 8 beyond its foot.
        ("steep, rising right", -5.0, 0.0, 40.0, [58.1, 261.3], [10.0, 123_410.0]),
        ("steep, rising left", 6.25, 1.25, 40.0, [-261.3, -58.13], [-123_410.0, -10.0]),
    ] {
        let wedge = Wedge { x0, x1, height, ground_half: 3200.0 };
        let mut tally = Tally::default();
        for placement in PLACEMENTS {
            let scene = wedge_scene(&wedge, placement);
            for case in rigs(placement, near, far) {
                tally.add(&check(&format!("{what} {placement:?}"), &scene, &case, &wedge));
            }
        }
        report(&format!("ramp {what}"), &tally);
        assert!(tally.pixels[1] > 0 && tally.pixels[2] > 0 && tally.pixels[3] > 0, "{tally:?}");
    }
}

//! The minimum length of a belly is approached smoothly.

use proptest::prelude::*;
use sinew_core::muscles::muscle::{STRETCH_CLAMPED, STRETCH_FLOOR, floored};

fn slope(stretch: f64) -> f64 {
    let step = 1e-6;
    (floored(stretch + step) - floored(stretch - step)) / (2.0 * step)
}

proptest! {
    #[test]
    fn it_never_goes_below_the_minimum_and_never_decreases(stretch in -20.0..20.0f64, step in 0.0..5.0f64) {
        prop_assert!(floored(stretch) >= STRETCH_FLOOR);
        prop_assert!(floored(stretch + step) >= floored(stretch));
    }

    #[test]
    fn it_is_exact_above_the_clamp(stretch in STRETCH_CLAMPED..20.0f64) {
        prop_assert_eq!(floored(stretch), stretch);
    }

    #[test]
    fn its_slope_has_no_jump(stretch in -1.0..1.0f64) {
        prop_assert!((slope(stretch) - slope(stretch + 1e-4)).abs() < 2e-3);
    }
}

#[test]
fn value_and_slope_meet_at_the_clamp() {
    assert!((floored(STRETCH_CLAMPED - 1e-12) - STRETCH_CLAMPED).abs() < 1e-11);
    assert!((slope(STRETCH_CLAMPED - 1e-5) - slope(STRETCH_CLAMPED + 1e-5)).abs() < 1e-3);
}

//! Ticks and scales of charts.

use powergs_chart::Scale;

#[test]
fn linear_scales_end_on_round_numbers() {
    for (high, ends, ticks) in
        [(17.8, 20.0, 5), (0.93, 1.0, 6), (4.0, 4.0, 5), (101.0, 120.0, 7), (0.0, 1.0, 6)]
    {
        let scale = Scale::from_zero(high);
        assert!((scale.high() - ends).abs() < 1e-12, "{high} ends at {}", scale.high());
        assert_eq!(scale.ticks(6).len(), ticks, "{high}: {:?}", scale.ticks(6));
        assert_eq!((scale.share(0.0), scale.share(ends)), (0.0, 1.0));
    }
}

#[test]
fn values_off_the_scale_stay_on_the_page() {
    let scale = Scale::linear(0.0, 10.0);
    assert_eq!((scale.share(-5.0), scale.share(25.0)), (0.0, 1.0));
    let scale = Scale::logarithmic(0.1, 10.0);
    assert_eq!((scale.share(0.0), scale.share(1e9)), (0.0, 1.0));
    // Half-way on a logarithmic scale; 1e-9 is room for rounding.
    assert!((scale.share(1.0) - 0.5).abs() < 1e-9);
}

#[test]
fn what_is_no_number_stays_on_the_page_too() {
    for scale in [Scale::linear(0.0, 10.0), Scale::logarithmic(0.1, 10.0)] {
        assert_eq!(scale.share(f64::NAN), 0.0);
        assert_eq!(scale.share(f64::INFINITY), 1.0);
        assert_eq!(scale.share(f64::NEG_INFINITY), 0.0);
    }
    for scale in [
        Scale::linear(f64::NAN, f64::INFINITY),
        Scale::logarithmic(f64::NAN, -1.0),
        Scale::logarithmic(0.0, f64::INFINITY),
        Scale::from_zero(f64::NAN),
        Scale::around([f64::NAN, f64::INFINITY], 0.1),
    ] {
        assert!(scale.low().is_finite() && scale.high() > scale.low(), "{scale:?}");
        assert!(scale.ticks(6).iter().all(|t| t.is_finite()), "{scale:?}");
    }
}

#[test]
fn logarithmic_ticks_exist_inside_one_decade_and_over_many() {
    let inside = Scale::logarithmic(2.1, 8.7).ticks(6);
    assert_eq!(inside.len(), 3, "{inside:?}");
    let wide = Scale::logarithmic(2e-7, 3e9).ticks(6);
    assert!((6..20).contains(&wide.len()), "{wide:?}");
    assert!(wide.windows(2).all(|w| (w[1] / w[0] - 10.0).abs() < 1e-6));
}

#[test]
fn whole_ticks_are_whole_and_apart() {
    let ticks = Scale::linear(0.0, 2.0).whole_ticks(10);
    assert_eq!(ticks, [0.0, 1.0, 2.0]);
}

#[test]
fn an_axis_has_at_least_three_ticks() {
    for (low, high) in [(0.2980, 0.2985), (1.0, 1.9), (0.9, 2.1), (17.0, 24.0), (0.0, 1.0)] {
        for count in 1..9 {
            let ticks = Scale::linear(low, high).ticks(count);
            assert!(ticks.len() > 2, "{low} to {high}, {count}: {ticks:?}");
            if low > 0.0 {
                let ticks = Scale::Log { low, high }.ticks(count);
                assert!(ticks.len() > 2, "{low} to {high}, {count}: {ticks:?}");
            }
        }
    }
}

#[test]
fn rounded_ends_have_ticks() {
    let scale = Scale::rounded(1143.0, 1186.0);
    let ticks = scale.ticks(6);
    assert_eq!((scale.low(), scale.high()), (1140.0, 1190.0));
    assert_eq!((ticks[0], ticks[ticks.len() - 1]), (1140.0, 1190.0), "{ticks:?}");
}

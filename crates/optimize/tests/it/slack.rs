//! What quality to spare would buy, on models whose law is known.

use powergs_optimize::slack::{SlackPrice, Spending};

/// A model that spends a share of the display power `shift` and pays by its square: its error, of
/// the allowed one, is `error + shift² · cost`.
fn dimmed(display_w: f64, error: f64, cost: f64, shift: f64) -> Spending {
    let error: f64 = error + cost * shift * shift;
    Spending { margin_db: -10.0 * error.log10(), display_w: display_w * (1.0 - shift) }
}

#[test]
fn the_unpruned_model_tells_what_slack_buys_elsewhere() {
    for (error, cost) in [(1e-9, 4.0), (0.3, 4.0), (0.9, 0.5)] {
        let all = f64::sqrt((1.0 - error) / cost).min(0.9);
        let (intact, spent) = (dimmed(2.0, error, cost, 0.0), dimmed(2.0, error, cost, 0.98 * all));
        let price = SlackPrice::between(intact, spent).unwrap();
        // The same law elsewhere: another display power, another error.
        for other in [1e-9, 0.5, 0.8] {
            let most = f64::sqrt((1.0 - other) / cost).min(0.9);
            let want = 3.0 * (1.0 - most);
            let got = price.display_w(dimmed(3.0, other, cost, 0.0), false);
            assert!((got / want - 1.0).abs() < 1e-6, "{got} W, {want} W: {error} {cost} {other}");
        }
        // A model that has spent a part is left with the rest, of what it had before it began: here
        // that is known, as nothing is pruned.
        let half = dimmed(2.0, error, cost, 0.5 * all);
        let (got, want) = (price.display_w(half, true), 2.0 * (1.0 - all));
        assert!((got / want - 1.0).abs() < 1e-6, "{got} W, {want} W");
        // What is on the target has nothing to spend.
        for margin_db in [0.0, -0.1] {
            let on = Spending { margin_db, display_w: 1.0 };
            assert_eq!(price.display_w(on, false), 1.0);
            assert!((price.display_w(on, true) - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn nothing_spent_is_no_price() {
    let intact = Spending { margin_db: 3.0, display_w: 1.0 };
    let spent =
        |margin_db, display_w| SlackPrice::between(intact, Spending { margin_db, display_w });
    assert!(spent(2.95, 0.9).is_none(), "next to nothing");
    assert!(spent(0.0, 1.0).is_none() && spent(0.0, 1.1).is_none(), "nothing saved");
    assert!(spent(0.0, 0.9).is_some());
    let dark = SlackPrice::between(Spending { display_w: 0.0, ..intact }, intact);
    assert!(dark.is_none());
}

//! Five ways to choose a model and a machine, and what each finds.
//!
//! Every way ranks pairs by watts, display, rendering and standby together at the display rate,
//! among those that reach the quality, keep the deadline and fit the area. The first few of its
//! list are simulated once more with the `banked` model of the DRAM, and the best of these by that
//! is what it finds; if none of them keeps the budget then, the next few. The pairs of (a) to (d)
//! are candidates of (e), so that (e) is never worse.

use std::collections::BTreeMap;

use super::pricing::{Fate, MachinePoint, Price, Row};

/// Pairs of a list that are confirmed at a time.
pub const CONFIRMED: usize = 3;
/// Pairs of a list that are confirmed at most.
const CONFIRMED_MOST: usize = 12;
/// Areas that differ by less than this share are the same.
const SAME_AREA: f64 = 1e-9;

/// A pair: the place of its model, and its machine.
pub type Pair = (usize, MachinePoint);

/// How a pair is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// The best machine for the dense model.
    Dense,
    /// The best model for the base machine.
    Base,
    /// The best machine for the dense model, then the best model for that machine.
    MachineFirst,
    /// The best model for the base machine, then the best machine for that model.
    ModelFirst,
    /// The best pair of all.
    Joint,
}

impl Way {
    /// All ways, in their order.
    pub const ALL: [Way; 5] =
        [Way::Dense, Way::Base, Way::MachineFirst, Way::ModelFirst, Way::Joint];

    /// Its letter.
    pub const fn letter(self) -> char {
        match self {
            Way::Dense => 'a',
            Way::Base => 'b',
            Way::MachineFirst => 'c',
            Way::ModelFirst => 'd',
            Way::Joint => 'e',
        }
    }

    /// What it does, in a few words.
    pub const fn words(self) -> &'static str {
        match self {
            Way::Dense => "best machine for the dense model",
            Way::Base => "best model for the base machine",
            Way::MachineFirst => "machine first, then the model",
            Way::ModelFirst => "model first, then the machine",
            Way::Joint => "both together",
        }
    }
}

/// What a pair may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompareBudget {
    /// Area of the chip, mm².
    pub area_mm2: f64,
    /// Time of the slowest frame, ms.
    pub frame_ms: f64,
}

/// What keeps a pair out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Limit {
    /// Its chip is too large.
    Area,
    /// Its slowest frame takes too long.
    FrameTime,
    /// Both.
    Both,
    /// Its energy table has no areas.
    NoArea,
}

impl CompareBudget {
    /// What keeps a price out; `None`: nothing.
    pub fn limit(&self, price: &Price) -> Option<Limit> {
        let is_late = price.frame_ms > self.frame_ms;
        let Some(area) = price.area_mm2 else { return Some(Limit::NoArea) };
        match (area > self.area_mm2 * (1.0 + SAME_AREA), is_late) {
            (true, true) => Some(Limit::Both),
            (true, false) => Some(Limit::Area),
            (false, true) => Some(Limit::FrameTime),
            (false, false) => None,
        }
    }

    /// The largest share of a limit that a price takes; 1 is the limit.
    fn share(&self, price: &Price) -> f64 {
        let area = price.area_mm2.map_or(f64::INFINITY, |area| area / self.area_mm2);
        area.max(price.frame_ms / self.frame_ms)
    }
}

/// Why a way finds nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Nothing {
    /// Pairs that it had to choose from, with a model that reaches the quality.
    pub pairs: usize,
    /// How many of them each limit keeps out.
    pub limits: BTreeMap<Limit, usize>,
    /// How many of them are no machine, or cannot run the frames.
    pub refused: usize,
    /// The pair that takes least beyond the budget, with its price.
    pub nearest: Option<Box<(Pair, Price)>>,
}

/// A pair that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// The pair.
    pub pair: Pair,
    /// What it costs with the calibrated model of the DRAM.
    pub calibrated: Price,
    /// What it costs with the banked one; the same where the base machine has no banks.
    pub confirmed: Price,
}

/// What a way finds.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The way.
    pub way: Way,
    /// Its pair, or why there is none.
    pub found: Result<Found, Nothing>,
}

impl Comparison {
    /// Confirmed watts; `None` where it finds nothing.
    pub fn watts(&self) -> Option<f64> {
        self.found.as_ref().ok().map(|found| found.confirmed.total_w)
    }
}

/// Prices of pairs as the ways choose by them: one energy table, all views or a half.
#[derive(Clone, Copy)]
pub struct Market<'a> {
    /// By model; the dense model is the first.
    pub rows: &'a [Row],
    /// Whether each model reaches the quality.
    pub passed: &'a [bool],
    /// What a pair may take.
    pub budget: CompareBudget,
    /// The place of the energy table.
    pub table: usize,
    /// The place of the views in [`ModelPrices`](super::pricing::ModelPrices).
    pub scope: usize,
}

impl<'a> Market<'a> {
    /// The price of a pair; `None` if it has none.
    pub fn price(&self, (model, machine): Pair) -> Option<Price> {
        match self.rows.get(model)?.pairs.get(&machine)? {
            Fate::Priced(prices) => Some(prices.get(self.table)?[self.scope]),
            Fate::Refused(_) => None,
        }
    }

    /// All pairs of models that reach the quality.
    pub fn pairs(&self) -> impl Iterator<Item = Pair> + 'a {
        let passed = self.passed;
        let of = |(model, row): (usize, &'a Row)| row.pairs.keys().map(move |m| (model, *m));
        self.rows.iter().enumerate().filter(move |(i, _)| passed[*i]).flat_map(of)
    }

    /// The machines of a model that keep the budget, least watts first, at most so many; none where
    /// it misses the quality.
    pub fn best(&self, model: usize, most: usize) -> Vec<MachinePoint> {
        if !self.passed.get(model).is_some_and(|passed| *passed) {
            return Vec::new();
        }
        let pairs = self.rows[model].pairs.keys().map(|machine| (model, *machine));
        let ranked = self.ranked(pairs).unwrap_or_default();
        ranked.into_iter().take(most).map(|((_, machine), _)| machine).collect()
    }

    /// Those among `pairs` that keep the budget, least watts first.
    ///
    /// # Errors
    /// Why there are none.
    pub fn ranked(&self, pairs: impl Iterator<Item = Pair>) -> Result<Vec<(Pair, Price)>, Nothing> {
        let (mut ranked, mut nothing) = (Vec::new(), Nothing::default());
        for pair in pairs {
            nothing.pairs += 1;
            let Some(price) = self.price(pair) else {
                nothing.refused += 1;
                continue;
            };
            let Some(limit) = self.budget.limit(&price) else {
                ranked.push((pair, price));
                continue;
            };
            *nothing.limits.entry(limit).or_default() += 1;
            let share = self.budget.share(&price);
            if nothing.nearest.as_ref().is_none_or(|nearest| share < self.budget.share(&nearest.1))
            {
                nothing.nearest = Some(Box::new((pair, price)));
            }
        }
        ranked.sort_by(order);
        if ranked.is_empty() { Err(nothing) } else { Ok(ranked) }
    }
}

/// Least watts first, then the smaller and the faster one, then the first of the space.
fn order(a: &(Pair, Price), b: &(Pair, Price)) -> std::cmp::Ordering {
    let key = |(_, p): &(Pair, Price)| [p.total_w, p.area_mm2.unwrap_or(f64::MAX), p.frame_ms];
    let numbers = key(a).into_iter().zip(key(b)).map(|(a, b)| a.total_cmp(&b));
    numbers.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then).then(a.0.cmp(&b.0))
}

/// Simulates pairs with the banked model: their prices in the order asked for, `None` for one that
/// cannot be simulated. The whole is `None` after a cancellation.
pub type Confirm<'c, E> = dyn FnMut(&[Pair]) -> Result<Option<Vec<Option<Price>>>, E> + 'c;

/// Goes all five ways. `None` after a cancellation.
///
/// # Errors
/// Those of `confirm`.
pub fn compare<E>(
    market: &Market<'_>,
    confirm: &mut Confirm<'_, E>,
    each: &mut dyn FnMut(&Comparison),
) -> Result<Option<Vec<Comparison>>, E> {
    let mut done: Vec<Comparison> = Vec::new();
    let mut confirmed: BTreeMap<Pair, Option<Price>> = BTreeMap::new();
    for way in Way::ALL {
        let before = |way: Way| {
            let found = done.iter().find(|c| c.way == way).map(|c| c.found.clone());
            found.unwrap_or(Err(Nothing::default()))
        };
        let all = || market.pairs();
        let first = match way {
            Way::MachineFirst => Some(before(Way::Dense)),
            Way::ModelFirst => Some(before(Way::Base)),
            Way::Dense | Way::Base | Way::Joint => None,
        };
        let ranked = match (way, first) {
            (_, Some(Err(nothing))) => Err(nothing),
            (Way::Dense, _) => market.ranked(all().filter(|(model, _)| *model == 0)),
            (Way::Base, _) => market.ranked(all().filter(|(_, machine)| machine.is_none())),
            (Way::MachineFirst, Some(Ok(found))) => {
                market.ranked(all().filter(|pair| pair.1 == found.pair.1))
            }
            (Way::ModelFirst, Some(Ok(found))) => {
                market.ranked(all().filter(|pair| pair.0 == found.pair.0))
            }
            (Way::Joint | Way::MachineFirst | Way::ModelFirst, _) => market.ranked(all()),
        };
        let found = match ranked {
            Err(nothing) => Err(nothing),
            Ok(ranked) => {
                let winners: Vec<Found> = match way {
                    Way::Joint => done.iter().filter_map(|c| c.found.clone().ok()).collect(),
                    _ => Vec::new(),
                };
                match first_confirmed(market, &ranked, &mut confirmed, confirm)? {
                    None => return Ok(None),
                    Some(found) => best_of(found, winners),
                }
            }
        };
        let comparison = Comparison { way, found };
        each(&comparison);
        done.push(comparison);
    }
    Ok(Some(done))
}

/// The best of a list once it is confirmed. `None` after a cancellation.
fn first_confirmed<E>(
    market: &Market<'_>,
    ranked: &[(Pair, Price)],
    known: &mut BTreeMap<Pair, Option<Price>>,
    confirm: &mut Confirm<'_, E>,
) -> Result<Option<Result<Found, Nothing>>, E> {
    let mut nothing = Nothing { pairs: ranked.len(), ..Nothing::default() };
    let mut found: Vec<Found> = Vec::new();
    for some in ranked[..ranked.len().min(CONFIRMED_MOST)].chunks(CONFIRMED) {
        // Ways share pairs, and each is simulated once.
        let new: Vec<Pair> = some.iter().map(|s| s.0).filter(|p| !known.contains_key(p)).collect();
        if !new.is_empty() {
            let Some(prices) = confirm(&new)? else { return Ok(None) };
            known.extend(new.into_iter().zip(prices));
        }
        for &(pair, calibrated) in some {
            let Some(confirmed) = known[&pair] else {
                nothing.refused += 1;
                continue;
            };
            match market.budget.limit(&confirmed) {
                None => found.push(Found { pair, calibrated, confirmed }),
                Some(limit) => {
                    *nothing.limits.entry(limit).or_default() += 1;
                    let share = market.budget.share(&confirmed);
                    if nothing
                        .nearest
                        .as_ref()
                        .is_none_or(|near| share < market.budget.share(&near.1))
                    {
                        nothing.nearest = Some(Box::new((pair, confirmed)));
                    }
                }
            }
        }
        if !found.is_empty() {
            break;
        }
    }
    let best = found.into_iter().min_by(by_confirmed);
    Ok(Some(best.ok_or(nothing)))
}

fn by_confirmed(a: &Found, b: &Found) -> std::cmp::Ordering {
    order(&(a.pair, a.confirmed), &(b.pair, b.confirmed))
}

/// The best of what a list gave and of the winners before.
fn best_of(found: Result<Found, Nothing>, winners: Vec<Found>) -> Result<Found, Nothing> {
    match found {
        Ok(found) => Ok(winners.into_iter().fold(found, |best, other| {
            if by_confirmed(&other, &best).is_lt() { other } else { best }
        })),
        Err(nothing) => winners.into_iter().min_by(by_confirmed).ok_or(nothing),
    }
}

/// The pairs that no other beats in watts, area and frame time at once, among those of models that
/// reach the quality and keep the deadline: least watts first.
pub fn front(market: &Market<'_>) -> Vec<Pair> {
    let deadline = market.budget.frame_ms;
    let priced = market.pairs().filter_map(|pair| Some((pair, market.price(pair)?)));
    let mut all: Vec<(Pair, Price)> = priced.filter(|(_, p)| p.frame_ms <= deadline).collect();
    // Least watts first: what comes later can be beaten only by what is there already.
    all.sort_by(order);
    let mut front: Vec<(Pair, Price)> = Vec::new();
    for (pair, price) in all {
        let area = |price: &Price| price.area_mm2.unwrap_or(f64::MAX);
        let is_beaten = front
            .iter()
            .any(|(_, other)| area(other) <= area(&price) && other.frame_ms <= price.frame_ms);
        if !is_beaten {
            front.push((pair, price));
        }
    }
    front.into_iter().map(|(pair, _)| pair).collect()
}

//! Places for labels beside points, so that no label covers a mark or another label.

use super::scene::{Area, ScenePoint};
use crate::Side;

/// A label that needs a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// The point that it names.
    pub at: ScenePoint,
    /// Width and height of the text, page units.
    pub size: (f64, f64),
    /// Where it should be.
    pub side: Side,
    /// How far away it may be, page units.
    pub reach: f64,
}

/// What labels keep clear of.
#[derive(Debug, Clone, Default)]
pub struct Obstacles {
    /// Marks and texts that no label covers.
    pub solid: Vec<Area>,
    /// Curves that no label covers, in short pieces.
    pub curves: Vec<[ScenePoint; 2]>,
    /// Thin lines that labels cover only where there is no other place.
    pub faint: Vec<[ScenePoint; 2]>,
    /// Points of a crowd, of which labels cover as few as possible.
    pub crowd: Vec<ScenePoint>,
}

/// Rings around a point where labels are tried, page units.
const RINGS: [f64; 9] = [13.0, 19.0, 28.0, 44.0, 64.0, 90.0, 125.0, 170.0, 230.0];
/// As far away as a label may be that nothing but its place ties to its mark.
pub const BESIDE: f64 = 20.0;
/// Further away than this a label has a line to its point.
const LEADER: f64 = 22.0;

/// Finds a place for each label inside `frame`. Earlier labels choose first; a label without a free
/// place gets none.
pub fn place(wishes: &[Wish], obstacles: &Obstacles, frame: Area) -> Vec<Option<Area>> {
    let mut taken = Taken::default();
    let mut places = Vec::new();
    for wish in wishes {
        let best = best(wish, obstacles, &taken, frame);
        if let Some(area @ [l, t, r, b]) = best {
            taken.labels.push([l - 4.0, t, r + 4.0, b]);
            taken.leaders.extend(leader(wish.at, area));
        }
        places.push(best);
    }
    places
}

/// Labels that have their place, with the lines to their points.
#[derive(Default)]
struct Taken {
    labels: Vec<Area>,
    leaders: Vec<[ScenePoint; 2]>,
}

/// The line from a point to its label; `None` where that is beside it.
pub fn leader(at: ScenePoint, area: Area) -> Option<[ScenePoint; 2]> {
    let line = [at, nearest(at, area)];
    (length(line) > LEADER).then_some(line)
}

fn best(wish: &Wish, obstacles: &Obstacles, taken: &Taken, frame: Area) -> Option<Area> {
    let free = |area: &Area| {
        let inside = area[0] >= frame[0]
            && area[1] >= frame[1]
            && area[2] <= frame[2]
            && area[3] <= frame[3];
        let clear = |other: &Area| !overlap(*area, *other);
        inside
            && taken.labels.iter().all(clear)
            && obstacles.solid.iter().all(clear)
            && !obstacles.curves.iter().any(|line| crosses(*line, *area))
    };
    let mut best: Option<(f64, Area)> = None;
    for (cost, area) in candidates(wish) {
        let is_cheaper = |cost: f64| best.is_none_or(|b| cost < b.0);
        if !is_cheaper(cost) || !free(&area) {
            continue;
        }
        let faint = obstacles.faint.iter().filter(|line| crosses(**line, area)).count();
        let crowd = obstacles.crowd.iter().filter(|p| contains(area, **p)).count();
        let under = taken.leaders.iter().filter(|line| crosses(**line, area)).count();
        let over = leader(wish.at, area).map_or(0, |line| {
            let is_other = |mark: &&Area| !overlap(**mark, around(wish.at));
            let marks = obstacles.solid.iter().filter(is_other);
            let areas = marks.chain(&taken.labels).filter(|other| crosses(line, **other)).count();
            areas + taken.leaders.iter().filter(|other| meet(line, **other)).count()
        });
        // Each costs as much as so many units of distance.
        let lines = (over + under) as f64;
        let cost = cost + 30.0 * faint as f64 + 3.0 * crowd as f64 + 150.0 * lines;
        if is_cheaper(cost) {
            best = Some((cost, area));
        }
    }
    best.map(|b| b.1)
}

/// Places around a point with their distance, nearest first.
fn candidates(wish: &Wish) -> Vec<(f64, Area)> {
    let ((x, y), (width, height)) = (wish.at, wish.size);
    let mut all = Vec::new();
    if let Some((left, middle)) = beside(wish) {
        all.push((0.0, [left, middle - height / 2.0, left + width, middle + height / 2.0]));
    }
    for gap in RINGS.into_iter().filter(|gap| *gap <= wish.reach) {
        let side = gap * 0.75;
        let (left, right) = (x - gap - width, x + gap);
        let (up, down) = (y - height / 2.0 - gap, y + height / 2.0 + gap);
        let (near_up, near_down) = (y - height / 2.0 - side, y + height / 2.0 + side);
        // Above and below, a label may be anywhere over its point.
        let along = [0.5, 0.75, 0.25, 1.0, 0.0].map(|share| x - share * width);
        let level = [(right, y), (left, y)];
        let oblique = [
            (x + side, near_up),
            (x - side - width, near_up),
            (x + side, near_down),
            (x - side - width, near_down),
        ];
        let over = along.into_iter().flat_map(|start| [(start, up), (start, down)]);
        for (i, (start, middle)) in level.into_iter().chain(oblique).chain(over).enumerate() {
            let (top, bottom) = (middle - height / 2.0, middle + height / 2.0);
            all.push((gap + 0.1 * i as f64, [start, top, start + width, bottom]));
        }
    }
    all
}

/// A point as an area.
fn around((x, y): ScenePoint) -> Area {
    [x - 1.0, y - 1.0, x + 1.0, y + 1.0]
}

/// The left edge and the middle of a label on its side.
fn beside(wish: &Wish) -> Option<(f64, f64)> {
    let ((x, y), (width, _)) = (wish.at, wish.size);
    match wish.side {
        Side::Free => None,
        Side::Right => Some((x + 13.0, y)),
        Side::Left => Some((x - 13.0 - width, y)),
        Side::Above => Some((x - width / 2.0, y - 22.0)),
        Side::Below => Some((x - width / 2.0, y + 22.0)),
        Side::AboveLeft => Some((x - 8.0 - width, y - 14.0)),
        Side::BelowLeft => Some((x - 8.0 - width, y + 14.0)),
        Side::AboveRight => Some((x + 8.0, y - 14.0)),
    }
}

/// Whether two rectangles share more than an edge.
pub fn overlap(a: Area, b: Area) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Whether a straight line passes through a rectangle.
pub fn crosses([from, to]: [ScenePoint; 2], [l, t, r, b]: Area) -> bool {
    // The part of the line inside, as shares of its length: cut at each edge in turn.
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for (step, room) in [(-dx, from.0 - l), (dx, r - from.0), (-dy, from.1 - t), (dy, b - from.1)] {
        if step == 0.0 {
            if room < 0.0 {
                return false;
            }
        } else if step < 0.0 {
            first = first.max(room / step);
        } else {
            last = last.min(room / step);
        }
    }
    first < last
}

/// Whether two straight lines cross.
pub fn meet([a, b]: [ScenePoint; 2], [c, d]: [ScenePoint; 2]) -> bool {
    let side = |p: ScenePoint| (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0);
    let other = |p: ScenePoint| (d.0 - c.0) * (p.1 - c.1) - (d.1 - c.1) * (p.0 - c.0);
    side(c) * side(d) < 0.0 && other(a) * other(b) < 0.0
}

/// The point of a label that is nearest to a point, inside its letters.
fn nearest(at: ScenePoint, [l, t, r, b]: Area) -> ScenePoint {
    (at.0.clamp(l, r), at.1.clamp(t + 4.0, (b - 4.0).max(t + 4.0)))
}

/// Length of a straight line.
fn length([from, to]: [ScenePoint; 2]) -> f64 {
    (from.0 - to.0).hypot(from.1 - to.1)
}

fn contains([l, t, r, b]: Area, (x, y): ScenePoint) -> bool {
    x > l - 4.0 && x < r + 4.0 && y > t - 4.0 && y < b + 4.0
}

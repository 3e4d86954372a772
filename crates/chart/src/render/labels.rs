//! Places for labels beside points, so that no label covers a mark or another label.

use super::scene::{Area, Point};

/// A label that needs a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// The point that it names.
    pub at: Point,
    /// Width and height of the text, page units.
    pub size: (f64, f64),
    /// Whether it may stand further away, with a line to its point.
    pub may_leave: bool,
}

/// Finds a place for each label inside `frame`: never over a mark of `solid` or an earlier label,
/// and over as few points of `soft` as possible. Near places come first, earlier labels choose
/// first; a label without a free place gets none.
pub fn place(wishes: &[Wish], solid: &[Area], soft: &[Point], frame: Area) -> Vec<Option<Area>> {
    let mut taken: Vec<Area> = Vec::new();
    let mut places = Vec::new();
    for wish in wishes {
        let free = |area: &Area| {
            let inside = area[0] >= frame[0]
                && area[1] >= frame[1]
                && area[2] <= frame[2]
                && area[3] <= frame[3];
            let clear = |other: &Area| !overlap(*area, *other);
            inside && taken.iter().all(clear) && solid.iter().all(clear)
        };
        let covered = |area: &Area| soft.iter().filter(|p| contains(*area, **p)).count();
        let free = candidates(wish).into_iter().filter(free);
        // The first of the least covering.
        let best = free.min_by_key(covered);
        taken.extend(best.map(|[l, t, r, b]| [l - 4.0, t, r + 4.0, b]));
        places.push(best);
    }
    places
}

/// Whether two rectangles share more than an edge.
pub fn overlap(a: Area, b: Area) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

fn contains([l, t, r, b]: Area, (x, y): Point) -> bool {
    x > l - 4.0 && x < r + 4.0 && y > t - 4.0 && y < b + 4.0
}

/// Places around a point, nearest first, in eight directions.
fn candidates(wish: &Wish) -> Vec<Area> {
    let ((x, y), (width, height)) = (wish.at, wish.size);
    let rings: &[f64] =
        if wish.may_leave { &[15.0, 28.0, 48.0, 80.0, 120.0, 170.0, 230.0] } else { &[15.0] };
    let mut all = Vec::new();
    for gap in rings {
        let side = gap * 0.75;
        let (left, right) = (x - gap - width, x + gap);
        let (up, down) = (y - height / 2.0 - gap, y + height / 2.0 + gap);
        for (start, middle) in [
            (right, y),
            (left, y),
            (x - width / 2.0, up),
            (x - width / 2.0, down),
            (x + side, y - height / 2.0 - side),
            (x - side - width, y - height / 2.0 - side),
            (x + side, y + height / 2.0 + side),
            (x - side - width, y + height / 2.0 + side),
        ] {
            let (top, bottom) = (middle - height / 2.0, middle + height / 2.0);
            all.push([start, top, start + width, bottom]);
        }
    }
    all
}

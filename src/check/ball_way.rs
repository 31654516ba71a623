//! Where a ball gets to: its middle is followed over a lattice that is made as it goes, by distances to the surface itself.

use crate::geometry::vector::{Vec3, distance};
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::VecDeque;

/// Points that are asked at most in one search.
pub(super) const MOST_ASKED: u64 = 1 << 18;

/// Which points of the lattice lie beside each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beside {
    /// Six, along the axes: over points with half a step to spare, what leads from one to the next is a way for certain.
    Face,
    /// Twenty-six: over points that lack half a diagonal at most, no way is missed.
    Corner,
}

/// What is at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// No room for the ball.
    Blocked,
    /// Room, and the search goes on from here.
    Free,
    /// Room, and one of the places that are sought; the search does not go on from here.
    End(End),
}

/// What is sought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// The chamber that the ball starts from.
    Chamber,
    /// Where nothing is in its way any more.
    Outside,
}

/// Which ends are met from a point on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Met {
    pub chamber: bool,
    pub outside: bool,
}

impl Met {
    pub const BOTH: Met = Met { chamber: true, outside: true };

    fn add(&mut self, end: End) {
        match end {
            End::Chamber => self.chamber = true,
            End::Outside => self.outside = true,
        }
    }

    fn only(self) -> Option<End> {
        match (self.chamber, self.outside) {
            (true, false) => Some(End::Chamber),
            (false, true) => Some(End::Outside),
            _ => None,
        }
    }
}

/// A cubic lattice through a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    pub origin: Vec3,
    pub step: f64,
}

/// What a search over a lattice has met: the points with room, each with the ends that are met from it.
#[derive(Debug)]
pub(super) struct Search {
    lattice: Lattice,
    beside: Beside,
    known: FxHashSet<[i32; 3]>,
    free: FxHashMap<[i32; 3], Met>,
    pub asked: u64,
}

impl Search {
    pub fn over(lattice: Lattice, beside: Beside) -> Self {
        Search { lattice, beside, known: FxHashSet::default(), free: FxHashMap::default(), asked: 0 }
    }

    /// Which ends are met from a point on, points that were met before left out; `None` if more would have to be asked than
    /// [`MOST_ASKED`] in all. Where both are met, it goes no further.
    ///
    /// # Cost
    /// O(points met and their neighbours).
    pub fn met_from(&mut self, start: [i32; 3], place: &impl Fn(Vec3) -> Place) -> Option<Met> {
        let (mut met, mut free) = (Met::default(), Vec::new());
        let mut waiting = VecDeque::from_iter(self.known.insert(start).then_some(start));
        while let Some(index) = waiting.pop_front().filter(|_| self.asked <= MOST_ASKED && met != Met::BOTH) {
            self.asked += 1;
            match place(self.lattice.at(index)) {
                Place::Blocked => {}
                Place::End(end) => met.add(end),
                Place::Free => {
                    free.push(index);
                    waiting.extend(self.beside.around(index).filter(|&n| self.known.insert(n)));
                }
            }
        }
        self.free.extend(free.into_iter().map(|index| (index, met)));
        (self.asked <= MOST_ASKED).then_some(met)
    }

    pub fn step(&self) -> f64 {
        self.lattice.step
    }

    /// The nearest point of the lattice, if what leads there is a way for certain where both have half their step to spare, and
    /// the one end that is known to be met from it.
    pub fn beside(&self, p: Vec3, own_step: f64) -> Option<(Vec3, Option<End>)> {
        let index = self.lattice.nearest(p);
        let at = self.lattice.at(index);
        let end = self.free.get(&index).and_then(|met| met.only());
        (distance(at, p) <= 0.5 * (self.lattice.step + own_step)).then_some((at, end))
    }
}

impl Lattice {
    /// The point that is nearest to a place.
    pub fn nearest(&self, p: Vec3) -> [i32; 3] {
        [0, 1, 2].map(|a| ((p[a] - self.origin[a]) / self.step).round() as i32)
    }

    /// Where a point is.
    pub fn at(&self, index: [i32; 3]) -> Vec3 {
        [0, 1, 2].map(|a| self.origin[a] + self.step * f64::from(index[a]))
    }
}

impl Beside {
    /// The points beside one.
    pub fn around(self, at: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
        self.offsets().map(move |offset| [0, 1, 2].map(|a| at[a] + offset[a]))
    }

    fn offsets(self) -> impl Iterator<Item = [i32; 3]> {
        let all = (0..27).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]);
        all.filter(move |o: &[i32; 3]| {
            let steps: i32 = o.iter().map(|x| x.abs()).sum();
            steps == 1 || steps > 1 && self == Beside::Corner
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Lattice = Lattice { origin: [0.0; 3], step: 1.0 };

    /// Two rooms of 5 × 5 × 5 points that meet in one point at a corner.
    fn rooms(p: Vec3) -> Place {
        let within = |least: f64| p.iter().all(|&x| x >= least && x <= least + 4.0);
        match (within(0.0), within(5.0)) {
            (false, false) => Place::Blocked,
            _ if p == [0.0; 3] => Place::End(End::Chamber),
            _ if p == [9.0; 3] => Place::End(End::Outside),
            _ => Place::Free,
        }
    }

    #[test]
    fn over_corners_a_way_is_found_that_faces_do_not_have() {
        let met = |beside| Search::over(UNIT, beside).met_from([2; 3], &rooms).unwrap();
        assert_eq!([Beside::Face, Beside::Corner].map(met), [Met { chamber: true, outside: false }, Met::BOTH]);
    }

    #[test]
    fn a_search_that_has_no_end_gives_up() {
        let mut search = Search::over(UNIT, Beside::Face);
        assert_eq!(search.met_from([0; 3], &|_| Place::Free), None);
        assert_eq!(search.asked, MOST_ASKED + 1);
    }

    #[test]
    fn what_was_met_tells_its_end_to_what_lies_beside() {
        let mut search = Search::over(UNIT, Beside::Face);
        search.met_from([2; 3], &rooms);
        assert_eq!(search.beside([2.4, 3.0, 3.0], 0.0), Some(([2.0, 3.0, 3.0], Some(End::Chamber))));
        assert_eq!(search.beside([9.0, 8.0, 8.0], 0.0), Some(([9.0, 8.0, 8.0], None)));
        assert_eq!(search.beside([2.4, 3.4, 3.0], 0.0), None);
    }
}

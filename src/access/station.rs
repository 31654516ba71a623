//! One tool in one setup: where it cannot stand for certain, and how it comes to a point of the surface.

use super::flat_end::Covering;
use super::meridian::{Meridian, Support, level_and_rise, lies_flat};
use super::pose::{Rotation, Turns, product, quarter_turns, transposed};
use super::rise::Rise;
use super::setup::Setup;
use super::stack::{Sense, Stack};
use super::surface::Patch;
use super::tool::{Body, Tool};
use crate::convolution::Descent;
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::geometry::MeshDistance;
use crate::geometry::vector::{Vec3, add, along, distance, dot, norm, scale, sub, unit};
use crate::morphology::{Sides, StructuringElement, dilate};
use crate::topology::{Adjacency, components};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A tool at a rotation, with the tips at which it may meet the part.
pub struct Station<'a> {
    tool: &'a Tool,
    /// Rows of the matrix from the frame of the part to that of the station.
    frame: Rotation,
    /// Rotation of the tool in the station's frame; the identity for a coaxial one.
    turn: Rotation,
    /// The turned shape, of a tool that is not coaxial.
    posed: Option<Arc<Sides>>,
    /// Radii and heights at the ends of the pieces of a coaxial cutter that is not convex: corners that touch too.
    corners: Vec<[f64; 2]>,
    /// A coaxial tool, thinner by what is not in its way.
    thin: Option<Meridian>,
    /// Samples at which the tool is not known to be free of the part.
    hit: Indicator,
    /// Samples with a free one at most [`NEAR`] samples away along each axis.
    near_free: Indicator,
}

/// A pose at which a tool is free and near a point of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stand {
    /// Distance from the point to the nearest considered point of the cutter.
    pub distance: f64,
    /// The tip, in the frame of the part.
    pub tip: Vec3,
}

/// So many samples a pose may lie from touching: what 2·√3 spacings round to.
const NEAR: usize = 4;

/// Millimetres above the tip that a cutter is used along to grip or cut.
const REACHED_ALONG: f64 = 12.0;

const IDENTITY: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl<'a> Station<'a> {
    /// The stations of a tool that comes from the direction of a setup: a coaxial one stands in the setup, any other, at each of the
    /// setup's turns, in the first setup of the list.
    ///
    /// # Errors
    /// As [`Station::new`].
    pub fn all(tool: &'a Tool, first: &'a Setup, setup: &'a Setup) -> impl Iterator<Item = Result<Self>> + 'a {
        let turns: Vec<Option<Rotation>> = match tool.body {
            Body::Coaxial(_) => vec![None],
            Body::Solid(_) => match setup.turns {
                Turns::Nowhere => Vec::new(),
                Turns::Quarters => quarter_turns(first.to_frame(setup.direction)).into_iter().map(Some).collect(),
                Turns::At(turn) => vec![Some(product(first.frame, turn))],
            },
        };
        turns.into_iter().map(move |turn| Station::new(tool, if turn.is_some() { first } else { setup }, turn))
    }

    /// A coaxial tool in a setup, or any tool at a rotation in the frame of the setup.
    ///
    /// A tip counts as free only if the tool there overlaps no cube that the part touches. For a tool that does not widen
    /// upwards it must also be joined to the border of the grid through cells in which it is free, so that it can get there.
    ///
    /// # Errors
    /// As [`Sides::of_mesh`].
    pub fn new(tool: &'a Tool, setup: &Setup, turn: Option<Rotation>) -> Result<Self> {
        let spacing = setup.grid().spacing();
        let (hit, turn, posed) = match (&tool.body, turn) {
            (Body::Coaxial(m), _) => (coaxial_hits(m, setup), IDENTITY, None),
            (Body::Solid(mesh), turn) => {
                let turn = turn.unwrap_or(IDENTITY);
                let posed = Sides::of_mesh(&mesh.transformed(turn, [0.0; 3]), spacing, [0.0; 3])?;
                (setup.outer_descent().met_by(&posed.touched)?, turn, Some(Arc::new(posed)))
            }
        };
        let corners =
            tool.meridian().filter(|m| !m.cutter_is_convex()).map(Meridian::cutter_corners).unwrap_or_default();
        let near = StructuringElement::cuboid([2 * NEAR + 1; 3], spacing)?;
        let near_free = dilate(&hit.complement(), &near)?.set.placed([NEAR as isize; 3], *hit.grid())?;
        let thin = tool.meridian().map(|m| m.thinner(m.slack()));
        Ok(Station { tool, frame: setup.frame, turn, posed, corners, thin, hit, near_free })
    }

    /// The same station with more in the way.
    ///
    /// # Errors
    /// [`crate::Error::Operand`] if the grids differ.
    pub fn with_more(&self, hit: &Indicator) -> Result<Self> {
        let (hit, near_free) = (self.hit.union(hit)?, self.near_free.clone());
        let (posed, corners, thin) = (self.posed.clone(), self.corners.clone(), self.thin.clone());
        Ok(Station { hit, near_free, posed, corners, thin, ..*self })
    }

    /// Tips, on the grid of [`Station::hit`], at which the tool overlaps cubes of a set in its setup.
    ///
    /// # Errors
    /// As [`Descent::met_by`].
    pub fn hits_of(&self, set: &Indicator) -> Result<Indicator> {
        match (&self.tool.body, &self.posed) {
            (Body::Coaxial(m), _) => Ok(Stack::overlapping(m, set.grid().spacing()).dilate(set, Sense::Obstacle)),
            (Body::Solid(_), Some(posed)) => Descent::new(set).met_by(&posed.touched),
            (Body::Solid(_), None) => {
                Err(Error::Internal { problem: "a tool that is not coaxial has no shape".into() })
            }
        }
    }

    /// Tips, within some boxes of the first setup's frame, at which a tool that is not coaxial overlaps the cubes of a set wherever
    /// in their cells they stand; none for a coaxial one.
    ///
    /// # Errors
    /// As [`Descent::met_within`].
    pub fn surely_hits_of(&self, set: &Descent, boxes: &[[Vec3; 2]]) -> Result<Option<Indicator>> {
        self.posed.as_ref().map(|posed| set.met_within(&posed.full, boxes)).transpose()
    }

    /// Tips at which the tool is not known to be free.
    pub fn hit(&self) -> &Indicator {
        &self.hit
    }

    /// Rows of the matrix from the frame of the part to that of the station.
    pub(super) fn frame(&self) -> &Rotation {
        &self.frame
    }

    /// A coaxial tool, thinner by its slack.
    pub(super) fn thin(&self) -> Option<&Meridian> {
        self.thin.as_ref()
    }

    /// The tool.
    pub fn tool(&self) -> &'a Tool {
        self.tool
    }

    /// The axis of the tool, from the tip to the hand, in the frame of the part.
    pub fn axis(&self) -> Vec3 {
        let up = [0, 1, 2].map(|r| self.turn[r][2]);
        transposed(self.frame).map(|row| dot(row, up))
    }

    /// A free pose whose cutter comes within `stand_off` of the middle of a patch, from touching it, with nothing of the part
    /// in between.
    ///
    /// # Cost
    /// A few dozen samples, and one ray.
    pub fn stand(&self, patch: &Patch, stand_off: f64, view: &MeshDistance) -> Option<Stand> {
        let normal = self.frame.map(|r| dot(r, patch.normal));
        let axis = [0, 1, 2].map(|r| self.turn[r][2]);
        let both = add(normal, axis);
        let away = if norm(both) > 0.1 { unit(both) } else { normal };
        let tries: Vec<_> = self.contacts(normal).into_iter().map(|c| (c, [normal, away, axis])).collect();
        self.search(patch, stand_off, view, &tries)
    }

    /// As [`Station::stand`], from anywhere beside the middle of the patch: what is to be cut or gripped there need not be
    /// touched square to the surface.
    ///
    /// # Cost
    /// A few hundred samples, and one ray.
    pub fn beside(&self, patch: &Patch, stand_off: f64, view: &MeshDistance) -> Option<Stand> {
        let normal = self.frame.map(|r| dot(r, patch.normal));
        let axis = [0, 1, 2].map(|r| self.turn[r][2]);
        let Some(m) = self.tool.meridian() else { return self.stand(patch, stand_off, view) };
        let mut tries = vec![([0.0; 3], [normal, axis, unit(add(normal, scale(axis, 0.99)))])];
        let deep = m.cutter_length().min(REACHED_ALONG);
        for height in [0.0, 0.25 * deep, 0.5 * deep] {
            let radius = m.largest_within(height - 1e-6, height + 1e-6).unwrap_or(0.0);
            for turn in (0..8).map(|n| TAU * f64::from(n) / 8.0) {
                let outwards = [turn.cos(), turn.sin(), 0.0];
                let contact = along([0.0, 0.0, height], outwards, radius);
                let inwards = outwards.map(|x| -x);
                tries.push((
                    contact,
                    [normal, unit(add(normal, scale(inwards, 0.99))), unit(add(inwards, scale(axis, 0.5)))],
                ));
            }
        }
        self.search(patch, stand_off, view, &tries)
    }

    /// The first free pose, step by step away from touching, for any of some points of the cutter and ways to retreat.
    fn search(&self, patch: &Patch, stand_off: f64, view: &MeshDistance, tries: &[(Vec3, [Vec3; 3])]) -> Option<Stand> {
        let (at, normal) = (self.frame.map(|r| dot(r, patch.at)), self.frame.map(|r| dot(r, patch.normal)));
        let grid = self.hit.grid();
        let h = grid.h();
        let touching =
            tries.iter().map(|(contact, retreats)| (grid.continuous_index(sub(at, *contact)), contact, retreats));
        let tries: Vec<_> = touching.filter(|(tip, ..)| self.may_be_free_near(*tip, stand_off)).collect();
        if tries.is_empty() {
            return None;
        }
        // Nearer than a spacing a tool is hardly ever free of the cubes that the surface touches.
        for s in 2..=(stand_off / (0.5 * h)) as usize {
            for (touches, contact, retreats) in &tries {
                for &retreat in *retreats {
                    let wanted = along(*touches, retreat, 0.5 * s as f64);
                    let Some(index) = grid.sample_of(wanted).filter(|&i| !self.hit.contains(i)) else { continue };
                    let tip = grid.position(index);
                    let touching = add(tip, **contact);
                    let apart = distance(touching, at);
                    if apart <= stand_off && dot(sub(touching, at), normal) > 0.0 {
                        let back = transposed(self.frame);
                        let [tip, touching] = [tip, touching].map(|p| back.map(|row| dot(row, p)));
                        let line = scale(sub(touching, patch.at), 1.0 / apart);
                        if view.first_hit(patch.at, line, 1e-3 * h, apart).is_none() {
                            return Some(Stand { distance: apart, tip });
                        }
                    }
                }
            }
        }
        None
    }

    /// Whether any sample within `stand_off` of a tip, given by its continuous index, may be free.
    fn may_be_free_near(&self, tip: Vec3, stand_off: f64) -> bool {
        let grid = self.hit.grid();
        // A point that far away rounds to a sample no more than so many further on.
        let known = stand_off <= (NEAR as f64 - 0.5) * grid.h();
        !known || grid.sample_of(tip).is_none_or(|i| self.near_free.contains(i))
    }

    /// How far along its axis the tool has to be drawn back from touching a patch until it is free, if that is less than `below`,
    /// and the tip that would touch.
    ///
    /// A flat end touches what it lies on with any of its points: of all tips of the grid at which it covers the middle of the patch, the
    /// one that is drawn back least, of equals the nearest to it. Any other tool is drawn back from the poses in which the points that
    /// touch such a plane lie there. `rise` is that of the station, which tells it faster for a coaxial tool.
    pub(super) fn retreat(&self, patch: &Patch, below: f64, rise: Option<&Rise>) -> Option<(f64, Vec3)> {
        let normal = self.frame.map(|r| dot(r, patch.normal));
        match self.tool.flat_end().filter(|_| lies_flat(normal)) {
            Some(end) => self.retreat_of_end(patch, end, below),
            None => self.retreat_from(patch, (&self.contacts(normal), &[[0.0; 3]]), below, rise),
        }
    }

    /// How far the tool is from touching a patch where it is free, moved aside and drawn back along its axis from there: as far as its way back and
    /// aside is long, if that is less than `below`, and the tip that would touch. It is moved off the patch, where that is a wall, by up to [`NEAR`] samples, since along it the
    /// cubes that it touches are never free; and off the walls `beside` it by as much as the tool is wide. A flat end on a level patch is moved about
    /// by [`Station::retreat`].
    pub(super) fn off_beside(
        &self,
        patch: &Patch,
        beside: &[Vec3],
        below: f64,
        rise: Option<&Rise>,
    ) -> Option<(f64, Vec3)> {
        let normal = self.frame.map(|r| dot(r, patch.normal));
        let axis = [0, 1, 2].map(|r| self.turn[r][2]);
        if self.tool.flat_end().is_some() && lies_flat(normal) {
            return None;
        }
        // What lies within 30° of square to the axis is no wall.
        let across = |n: Vec3| Some(along(n, axis, -dot(n, axis))).filter(|d| norm(*d) > 0.5).map(unit);
        let off = (1..=NEAR).filter_map(|n| across(normal).map(|d| scale(d, n as f64)));
        let wide = self.tool.meridian()?.cutter_radius() / self.hit.grid().h() + 2.0;
        let walls = beside.iter().filter_map(|n| across(self.frame.map(|r| dot(r, *n))));
        let poses: Vec<Vec3> = off.chain(walls.map(|d| scale(d, wide))).collect();
        self.retreat_from(patch, (&self.contacts(normal), &poses), below, rise)
    }

    /// How far along its axis the tool has to be drawn back from standing with the tip in the patch until it is free, and that tip.
    pub fn retreat_of_tip(&self, patch: &Patch) -> Option<(f64, Vec3)> {
        self.retreat_from(patch, (&[[0.0; 3]], &[[0.0; 3]]), f64::INFINITY, None)
    }

    /// How far up it is free for a coaxial tool.
    pub(super) fn rise(&self) -> Option<Rise> {
        self.tool.meridian().map(|_| Rise::over(&self.hit))
    }

    fn retreat_of_end(&self, patch: &Patch, end: Support, below: f64) -> Option<(f64, Vec3)> {
        let grid = self.hit.grid();
        let middle = sub(self.frame.map(|r| dot(r, patch.at)), [0.0, 0.0, end.height]);
        let (at, layers) = (grid.continuous_index(middle)[2], grid.dims()[2]);
        let short = |layer: f64| ((layer - at) * grid.h()).max(0.0);
        let covering = Covering::of(grid, middle, end.flat);
        let back = transposed(self.frame);
        let steps = ((at - 1e-9).ceil().max(0.0) as usize..layers).take_while(|&k| short(k as f64) < below);
        let found = steps.into_iter().find(|&k| covering.any_clear(&self.hit, k));
        let (by, tip) = match found.and_then(|k| covering.nearest_clear(&self.hit, k)) {
            Some(index) => {
                let [x, y, _] = grid.position(index);
                (short(index[2] as f64), [x, y, middle[2]])
            }
            // Above the grid nothing is in the way.
            None => (short(layers as f64 - 0.5), middle),
        };
        (by < below).then(|| (by, back.map(|row| dot(row, tip))))
    }

    fn retreat_from(
        &self,
        patch: &Patch,
        (contacts, steps_aside): (&[Vec3], &[Vec3]),
        below: f64,
        rise: Option<&Rise>,
    ) -> Option<(f64, Vec3)> {
        let at = self.frame.map(|r| dot(r, patch.at));
        let axis = [0, 1, 2].map(|r| self.turn[r][2]);
        let grid = self.hit.grid();
        let longest = grid.dims().into_iter().max().unwrap_or(0);
        let above = grid.dims()[2] as f64 - 0.5;
        // Both in samples: one step is one spacing.
        let free = |tip: Vec3| match grid.sample_of(tip) {
            Some(index) => !self.hit.contains(index),
            // Above the grid nothing is in the way of a coaxial tool; beside it and below nothing is known. The grid of any
            // other holds all tips at which it can meet the part.
            None => self.tool.meridian().is_none() || tip[2] >= above,
        };
        let poses = steps_aside.iter().flat_map(|aside| contacts.iter().map(move |contact| (contact, aside)));
        let nearer = |best: Option<(f64, Vec3)>, (contact, aside): (&Vec3, &Vec3)| {
            let (tip, below) = (sub(at, *contact), best.map_or(below, |b| b.0));
            let touches = add(grid.continuous_index(tip), *aside);
            let far = |s: usize| grid.h() * (s as f64).hypot(norm(*aside));
            let is_nearer = |s: &usize| *s <= longest && far(*s) < below;
            let found = match rise {
                Some(rise) => Some(rise.from(touches)).filter(is_nearer),
                None => (0..=longest).take_while(is_nearer).find(|&s| free(along(touches, axis, s as f64))),
            };
            found.map(|s| (far(s), tip)).or(best)
        };
        let found = poses.fold(None, nearer);
        let back = transposed(self.frame);
        found.map(|(s, tip)| (s, back.map(|row| dot(row, tip))))
    }

    /// Points of the cutter, from the tip, by which it may touch a plane of this normal.
    pub(super) fn contacts(&self, normal: Vec3) -> Vec<Vec3> {
        match &self.tool.body {
            Body::Solid(_) => {
                let turned = |p: Vec3| self.turn.map(|row| dot(row, p));
                self.tool.sharp.iter().map(|s| turned(s.at_mm)).collect()
            }
            Body::Coaxial(m) => coaxial_contacts(m, self.tool, &self.corners, normal),
        }
    }
}

/// Points of a coaxial cutter by which it touches a plane; the named ones only, where points are named.
fn coaxial_contacts(m: &Meridian, tool: &Tool, corners: &[[f64; 2]], normal: Vec3) -> Vec<Vec3> {
    let [level, rise] = level_and_rise(normal);
    let outwards = if level > 0.0 { [-normal[0] / level, -normal[1] / level] } else { [1.0, 0.0] };
    let ring = |r: f64, z: f64| [outwards[0] * r, outwards[1] * r, z];
    if !tool.sharp.is_empty() {
        return tool.sharp.iter().map(|s| ring(s.at_mm[0].hypot(s.at_mm[1]), s.at_mm[2])).collect();
    }
    let Some(s) = m.support(level, rise) else { return Vec::new() };
    let mut list = vec![ring(s.radius, s.height)];
    if s.flat > 0.0 {
        list.push([0.0, 0.0, s.height]);
        list.extend((1..8).map(|n| {
            let turn = TAU * f64::from(n) / 8.0;
            [s.flat * turn.cos(), s.flat * turn.sin(), s.height]
        }));
    }
    if s.flank > s.height && !m.widens_upwards() {
        list.push(ring(s.radius, s.flank));
        list.push(ring(s.radius, 0.5 * (s.height + s.flank)));
    }
    list.extend(corners.iter().map(|&[r, z]| ring(r, z)));
    list
}

/// Tips at which a coaxial tool is not known to be free, or not known to get out from.
fn coaxial_hits(m: &Meridian, setup: &Setup) -> Indicator {
    let spacing = setup.grid().spacing();
    if m.widens_upwards() {
        return Stack::overlapping(m, spacing).dilate(&setup.outer, Sense::Obstacle);
    }
    let layers = setup.grid().dims()[2];
    let hit = Stack::possibly(m, spacing, layers, |_| 0.0).dilate(&setup.outer, Sense::Obstacle);
    let free = components(&hit.complement(), Adjacency::Face);
    let outside = free.at_border();
    free.select(|c| outside[c as usize]).complement()
}

#[cfg(test)]
mod tests {
    use super::super::pose::super_fibonacci;
    use super::super::tool::SharpPoint;
    use super::*;
    use crate::geometry::{InsideRule, Primitive, TriangleMesh};
    use crate::units::Length;

    /// A pocketed block and the stations of a pin, a disc on a shaft and a tool without symmetry in two of its setups.
    fn with_stations(check: impl Fn(&Station, &[Patch], &MeshDistance)) {
        let block = |size: &str, at: Vec3| {
            let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            Primitive::parse(size).unwrap().mesh(Length::mm(1.0)).transformed(still, at)
        };
        let mut pocket = block("box:4x3x6mm", [0.5, 0.0, 2.5]);
        pocket.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let mesh = block("box:10x9x8mm", [0.0; 3]).joined(&pocket);
        let piece =
            |role: &str, d: f64, l: f64| format!("[[piece]]\nrole = \"{role}\"\ndiameter_mm = {d}\nlength_mm = {l}\n");
        let coaxial = |text: String| Tool::from_toml("t", &text, |_| Ok(TriangleMesh::default())).unwrap();
        let hook = block("box:1x2x6mm", [0.0, 0.5, 3.0]);
        let tools = [
            coaxial(piece("cutter", 1.5, 4.0) + &piece("holder", 6.0, 10.0)),
            coaxial(piece("cutter", 4.0, 1.0) + &piece("neck", 1.0, 9.0)),
            Tool::from_mesh("hook", hook, vec![SharpPoint { name: "end".into(), at_mm: [0.5, 1.5, 0.0] }]).unwrap(),
        ];
        let cast = |d: Vec3| Setup::cast(&mesh, InsideRule::Winding, d, Length::mm(0.5), Length::mm(3.0)).unwrap();
        let setups = [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]].map(cast);
        let (surface, view) = (super::super::surface::patches(&mesh, 1.6, |_| true), MeshDistance::new(&mesh));
        for (tool, setup) in tools.iter().flat_map(|t| setups.iter().map(move |s| (t, s))) {
            Station::all(tool, &setups[0], setup).for_each(|s| check(&s.unwrap(), &surface, &view));
        }
    }

    #[test]
    fn what_is_passed_over_is_nowhere_free() {
        with_stations(|station, surface, view| {
            let all = Indicator::empty(*station.hit.grid()).complement();
            let plain = Station {
                hit: station.hit.clone(),
                near_free: all,
                posed: None,
                corners: Vec::new(),
                thin: None,
                ..*station
            };
            let (grid, mut found) = (station.hit.grid(), [0; 2]);
            for patch in surface {
                let stand_off = 2.0 * 3f64.sqrt() * grid.h();
                let want = plain.stand(patch, stand_off, view);
                assert_eq!(station.stand(patch, stand_off, view), want);
                assert_eq!(station.beside(patch, stand_off, view), plain.beside(patch, stand_off, view));
                found[usize::from(want.is_some())] += 1;
            }
            assert!(found.iter().all(|&n| n > 20), "{found:?}");
        });
    }

    #[test]
    fn a_tool_is_drawn_back_to_the_first_free_sample() {
        with_stations(|station, surface, _| {
            let grid = station.hit.grid();
            let axis = station.turn.map(|row| row[2]);
            let rise = station.rise();
            for patch in surface {
                let at = station.frame.map(|r| dot(r, patch.at));
                let normal = station.frame.map(|r| dot(r, patch.normal));
                let contacts = station.contacts(normal);
                let free = |p: Vec3| match grid.sample_at(p) {
                    Some(index) => !station.hit.contains(index),
                    None => station.tool.meridian().is_none() || p[2] >= grid.position([0, 0, grid.dims()[2] - 1])[2],
                };
                for beside in [vec![[0.0; 3]], vec![[0.0; 3], [2.0, 1.0, 0.0], [0.0, -3.5, 0.0]]] {
                    let poses = contacts.iter().flat_map(|c| beside.iter().map(move |aside| (c, aside)));
                    let ways = poses.filter_map(|(&c, &aside)| {
                        let from = along(sub(at, c), aside, grid.h());
                        let s = (0..99).find(|&s| free(along(from, axis, grid.h() * f64::from(s))))?;
                        Some(grid.h() * f64::from(s).hypot(norm(aside)))
                    });
                    let want = ways.min_by(f64::total_cmp);
                    let found = station.retreat_from(patch, (&contacts, &beside), f64::INFINITY, None);
                    let poses = (&contacts[..], &beside[..]);
                    assert_eq!(station.retreat_from(patch, poses, f64::INFINITY, rise.as_ref()), found);
                    let found = found.map(|(by, _)| by);
                    let close = found.zip(want).is_none_or(|(f, w)| (f - w).abs() < 1e-9);
                    assert!(want.is_none_or(|w| w > grid.h() * 20.0) || close, "{found:?} {want:?}");
                }
            }
        });
    }

    #[test]
    fn a_tool_of_any_shape_stands_at_the_rotation_that_is_asked_for() {
        let mesh = Primitive::parse("box:6mm").unwrap().mesh(Length::mm(1.0));
        let cast =
            |d: Vec3| Setup::cast(&mesh, InsideRule::Crossings, d, Length::mm(1.0), Length::mm(2.0)).expect("a cast");
        let first = cast([1.0, 0.0, 0.0]);
        let tip = vec![SharpPoint { name: "tip".into(), at_mm: [0.0, 0.0, -3.0] }];
        let tool = Tool::from_mesh("block", mesh.clone(), tip).unwrap();
        for rotation in super_fibonacci(6) {
            let mut setup = cast([0, 1, 2].map(|r| rotation[r][2]));
            setup.turns = Turns::At(rotation);
            let stations: Vec<Station> = Station::all(&tool, &first, &setup).map(Result::unwrap).collect();
            assert_eq!(stations.len(), setup.turns.count());
            assert!(distance(stations[0].axis(), setup.direction) < 1e-9);
            // From the tool's frame to the station's and on to the part's.
            let back = product(transposed(first.frame), stations[0].turn);
            assert!((0..3).all(|r| distance(back[r], rotation[r]) < 1e-9), "{back:?} {rotation:?}");
        }
    }

    #[test]
    fn reach_is_the_same_from_coarse_to_fine_and_with_every_sample_asked() {
        let solid =
            |text: &str, at: Vec3| Primitive::parse(text).unwrap().mesh(Length::mm(0.5)).transformed(IDENTITY, at);
        // Two walls on a plate; a tool with a hook on one side only.
        let part =
            [("box:14x6x2mm", [0.0, 0.0, -4.0]), ("box:3x6x8mm", [5.5, 0.0, 0.0]), ("box:3x2x8mm", [-5.5, 0.0, 0.0])];
        let mesh = part.into_iter().fold(TriangleMesh::default(), |all, (text, at)| all.joined(&solid(text, at)));
        let hook = solid("box:1.5x2x9mm", [0.0, 0.0, 4.5]).joined(&solid("box:3x1x1.5mm", [2.0, 0.2, 1.0]));
        let tip = vec![SharpPoint { name: "tip".into(), at_mm: [3.5, 0.0, 1.0] }];
        let tool = Tool::from_mesh("hook", hook, tip).unwrap();
        let view = MeshDistance::new(&mesh);
        let h = Length::mm(0.6);
        let setup = Setup::cast(&mesh, InsideRule::Winding, [0.0, 0.0, 1.0], h, Length::mm(2.0)).unwrap();
        let list = super::super::surface::patches(&mesh, 1.5, |_| true);
        let (mut stands, mut blocked) = (0, 0);
        for rotation in super_fibonacci(5) {
            let station = Station::new(&tool, &setup, Some(rotation)).unwrap();
            let touched = station.posed.as_ref().unwrap().touched.clone();
            let grid = *station.hit.grid();
            let all = Indicator::from_predicate(grid, |at| {
                let tip = grid.position(grid.index(at));
                let meets = |b: usize| {
                    let p = touched.grid().position(touched.grid().index(b));
                    setup
                        .outer
                        .grid()
                        .sample_at([0, 1, 2].map(|a| p[a] + tip[a]))
                        .is_some_and(|i| setup.outer.contains(i))
                };
                touched.iter().any(meets)
            });
            assert_eq!(station.hit, all);
            let plain = Station {
                hit: all,
                near_free: station.near_free.clone(),
                posed: station.posed.clone(),
                corners: vec![],
                thin: None,
                ..station
            };
            for patch in &list {
                let stand = station.stand(patch, 1.0, &view);
                assert_eq!(stand, plain.stand(patch, 1.0, &view));
                if stand.is_some() { stands += 1 } else { blocked += 1 }
            }
        }
        assert!(stands > 20 && blocked > 20, "{stands} {blocked}");
    }
}

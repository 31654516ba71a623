//! AM601: concave edges sharper than the fillet that the process asks for.

use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::fillet::{Fillets, Laid};
use super::finding::{Basis, Bracket, Finding, Spot, Witness};
use super::notch::{CODE, NAMED, Notches, RELIEF, rounded, sharp_bend};
use super::place::{locate, reported};
use super::small_round::Rounds;
use super::step::{Stretch, higher_than};
use crate::error::Result;
use crate::geometry::vector::bounds;
use crate::medial::reflex::{ReflexEdge, joined, reflex_edges};
use crate::part::Part;
use crate::process::Process;
use crate::units::{report_digits, short};
use rayon::prelude::*;

/// AM601 `blend`.
pub struct Blend;

/// An edge bent by less belongs to no round, radians (0.2°): a quarter of a circle in 450 facets.
const FLAT: f64 = 0.2 * std::f64::consts::PI / 180.0;

static META: Meta = Meta {
    code: CODE,
    name: "blend",
    title: "Concave edges sharper than the fillet radius",
    what: "Finds edges where two faces meet towards the void without a fillet, or with one of a smaller radius than asked, and \
           gives their length and the radius that is there.",
    why: "A sharp inner edge gathers stress and heat: it is where a part cracks in use, and in sintered and welded processes \
          while it is made.",
    how: "A ball of the asked radius that rolls in an edge bent by φ stays r·(1/cos(φ/2) − 1) away from its bottom; an edge it \
          misses by more than a tenth of its radius (bent by more than 49°) is sharp, its radius 0, exactly. A step ends where \
          the profile across the edge, followed from facet to facet, has turned away from the void as far as the edge turns \
          towards it; an edge is judged piece by piece, from one change of its profile to the next. Shallower edges side by \
          side are the facets of a round: its radius is that of the largest ball that touches them, at most that of the circle \
          whose chords they are, measured at its corners and not where an edge divides a facet. What the ball that is asked comes to rest over together with a sharp edge is one corner and told with that. It is told where it turns by \
          more than 49° and the asked ball stays a hundredth of its radius away. The fillet that is suggested has been laid in \
          along every edge: the ball rests on both faces and meets nothing else, so that it fills no slot or hole narrower than \
          itself; where it does not, a smaller one is sought.",
    limits: "Steps lower than five radii are relief and are not judged, nor are sharp edges shorter than a radius and rounds shorter than five. Grooves and holes that \
             turn by more than 150 degrees, and rounds in a gap that the ball does not fit into, are left to narrow-gap and small-hole. Edges between bodies that \
             only touch are not seen. What fillets add counts twice where more than two of their edges meet. The radius of a round is an estimate. One that may be as large as asked, where its facets are chords, is told only where the \
             ball misses it by a tenth; at 90 degrees, one less than 3 percent too small is not told. A process asks for one only where a published guide does; \
             else it is yours to ask.",
    source: "Rolling-ball blends as closings: J. R. Rossignac, A. A. G. Requicha, Offsetting operations in solid modelling, 1986. \
             Limits: see the profile.",
};

impl Check for Blend {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let Some(limits) = limits_of(process, "blend") else {
            let why = "the process asks for no radius of inner edges; `--limit blend=0.4mm` does";
            return Ok(Outcome::NotApplicable(why.into()));
        };
        let radius = limits.fail.unwrap_or(0.0).max(limits.warn.unwrap_or(0.0));
        // What is no relief by either limit violates that one.
        let least = limits.fail.into_iter().chain(limits.warn).fold(radius, f64::min);
        let edges = reflex_edges(part.mesh(), FLAT, |f| part.bounds_solid(f));
        let sharp_bend = sharp_bend();
        let (sharp, shallow): (Vec<ReflexEdge>, Vec<ReflexEdge>) = edges.iter().partition(|e| e.bend > sharp_bend);
        let all_sharp = sharp.len();
        let notches = Notches { part, context, limits, radius, least };
        let chains = notches.chains(&sharp);
        let rounds = Rounds::of(notches, &sharp_of(&chains)).smaller(&shallow);
        let mut measured = Measured {
            cover: format!(
                "All {} concave edges were looked at, {all_sharp} of them bent by more than {:.0}°; {} of these were left out as relief, at \
                 steps lower than {} mm or shorter than {} mm in all.",
                edges.len(),
                sharp_bend.to_degrees(),
                all_sharp - kept(&chains),
                short(RELIEF * least),
                short(least)
            ),
            rule: Some("blend"),
            ..Measured::default()
        };
        measured.findings.extend(notches.of_edges(&chains));
        measured.findings.extend(rounds);
        measured.worst = measured.findings.iter().min_by(|a, b| a.value.total_cmp(&b.value)).map(|f| Worst {
            bracket: Bracket { value: f.value, low: f.low, high: f.high },
            unit: "mm",
            at: Some(part.to_build(f.at_mm)),
        });
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// Sharp edges end to end.
struct Chain {
    stretches: Vec<Stretch>,
    length: f64,
}

impl Chain {
    fn longest(&self) -> Option<&Stretch> {
        self.stretches.iter().max_by(|a, b| a.edge.length.total_cmp(&b.edge.length))
    }
}

impl Notches<'_> {
    /// The sharp edges where they are no relief, joined where they share a vertex, longest first.
    fn chains(&self, sharp: &[ReflexEdge]) -> Vec<Chain> {
        let lower = RELIEF * self.least * (1.0 - 1e-9);
        let high: Vec<Stretch> = sharp.par_iter().flat_map_iter(|e| higher_than(self.part, e, lower)).collect();
        let mut chains: Vec<Chain> = joined(&high, |s| s.vertices.into_iter().flatten().collect())
            .into_iter()
            .map(|members| {
                let stretches: Vec<Stretch> = members.into_iter().map(|i| high[i]).collect();
                Chain { length: stretches.iter().map(|s| s.edge.length).sum(), stretches }
            })
            .filter(|c| c.length >= self.least)
            .collect();
        chains.sort_by(|a, b| b.length.total_cmp(&a.length));
        chains
    }

    /// All sharp edges as one finding.
    fn of_edges(&self, chains: &[Chain]) -> Option<Finding> {
        let longest = chains.first()?;
        let lead = longest.longest()?;
        let mut f =
            Finding::judged(CODE, "edge", Bracket::exact(0.0), Basis::Exact, self.limits, "mm", self.part.tie());
        let extent = bounds(chains.iter().flat_map(|c| &c.stretches).flat_map(|s| s.ends))?;
        locate(&mut f, self.part, self.context, lead.edge.middle, extent);
        f.count = chains.len() as u64;
        f.places = chains
            .iter()
            .take(NAMED)
            .filter_map(Chain::longest)
            .map(|s| Spot { at_mm: reported(self.part, s.edge.middle), box_mm: None, value: 0.0, low: 0.0, high: 0.0 })
            .collect();
        let ends = lead.ends.map(|p| reported(self.part, p));
        f.witness = Some(Witness { kind: "edge".into(), points_mm: ends.to_vec() });
        let all: f64 = chains.iter().map(|c| c.length).sum();
        let edges = sharp_of(chains);
        let laid = Fillets(self.part).lay(&edges, self.radius);
        let noun =
            if chains.len() == 1 { "concave edge is".into() } else { format!("{} concave edges are", chains.len()) };
        f.message = format!("{noun} sharp, {} mm in all, the longest {} mm", rounded(all), rounded(longest.length));
        f.volume_mm3 = Some(report_digits(laid.volume));
        f.fix = self.advised(&laid, all);
        Some(f)
    }

    /// What trying fillets in edges of so many millimetres has shown.
    fn advised(&self, laid: &Laid, all: f64) -> String {
        let (r, volume) = (short(self.radius), rounded(laid.volume));
        let smaller = match laid.elsewhere {
            0.0 => "not even a tenth of it fits everywhere".to_string(),
            most => format!("{} mm fits", rounded(most)),
        };
        match laid.fitting {
            _ if laid.everywhere => {
                format!(
                    "round with a radius of {r} mm: it fits everywhere, checked on the surface, and adds {volume} mm³"
                )
            }
            0.0 => format!("nowhere is there room for a radius of {r} mm, checked on the surface: {smaller}"),
            fitting => {
                let [some, whole] = [fitting, all].map(|mm| short((10.0 * mm).round() / 10.0));
                let along = match some == whole {
                    true => format!("all but less than 0.1 mm of {whole} mm"),
                    // Rounded down: what fits along nearly all does not fit along all.
                    false => format!("{} of {whole} mm", short((10.0 * fitting).floor() / 10.0)),
                };
                format!(
                    "round with a radius of {r} mm: checked on the surface, it fits along {along} and adds {volume} mm³; elsewhere {smaller}"
                )
            }
        }
    }
}

/// What is left of the sharp edges, piece by piece.
fn sharp_of(chains: &[Chain]) -> Vec<ReflexEdge> {
    chains.iter().flat_map(|c| &c.stretches).map(|s| s.edge).collect()
}

/// How many edges all of which, or some, are in chains.
fn kept(chains: &[Chain]) -> usize {
    let ends = chains.iter().flat_map(|c| &c.stretches).map(|s| s.edge.ends);
    ends.collect::<std::collections::BTreeSet<_>>().len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::finding::State;
    use crate::geometry::TriangleMesh;
    use crate::part::Up;

    /// A bracket of 20 × 20 mm, 4 mm thick, 30 mm deep, with a fillet of a radius in so many facets, turned and moved.
    fn bracket(fillet: f64, facets: usize, degrees: f64) -> Part {
        let mut outline = vec![[0.0, 0.0], [20.0, 0.0], [20.0, 4.0]];
        for i in 0..=facets {
            let a = std::f64::consts::FRAC_PI_2 * i as f64 / facets.max(1) as f64;
            // From the foot of the arc to its top; a radius of 0 leaves the corner.
            let at = [4.0 + fillet * (1.0 - a.sin()), 4.0 + fillet * (1.0 - a.cos())];
            if fillet > 0.0 || i == 0 {
                outline.push(at);
            }
        }
        outline.extend([[4.0, 20.0], [0.0, 20.0]]);
        let n = outline.len();
        let at = |i: usize, y: f64| [outline[i % n][0], y, outline[i % n][1]];
        let mut triangles = Vec::new();
        for i in 0..n {
            triangles.push([at(i, 0.0), at(i + 1, 30.0), at(i + 1, 0.0)]);
            triangles.push([at(i, 0.0), at(i, 30.0), at(i + 1, 30.0)]);
        }
        // The outline is a star about its outer corner.
        for i in 1..n - 1 {
            triangles.push([at(0, 0.0), at(i, 0.0), at(i + 1, 0.0)]);
            triangles.push([at(0, 30.0), at(i + 1, 30.0), at(i, 30.0)]);
        }
        let mesh = TriangleMesh::weld(triangles);
        let mesh = if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh };
        let (s, c) = degrees.to_radians().sin_cos();
        let turned = mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [3.7, -1.3, 0.4]);
        Part::new(turned, Up::PlusZ, 1e-6, 1.0).unwrap()
    }

    fn judge(part: &Part, limit: &str) -> Measured {
        let mut process = Process::named("fdm").unwrap();
        process.override_limit(&format!("blend={limit}")).unwrap();
        match Blend.run(part, &process, &Context { refine: 1_000_000, spacing_mm: 0.2 }).unwrap() {
            Outcome::Measured(m) => *m,
            Outcome::NotApplicable(why) => panic!("{why}"),
        }
    }

    #[test]
    fn a_sharp_notch_is_found_with_its_length_and_the_fillet_that_fits() {
        for degrees in [0.0, 17.0, 45.0, 90.0] {
            let found = judge(&bracket(0.0, 0, degrees), "0.5mm").findings;
            assert_eq!((found.len(), found[0].count, found[0].kind.as_str()), (1, 1, "edge"));
            assert_eq!((found[0].value, found[0].high), (0.0, 0.0));
            assert!(found[0].message.contains("30 mm in all"), "{}", found[0].message);
            // 30 mm of r²·(1 − π/4).
            let filled = 30.0 * 0.25 * (1.0 - std::f64::consts::FRAC_PI_4);
            assert!((found[0].volume_mm3.unwrap() - filled).abs() < 1e-5 && found[0].fix.contains("fits everywhere"));
        }
    }

    #[test]
    fn a_fillet_of_few_facets_is_no_larger_than_the_circle_of_its_chords() {
        // A ball of 0.2512 mm touches both walls and both chords of a fillet of 0.2 mm in two.
        for degrees in [0.0, 31.0] {
            for facets in [2, 3, 4, 8] {
                let found = judge(&bracket(0.2, facets, degrees), "0.3mm").findings;
                assert_eq!((found.len(), found[0].kind.as_str()), (1, "round"), "{facets}: {found:?}");
                assert!((found[0].value - 0.2).abs() < 0.004 && found[0].low <= found[0].value, "{facets}: {found:?}");
            }
        }
    }

    #[test]
    fn a_corner_with_a_chamfer_that_is_sharp_at_one_wall_alone_is_told_once() {
        // A chamfer of 0.1 × 0.058 mm between two walls of 16 mm: bent by 60° at one and by 30° at the other.
        for [a, b] in [[0.1, 0.058], [0.058, 0.1]] {
            let outline =
                [[0.0, 0.0], [20.0, 0.0], [20.0, 4.0], [4.0 + a, 4.0], [4.0, 4.0 + b], [4.0, 20.0], [0.0, 20.0]];
            let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6]];
            let part = Part::new(crate::geometry::extruded(&outline, &caps, 20.0), Up::PlusZ, 1e-6, 1.0).unwrap();
            let found = judge(&part, "0.3mm").findings;
            let [f] = &found[..] else { panic!("{a} {b}: {found:?}") };
            assert!(
                f.kind == "edge" && f.fix.starts_with("round with a radius of 0.3 mm: it fits everywhere"),
                "{f:?}"
            );
        }
    }

    #[test]
    fn a_fillet_passes_from_its_radius_on_and_is_measured_below() {
        for degrees in [0.0, 31.0] {
            for facets in [6, 12, 24] {
                let part = bracket(1.0, facets, degrees);
                assert!(judge(&part, "0.9mm").findings.is_empty());
                assert!(judge(&part, "1mm").findings.is_empty());
                let found = judge(&part, "2mm").findings;
                assert_eq!((found.len(), found[0].kind.as_str()), (1, "round"), "{facets}: {found:?}");
                // The chords of an inscribed arc lie within a sagitta of it: 1 − cos(π/4n), twice for the end facets.
                let slack = 2.0 * (1.0 - (std::f64::consts::FRAC_PI_4 / facets as f64).cos());
                // The ball may miss by a hundredth of its radius: (1/cos 45° − 1)/(1/cos 45° − 1.01), and is halved in to 0.02 mm.
                assert!((found[0].value - 1.0).abs() <= slack + 0.025 + 0.02, "{facets}: {}", found[0].value);
            }
        }
    }

    /// A bar whose upper side is a valley of so many degrees with a fillet of a radius in so many facets, 30 mm deep, its sides 12 mm long.
    fn valley(degrees: f64, fillet: f64, facets: usize) -> Part {
        let half = 0.5 * degrees.to_radians();
        let turn = std::f64::consts::PI - 2.0 * half;
        let (top, middle) = ([12.0 * half.sin(), 12.0 * half.cos()], fillet / half.sin());
        let arc = (0..=facets.max(1)).map(|i| turn * (i as f64 / facets.max(1) as f64 - 0.5));
        let arc: Vec<[f64; 2]> = match facets {
            0 => vec![[0.0; 2]],
            _ => arc.map(|a| [fillet * a.sin(), middle - fillet * a.cos()]).collect(),
        };
        let (low, high) = ([top[0], -4.0], [-top[0], -4.0]);
        let outline: Vec<[f64; 2]> =
            [high, low, top].into_iter().chain(arc.into_iter().rev()).chain([[-top[0], top[1]]]).collect();
        // A star about the middle of its lower side.
        let n = outline.len();
        let mut triangles = Vec::new();
        let at = |i: usize, y: f64| [outline[i % n][0], y, outline[i % n][1]];
        let foot = |y: f64| [0.0, y, -4.0];
        for i in 0..n {
            let (j, split) = (i + 1, i == 0);
            for side in if split {
                vec![[at(0, 0.0), foot(0.0)], [foot(0.0), at(1, 0.0)]]
            } else {
                vec![[at(i, 0.0), at(j, 0.0)]]
            } {
                let [a, b] = side;
                let [c, d] = [a, b].map(|p| [p[0], 30.0, p[2]]);
                triangles.extend([[a, b, d], [a, d, c]]);
                if !split {
                    triangles.extend([[foot(0.0), b, a], [foot(30.0), c, d]]);
                }
            }
        }
        let mesh = TriangleMesh::weld(triangles);
        let mesh = if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh };
        Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap()
    }

    #[test]
    fn a_fillet_is_judged_alike_however_finely_it_is_divided() {
        // A ball of 1 mm stays 0.06 mm away from the bottom of a sharp valley of 140°, and nearer to that of a fillet.
        for facets in [0, 1, 2, 4, 8, 24, 90] {
            for fillet in [0.15, 0.3, 0.5] {
                assert_eq!(judge(&valley(140.0, fillet, facets), "1mm").findings, [], "{facets} {fillet}");
                assert_eq!(judge(&valley(131.5, 0.5 * fillet, facets), "0.3mm").findings, [], "{facets} {fillet}");
            }
        }
        for degrees in [60.0, 90.0, 100.0] {
            for facets in [3, 8, 24, 60] {
                // Facets that bend by more than 49° are sharp.
                if (180.0 - degrees) / facets as f64 > 40.0 {
                    continue;
                }
                let found = judge(&valley(degrees, 0.6, facets), "1mm").findings;
                let kinds: Vec<&str> = found.iter().map(|f| f.kind.as_str()).collect();
                assert_eq!(kinds, ["round"], "{degrees} {facets}: {found:?}");
                // The ball that touches the facets is at most as large as the arc and at least as large as what touches their middles.
                let inner = 0.6 * (0.5 * (180.0 - degrees).to_radians() / facets as f64).cos();
                assert!(found[0].low <= 0.6 && found[0].high >= inner, "{degrees} {facets}: {found:?}");
                assert!(found[0].high - found[0].low < 0.1, "{degrees} {facets}: {found:?}");
            }
        }
    }

    #[test]
    fn a_fillet_between_steep_walls_is_found_though_no_edge_lies_in_its_middle() {
        for degrees in [37.0, 50.0, 62.0] {
            for facets in [3, 5, 7, 8] {
                for (fillet, limit) in [(0.2, "1mm"), (0.262, "1mm"), (0.4, "0.5mm")] {
                    let found = judge(&valley(degrees, fillet, facets), limit).findings;
                    let kinds: Vec<&str> = found.iter().map(|f| f.kind.as_str()).collect();
                    assert_eq!(kinds, ["round"], "{degrees} {facets} {fillet}: {found:?}");
                    assert!(found[0].low <= fillet && fillet <= found[0].high, "{degrees} {facets}: {found:?}");
                }
                for fillet in [1.0, 1.1] {
                    let found = judge(&valley(degrees, fillet, facets), "1mm").findings;
                    // Three chords of a circle of 1 mm miss the ball by more than a tenth of it: whether they are such is open.
                    let is_open = |f: &Finding| facets == 3 && !f.decided && f.high >= 1.0;
                    assert!(found.iter().all(is_open), "{degrees} {facets} {fillet}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn corners_at_both_ends_of_a_low_wall_are_two_and_no_long_round() {
        // A channel of 6 × 6 mm, its lower corners of 0.15 mm in three facets, so high.
        let outline = |r: f64| {
            let arc = |mirrored: f64| {
                let at = (0..=3).map(|i| std::f64::consts::FRAC_PI_2 * f64::from(i) / 3.0);
                at.map(move |a| [5.0 + mirrored * (3.0 - r + r * a.cos()), 2.0 + r - r * a.sin()])
            };
            let right = [[0.0, 0.0], [10.0, 0.0], [10.0, 8.0], [8.0, 8.0]].into_iter().chain(arc(1.0));
            let left = arc(-1.0).collect::<Vec<_>>().into_iter().rev();
            right.chain(left).chain([[2.0, 8.0], [0.0, 8.0]]).collect::<Vec<[f64; 2]>>()
        };
        // Fans about both lower corners, from the edge of the floor.
        let right = (2..7).map(|i| [1, i, i + 1]);
        let caps: Vec<[usize; 3]> = right.chain((7..13).map(|i| [0, i, i + 1])).chain([[0, 1, 7]]).collect();
        for (high, told) in [(0.3, 0), (8.0, 1)] {
            let mesh = crate::geometry::extruded(&outline(0.15), &caps, high);
            let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
            assert!(part.health().is_watertight());
            let found = judge(&part, "1mm").findings;
            assert_eq!(found.len(), told, "{high}: {found:?}");
        }
    }

    #[test]
    fn a_fillet_a_little_too_small_is_told_and_one_that_may_be_large_enough_is_not() {
        for degrees in [70.0, 90.0, 110.0] {
            for facets in [8, 12, 24, 48] {
                for fillet in [1.5, 1.67, 1.8, if degrees > 90.0 { 1.85 } else { 1.9 }] {
                    let found = judge(&valley(degrees, fillet, facets), "2mm").findings;
                    assert_eq!(found.len(), 1, "{degrees} {facets} {fillet}: {found:?}");
                    assert!(found[0].low <= fillet && fillet <= found[0].high && found[0].high < 2.0, "{found:?}");
                    assert_eq!(found[0].state, State::Warn);
                }
            }
            // Fewer facets bend by more than 49°.
            for facets in [3, 4, 5, 6, 8, 12, 24, 48] {
                for fillet in [2.0, 2.1] {
                    assert_eq!(
                        judge(&valley(degrees, fillet, facets), "2mm").findings,
                        [],
                        "{degrees} {facets} {fillet}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_narrow_face_at_the_bottom_of_a_notch_makes_it_no_relief() {
        // One facet of 0.05 mm between two bends of 60°.
        assert_eq!(judge(&valley(60.0, 0.05, 1), "0.3mm").findings.len(), 1);
        assert_eq!(judge(&valley(60.0, 0.0, 0), "0.3mm").findings.len(), 1);
    }

    /// A pipe 9 mm long, 12 mm wide outside, its bore of a diameter in so many facets.
    fn bored(diameter: f64, facets: usize) -> Part {
        let turn = |i: usize| std::f64::consts::TAU * (i % facets) as f64 / facets as f64;
        let at = |i: usize, r: f64, z: f64| [r * turn(i).cos(), r * turn(i).sin(), z];
        let mut triangles = Vec::new();
        for i in 0..facets {
            let corners = [(0.5 * diameter, 0.0), (6.0, 0.0), (6.0, 9.0), (0.5 * diameter, 9.0)];
            for ((r, z), (s, w)) in corners.into_iter().zip(corners.into_iter().cycle().skip(1)) {
                let [a, b, c, d] = [at(i, r, z), at(i, s, w), at(i + 1, s, w), at(i + 1, r, z)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let mesh = TriangleMesh::weld(triangles);
        let mesh = if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh };
        Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap()
    }

    #[test]
    fn a_round_hole_narrower_than_the_ball_is_no_fillet() {
        for diameter in [0.7, 1.2, 1.5, 1.8, 1.95, 2.0, 3.0] {
            for facets in [12, 24, 64] {
                assert_eq!(judge(&bored(diameter, facets), "1mm").findings, [], "{diameter} {facets}");
            }
        }
    }

    #[test]
    fn a_fillet_that_narrows_is_told_by_its_narrowest_place() {
        // The bracket's outline at 61 places along 30 mm, its fillet of 12 facets from one radius to another.
        let outline = |fillet: f64| -> Vec<[f64; 2]> {
            let arc = (0..=12).map(|i| std::f64::consts::FRAC_PI_2 * f64::from(i) / 12.0);
            let arc = arc.map(|a| [4.0 + fillet * (1.0 - a.sin()), 4.0 + fillet * (1.0 - a.cos())]);
            [[0.0, 0.0], [20.0, 0.0], [20.0, 4.0]].into_iter().chain(arc).chain([[4.0, 20.0], [0.0, 20.0]]).collect()
        };
        for [from, to] in [[0.4, 0.6], [0.6, 0.4], [0.3, 1.5]] {
            let slices: Vec<Vec<[f64; 2]>> =
                (0..=60).map(|k| outline(from + (to - from) * f64::from(k) / 60.0)).collect();
            let at = |k: usize, i: usize| {
                let p = slices[k][i % slices[k].len()];
                [p[0], 0.5 * k as f64, p[1]]
            };
            let n = slices[0].len();
            let mut facets = Vec::new();
            for (k, i) in (0..60).flat_map(|k| (0..n).map(move |i| (k, i))) {
                facets.extend([[at(k, i), at(k + 1, i + 1), at(k, i + 1)], [at(k, i), at(k + 1, i), at(k + 1, i + 1)]]);
            }
            for i in 1..n - 1 {
                facets.extend([[at(0, 0), at(0, i), at(0, i + 1)], [at(60, 0), at(60, i + 1), at(60, i)]]);
            }
            let mesh = TriangleMesh::weld(facets);
            let mesh = if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh };
            for degrees in [0.0f64, 25.0, 70.0] {
                let (s, c) = degrees.to_radians().sin_cos();
                let turned = mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [3.7, -1.3, 0.4]);
                let found = judge(&Part::new(turned, Up::PlusZ, 1e-6, 1.0).unwrap(), "1mm").findings;
                let least = from.min(to);
                assert_eq!(found.len(), 1, "{from} {to}: {found:?}");
                // The first middle of an edge lies up to a slice from the end.
                let slice = (to - from).abs() / 60.0;
                assert!(found[0].low <= least + slice && least <= found[0].high, "{from} {to}: {found:?}");
                assert!((found[0].value - least).abs() < 0.03 + slice, "{from} {to}: {found:?}");
            }
        }
    }

    #[test]
    fn what_divides_the_facets_of_a_round_does_not_make_it_smaller() {
        // The bracket's outline in six chords, a tenth of each bent off the rest into the material.
        for (fillet, limit) in [(1.0f64, "2mm"), (0.2, "0.3mm")] {
            for (share, degrees) in [(0.1, 1.5f64), (0.9, 1.5), (0.1, 3.0), (0.2, 3.0)] {
                let turn = std::f64::consts::FRAC_PI_2 / 6.0;
                let at = |r: f64, a: f64| [4.0 + fillet - r * a.sin(), 4.0 + fillet - r * a.cos()];
                let depth = degrees.to_radians() * share * (1.0 - share) * 2.0 * fillet * (0.5 * turn).sin();
                let arc = (0..6).flat_map(|i| {
                    let [p, q] = [0, 1].map(|j| at(fillet, turn * f64::from(i + j)));
                    let out = at(depth, turn * (f64::from(i) + 0.5)).map(|c| c - 4.0 - fillet);
                    [p, [0, 1].map(|a| p[a] + share * (q[a] - p[a]) + out[a])]
                });
                let mut outline = vec![[0.0, 0.0], [20.0, 0.0], [20.0, 4.0]];
                outline.extend(arc.chain([at(fillet, std::f64::consts::FRAC_PI_2), [4.0, 20.0], [0.0, 20.0]]));
                let caps: Vec<[usize; 3]> = (1..outline.len() - 1).map(|i| [0, i, i + 1]).collect();
                let part = Part::new(crate::geometry::extruded(&outline, &caps, 30.0), Up::PlusZ, 1e-6, 1.0).unwrap();
                let found = judge(&part, limit).findings;
                assert_eq!(found.len(), 1, "{fillet} {share} {degrees}: {found:?}");
                let f = &found[0];
                assert!(f.low <= fillet && fillet <= f.high, "{fillet} {share} {degrees}: {f:?}");
                assert!((f.value / fillet - 1.0).abs() < 0.03, "{fillet} {share} {degrees}: {f:?}");
            }
        }
    }

    #[test]
    fn a_stricter_warning_does_not_make_relief_of_what_fails() {
        // Walls of 16 mm, a round of 30 mm.
        for limit in ["2mm", "2mm,3.1mm", "2mm,3.3mm", "1mm,20mm"] {
            let found = judge(&bracket(0.0, 0, 0.0), limit).findings;
            assert_eq!(found.iter().map(|f| f.state).collect::<Vec<_>>(), [State::Fail], "{limit}");
        }
        for limit in ["2mm", "2mm,5mm", "2mm,7mm"] {
            let found = judge(&bracket(1.0, 12, 0.0), limit).findings;
            assert_eq!(found.iter().map(|f| f.state).collect::<Vec<_>>(), [State::Warn], "{limit}");
        }
        assert_eq!(judge(&bracket(3.0, 12, 0.0), "2mm,7mm").findings, []);
        assert_eq!(judge(&bracket(3.0, 12, 0.0), "2mm,5mm").findings.len(), 1);
    }

    #[test]
    fn convex_parts_and_low_steps_are_left_alone() {
        let ball = crate::geometry::Primitive::parse("ball:5mm").unwrap().mesh(crate::units::Length::mm(0.01));
        assert!(judge(&Part::new(ball, Up::PlusZ, 1e-6, 1.0).unwrap(), "1mm").findings.is_empty());
        // Walls of 16 mm are a step lower than five radii of 5 mm.
        assert!(judge(&bracket(0.0, 0, 0.0), "5mm").findings.is_empty());
    }
}

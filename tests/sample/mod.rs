//! A bracket with four fins, a roof, a cup and a sealed void: a part invented for trying the press.
//!
//! The numbers are what the checks would say of it; nothing here is measured.
#![allow(dead_code)]

use amcheck::check::{Accepted, Basis, Bracket, Finding, Limits, Sense, Spot, State, Witness};
use amcheck::geometry::vector::{Vec3, add, cross, norm, scale, sub, unit};
use amcheck::grid::Grid;
use amcheck::medial::Side;
use amcheck::notice::Notice;
use amcheck::report::{
    CheckReport, Exhibit, GridReport, Layer, LimitReport, PartReport, ProcessReport, Report, SCHEMA, Slice, SurfaceMap,
    Tool, Verdict, Volume, WorstReport,
};
use amcheck::units::Length;

/// A file name that tries to break out of every format.
pub const HOSTILE: &str = "</script><img src=x>.stl";

/// Fins: place along x, thickness.
const FINS: [(f64, f64); 4] = [(6.0, 1.2), (11.2, 0.9), (16.4, 0.61), (21.6, 0.45)];

/// The shift from the frame of the file to the frame of the build.
const SHIFT: Vec3 = [28.0, 18.0, 0.0];

struct Surface {
    corners: Vec<Vec3>,
    wall: Vec<f32>,
    overhang: Vec<f32>,
    gap: Vec<f32>,
}

impl Surface {
    /// Adds a facet, split until no edge is longer than `resolution`.
    fn facet(&mut self, [a, b, c]: [Vec3; 3], resolution: f64, wall: f64, gap: f64) {
        let edges = [norm(sub(b, a)), norm(sub(c, b)), norm(sub(a, c))];
        let longest = (0..3).max_by(|&i, &j| edges[i].total_cmp(&edges[j])).unwrap();
        if edges[longest] > resolution {
            let [a, b, c] = [[a, b, c], [b, c, a], [c, a, b]][longest];
            let m = scale(add(a, b), 0.5);
            self.facet([a, m, c], resolution, wall, gap);
            return self.facet([m, b, c], resolution, wall, gap);
        }
        let normal = unit(cross(sub(b, a), sub(c, a)));
        let down = -normal[2];
        let bottom = a[2].max(b[2]).max(c[2]) < 1e-9;
        let overhang = if bottom || down <= 1e-9 { f64::NAN } else { down.clamp(-1.0, 1.0).acos().to_degrees() };
        self.corners.extend([a, b, c]);
        for p in [a, b, c] {
            // A little variation, so that an iso-line has something to follow.
            self.wall.push((wall * (1.0 + 0.25 * (p[2] / 22.0 - 0.2))) as f32);
            self.overhang.push(overhang as f32);
            self.gap.push(gap as f32);
        }
    }

    fn quad(&mut self, p: [Vec3; 4], resolution: f64, wall: f64, gap: f64) {
        self.facet([p[0], p[1], p[2]], resolution, wall, gap);
        self.facet([p[0], p[2], p[3]], resolution, wall, gap);
    }

    /// A box; `wall` along its thinnest axis, elsewhere thick.
    fn cuboid(&mut self, lo: Vec3, hi: Vec3, resolution: f64, wall: f64, gap: f64) {
        let corner = |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 1 { hi[a] } else { lo[a] });
        let thin = (0..3).min_by(|&a, &b| (hi[a] - lo[a]).total_cmp(&(hi[b] - lo[b]))).unwrap();
        for (axis, quads) in
            [(0, [[0, 4, 6, 2], [1, 3, 7, 5]]), (1, [[0, 1, 5, 4], [2, 6, 7, 3]]), (2, [[0, 2, 3, 1], [4, 5, 7, 6]])]
        {
            for q in quads {
                let (w, g) = if axis == thin { (wall, gap) } else { (4.0, f64::NAN) };
                self.quad(q.map(corner), resolution, w, g);
            }
        }
    }

    /// An upright tube about (x, y).
    fn tube(&mut self, [x, y]: [f64; 2], [inner, outer]: [f64; 2], [z0, z1]: [f64; 2], resolution: f64) {
        let n = 48;
        let at = |i: usize, r: f64, z: f64| {
            let t = i as f64 / n as f64 * std::f64::consts::TAU;
            [x + r * t.cos(), y + r * t.sin(), z]
        };
        let wall = outer - inner;
        for i in 0..n {
            let j = i + 1;
            self.quad([at(i, outer, z0), at(j, outer, z0), at(j, outer, z1), at(i, outer, z1)], resolution, wall, 9.0);
            self.quad([at(j, inner, z0), at(i, inner, z0), at(i, inner, z1), at(j, inner, z1)], resolution, wall, 9.0);
            self.quad([at(i, inner, z1), at(i, outer, z1), at(j, outer, z1), at(j, inner, z1)], resolution, 4.0, 9.0);
        }
    }
}

/// The exhibit of the bracket; a smaller resolution makes more facets (0.8 mm: about 100,000 corners).
pub fn exhibit(resolution: f64) -> Exhibit {
    let mut s = Surface { corners: vec![], wall: vec![], overhang: vec![], gap: vec![] };
    s.cuboid([0.0, 0.0, 0.0], [56.0, 36.0, 4.0], resolution, 4.0, f64::NAN);
    for (i, (x, t)) in FINS.into_iter().enumerate() {
        let gap = if i == 0 { 4.3 } else { 4.4 - 0.2 * i as f64 };
        s.cuboid([28.0 + x - 0.5 * t, 6.0, 4.0], [28.0 + x + 0.5 * t, 30.0, 20.0], resolution, t, gap);
    }
    s.cuboid([32.0, 5.0, 20.0], [51.0, 31.0, 23.0], resolution, 3.0, f64::NAN);
    s.tube([14.0, 18.0], [6.6, 7.43], [4.0, 26.0], resolution);
    let mut v = Surface { corners: vec![], wall: vec![], overhang: vec![], gap: vec![] };
    v.cuboid([44.9, 16.9, 0.9], [47.1, 19.1, 3.1], 9.0, 1.0, 1.0);
    let void = Layer { name: "trapped".into(), title: "Trapped volume, 9.2 mm³".into(), corners: v.corners };
    let map = |check: &str, title: &str, unit: &str, limits: [Option<f64>; 2], open_end, values| SurfaceMap {
        check: check.into(),
        title: title.into(),
        unit: unit.into(),
        sense: Sense::Min,
        fail: limits[0],
        warn: limits[1],
        open_end,
        fills: match check {
            "thin-wall" => Some(Side::Material),
            "narrow-gap" => Some(Side::Void),
            _ => None,
        },
        values,
    };
    Exhibit {
        maps: vec![
            map("thin-wall", "Wall thickness", "mm", [Some(0.5), Some(0.8)], 4.0, s.wall),
            map("overhang", "Overhang angle", "deg", [None, Some(45.0)], 90.0, s.overhang),
            map("narrow-gap", "Gap width", "mm", [Some(0.3), Some(0.5)], 6.0, s.gap),
        ],
        corners: s.corners,
        slices: [0, 1, 2].map(slice).into(),
        coarsened: None,
        layers: vec![void],
        volume: Some(volume()),
        stances: None,
    }
}

/// Whether a point of the build frame is in the bracket.
fn inside(p: Vec3) -> bool {
    let within = |lo: Vec3, hi: Vec3| (0..3).all(|a| p[a] >= lo[a] && p[a] <= hi[a]);
    let r = (p[0] - 14.0).hypot(p[1] - 18.0);
    let fins = FINS.iter().any(|(x, t)| within([28.0 + x - t / 2.0, 6.0, 4.0], [28.0 + x + t / 2.0, 30.0, 20.0]));
    let void = norm(sub(p, [46.0, 18.0, 2.0])) < 1.3;
    !void
        && (within([0.0; 3], [56.0, 36.0, 4.0])
            || fins
            || within([32.0, 5.0, 20.0], [51.0, 31.0, 23.0])
            || (p[2] >= 4.0 && p[2] <= 26.0 && (6.6..=7.43).contains(&r)))
}

/// The bracket's density at 0.5 mm.
fn volume() -> Volume {
    let (lo, hi) = ([0.0; 3], [56.0, 36.0, 26.0]);
    let grid = Grid::covering(lo, hi, Length::mm(0.5), 1, [0.0; 3]).unwrap();
    let density = (0..grid.samples()).map(|o| if inside(grid.position(grid.index(o))) { 255 } else { 0 }).collect();
    Volume { grid, density }
}

/// The slice through the worst finding across an axis, sampled at 0.15 mm.
fn slice(axis: usize) -> Slice {
    let (lo, hi, worst) = ([-1.0; 3], [57.0, 37.0, 27.0], [49.6, 18.0, 11.0]);
    let [u, v] = [[1, 2], [0, 2], [0, 1]][axis];
    let h = 0.15;
    let (width, height) = (((hi[u] - lo[u]) / h) as usize, ((hi[v] - lo[v]) / h) as usize);
    let mut density = Vec::with_capacity(width * height);
    for j in 0..height {
        for i in 0..width {
            let hits = (0..16).filter(|k| {
                let mut p = worst;
                p[u] = lo[u] + (i as f64 + (k % 4) as f64 / 4.0 - 0.375) * h;
                p[v] = lo[v] + (j as f64 + (k / 4) as f64 / 4.0 - 0.375) * h;
                inside(p)
            });
            density.push(hits.count() as f32 / 16.0);
        }
    }
    let pins = vec![(2, [worst[u], worst[v]]), (5, [[18.0, 11.0], [44.4, 11.0], [44.4, 18.0]][axis])];
    Slice { axis, at_mm: worst[axis], origin_mm: [lo[u], lo[v]], spacing_mm: h, width, height, density, pins }
}

fn limit(fail: Option<f64>, warn: Option<f64>, sense: Sense, unit: &str, basis: &str, source: &str) -> LimitReport {
    let (unit, basis, source) = (unit.into(), basis.into(), source.into());
    LimitReport { fail, warn, sense, unit, basis, source, overridden: false }
}

#[allow(clippy::too_many_arguments)]
fn finding(
    code: &str,
    kind: &str,
    b: [f64; 3],
    basis: Basis,
    limit: &LimitReport,
    at_mm: Vec3,
    message: &str,
    fix: &str,
) -> Finding {
    let limits = Limits { fail: limit.fail, warn: limit.warn, sense: limit.sense };
    let mut f = Finding::judged(code, kind, Bracket::new(b[0], b[1], b[2]), basis, limits, &limit.unit, 1e-6);
    f.at_mm = at_mm;
    f.box_mm = [[at_mm[0] - 0.3, -12.0, 4.0], [at_mm[0] + 0.3, 12.0, 20.0]];
    f.message = message.into();
    f.fix = fix.into();
    f.fingerprint = format!("{code}/{kind}/{:.0},{:.0},{:.0}", at_mm[0], at_mm[1], at_mm[2]);
    f
}

fn check(code: &str, name: &str, title: &str, limit: Option<LimitReport>, findings: Vec<Finding>) -> CheckReport {
    let state = findings.iter().map(|f| f.state).max().unwrap_or(State::Pass);
    let worst = findings.first().map(|f| WorstReport {
        value: f.value,
        low: f.low,
        high: f.high,
        unit: f.unit.clone(),
        at_mm: Some(f.at_mm),
    });
    let [code, name, title] = [code, name, title].map(String::from);
    CheckReport { code, name, title, state, why: None, worst, limit, cover: None, refined: None, findings }
}

fn checks() -> Vec<CheckReport> {
    let wall = limit(Some(0.5), Some(0.8), Sense::Min, "mm", "sourced", "one and two extrusion widths of the nozzle");
    let angle = limit(
        None,
        Some(45.0),
        Sense::Min,
        "deg",
        "convention",
        "ours: below it, layers rest on less than half a bead",
    );
    let gap = limit(Some(0.3), Some(0.5), Sense::Min, "mm", "sourced", "maker's design guide, 2024");
    let void = limit(Some(0.0), None, Sense::Max, "mm3", "sourced", "maker's design guide, 2024");
    let rim = limit(Some(0.8), None, Sense::Min, "mm", "user", "--limit blend=0.8mm");
    let mut fin = finding(
        "AM101",
        "wall",
        [0.45, 0.4499, 0.4501],
        Basis::Certified,
        &wall,
        [21.6, 0.0, 11.0],
        "A wall of 0.45 mm over 768 mm² is thinner than one extrusion width.",
        "Thicken by 0.05 mm to reach 0.5 mm, by 0.35 mm to reach 0.8 mm.",
    );
    fin.area_mm2 = Some(768.0);
    fin.witness =
        Some(Witness { kind: "nearest-pair".into(), points_mm: vec![[21.375, 0.0, 11.0], [21.825, 0.0, 11.0]] });
    let mut fin3 = finding(
        "AM101",
        "wall",
        [0.61, 0.58, 0.65],
        Basis::Certified,
        &wall,
        [16.4, 0.0, 11.0],
        "A wall of 0.61 mm over 768 mm² is thinner than two extrusion widths.",
        "Thicken by 0.19 mm to reach 0.8 mm.",
    );
    fin3.area_mm2 = Some(768.0);
    let mut roof = finding(
        "AM201",
        "flat",
        [0.0, 0.0, 0.0],
        Basis::Exact,
        &angle,
        [8.5, 0.0, 20.0],
        "A ceiling of 0° over 424 mm² has nothing beneath it.",
        "Turn by 90° about x, or chamfer by 45° over 4.6 mm.",
    );
    roof.area_mm2 = Some(423.6);
    roof.count = 5;
    roof.places = (0..5)
        .map(|i| Spot { at_mm: [4.0 + i as f64 * 4.6, 0.0, 20.0], box_mm: None, value: 0.0, low: 0.0, high: 0.0 })
        .collect();
    let mut sealed = finding(
        "AM301",
        "sealed",
        [9.2, 8.6, 9.7],
        Basis::Certified,
        &void,
        [18.0, 0.0, 2.0],
        "A sealed void of 9.2 mm³ keeps its powder.",
        "One drain hole of at least 2 mm; the shortest way out is 0.7 mm towards −z.",
    );
    sealed.volume_mm3 = Some(9.2);
    let cup = finding(
        "AM601",
        "blend",
        [0.83, 0.74, 0.92],
        Basis::Certified,
        &rim,
        [-14.0, 6.8, 26.0],
        "The rim's bracket holds the limit.",
        "Decide with --voxel 0.05mm (about 1.6 GB).",
    );
    let pass = |code: &str, name: &str, title: &str, limit: LimitReport, v: [f64; 3]| {
        let unit = limit.unit.clone();
        let mut c = check(code, name, title, Some(limit), vec![]);
        c.worst = Some(WorstReport { value: v[0], low: v[1], high: v[2], unit, at_mm: Some([8.8, 0.0, 11.0]) });
        c.cover = Some(
            "All 1,204 pairs of facets nearer than 5 mm were measured; none is nearer than the bracket says.".into(),
        );
        c
    };
    let without = |code: &str, name: &str, title: &str, state: State, why: &str| {
        let mut c = check(code, name, title, None, vec![]);
        (c.state, c.why) = (state, Some(why.into()));
        c
    };
    vec![
        check("AM001", "mesh", "Health of the surface", None, vec![]),
        pass(
            "AM002",
            "build-volume",
            "Extent against the machine",
            limit(Some(250.0), None, Sense::Max, "mm", "sourced", "machine data sheet"),
            [56.0, 56.0, 56.0],
        ),
        check("AM101", "thin-wall", "Thickness of plate-like material", Some(wall), vec![fin, fin3]),
        pass("AM103", "narrow-gap", "Clearance in the void", gap, [3.72, 3.65, 3.79]),
        check("AM201", "overhang", "Downward surface below the angle", Some(angle), vec![roof]),
        without("AM202", "island", "Layer regions with nothing beneath", State::NotRun, "left out by --skip island"),
        check("AM301", "trapped-volume", "Sealed voids", Some(void), vec![sealed]),
        without(
            "AM501",
            "support-access",
            "Supports that no tool can reach",
            State::NotApplicable,
            "the part needs no supports in this pose",
        ),
        check("AM601", "blend", "Concave edges sharper than the fillet radius", Some(rim), vec![cup]),
    ]
}

/// The report of the bracket, its file called `file`.
pub fn report(file: &str) -> Report {
    let checks = checks();
    let limits = checks.iter().filter_map(|c| Some((c.name.clone(), c.limit.clone()?))).collect();
    Report {
        schema: SCHEMA.into(),
        tool: Tool { name: "amcheck".into(), version: "0.1.0".into() },
        verdict: Verdict::Fail,
        summary:
            "A wall of 0.45 mm is below the 0.5 mm that one extrusion width needs and will come out with holes or \
                  not at all; thicken it by 0.05 mm."
                .into(),
        part: PartReport {
            file: file.into(),
            sha256: "9f".repeat(32),
            triangles: 101_806,
            bodies: 1,
            each_body: Vec::new(),
            box_mm: [[-28.0, -18.0, 0.0], [28.0, 18.0, 26.0]],
            volume_mm3: Bracket::new(11_422.6, 11_420.1, 11_425.0),
            area_mm2: 9_873.25,
            units: "mm".into(),
            units_from: "assumed".into(),
            watertight: true,
            pose: [
                [1.0, 0.0, 0.0, SHIFT[0]],
                [0.0, 1.0, 0.0, SHIFT[1]],
                [0.0, 0.0, 1.0, SHIFT[2]],
                [0.0, 0.0, 0.0, 1.0],
            ],
        },
        process: ProcessReport {
            name: "fdm".into(),
            title: "FDM, 0.4 mm nozzle".into(),
            layer_height_mm: 0.2,
            build_volume_mm: [250.0, 210.0, 210.0],
            prints_supports: true,
            limits,
        },
        grid: GridReport {
            spacing_mm: 0.1,
            dims: [566, 366, 266],
            samples: 566 * 366 * 266,
            memory_bytes: 402_653_184,
            refined: 1_204_881,
            refine_budget: 64_000_000,
        },
        checks,
        thickness: None,
        warnings: vec![
            Notice::new("units-assumed", "An STL has no unit; its numbers are taken as millimetres (--units)."),
            Notice::new("duplicate-facets", "2 facets stand twice; the copies were ignored.")
                .counted(2)
                .at([1.0, 2.0, 3.0]),
        ],
        baseline: None,
    }
}

/// The bracket as all checks of a grown catalogue might judge it: 22 checks in every state and unit, ten maps, a finding
/// that somebody accepts, and one whose acceptance has ended.
pub fn crowded(file: &str) -> (Report, Exhibit) {
    let (mut report, mut exhibit) = (report(file), exhibit(2.0));
    let units = ["mm", "deg", "mm2", "mm3", "1"];
    let bases = [Basis::Exact, Basis::Certified, Basis::Estimated];
    for i in report.checks.len()..22 {
        let unit = units[i % 5];
        let sense = if i % 2 == 0 { Sense::Min } else { Sense::Max };
        let l =
            limit(Some(1.0), Some(if i % 2 == 0 { 2.0 } else { 0.5 }), sense, unit, "sourced", "a design guide, 2025");
        let (code, name) = (format!("AM{}", 700 + i), format!("invented-check-{i}"));
        let value = [0.4, 1.6, 12.345678, 3.0][i % 4];
        let found = (0..i % 4).map(|k| {
            let at = [3.0 * k as f64 - 8.0, 2.0 * (i as f64 - 15.0), 11.0 + k as f64];
            let b = [value + k as f64 * 0.1, value - 0.05, value + k as f64 * 0.1 + 0.05];
            let text =
                format!("Something of {value} {unit} is not as it should be, said in a sentence of the usual length.");
            finding(&code, "kind", b, bases[i % 3], &l, at, &text, "Change it by 0.6 and look again.")
        });
        let mut c = check(&code, &name, &format!("What invented check {i} measures"), Some(l.clone()), found.collect());
        if i % 6 == 0 {
            (c.state, c.why) = (State::NotApplicable, Some("the process has no such rule".into()));
            c.findings.clear();
        }
        report.checks.push(c);
    }
    let said = |until: &str| Accepted { reason: "A living hinge, bent once".into(), until: Some(until.into()) };
    report.checks[2].findings[1].accepted = Some(said("2027-06-30"));
    report.checks[4].findings[0].acceptance_ended = Some(said("2025-06-30"));
    let first = exhibit.maps[0].clone();
    for i in 0..7 {
        let check = format!("invented-check-{}", 10 + i);
        let title = format!("Quantity number {i}");
        exhibit.maps.push(SurfaceMap { check, title, unit: units[i % 5].into(), fills: None, ..first.clone() });
    }
    (report, exhibit)
}

/// Name and text of the reports that are kept of the committed parts.
pub fn kept() -> Vec<(String, String)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/reports");
    let files = std::fs::read_dir(folder).unwrap().flatten().map(|e| e.path());
    let mut kept: Vec<(String, String)> = files
        .filter(|p| p.extension().is_some_and(|e| e == "json"))
        .map(|p| (p.display().to_string(), std::fs::read_to_string(&p).unwrap()))
        .collect();
    kept.sort();
    kept
}

//! Closed meshes with known measures.

use amcheck::geometry::vector::{Vec3, add, cross, scale, unit};
use amcheck::geometry::{TriangleMesh, cuboid, extruded, revolved};

/// A bar of 4 × 4 mm bent along a path in the plate's plane that runs through its own first leg, all one closed surface.
///
/// The legs are 20, 10, 10 and 20 mm long along their middle, so the bar has 960 mm³ and 64 mm³ of it twice.
pub fn bar_through_itself() -> TriangleMesh {
    let middle = [[0.0, 0.0], [20.0, 0.0], [20.0, 10.0], [10.0, 10.0], [10.0, -10.0]];
    let left = [[0.0, 2.0], [18.0, 2.0], [18.0, 8.0], [12.0, 8.0], [12.0, -10.0]];
    let ring = |i: usize| {
        let ([x, y], [lx, ly]) = (middle[i], left[i]);
        let (rx, ry) = (2.0 * x - lx, 2.0 * y - ly);
        [[lx, ly, 0.0], [rx, ry, 0.0], [rx, ry, 4.0], [lx, ly, 4.0]]
    };
    let mut facets = Vec::new();
    for i in 0..middle.len() - 1 {
        let (from, to) = (ring(i), ring(i + 1));
        for c in 0..4 {
            let d = (c + 1) % 4;
            facets.push([from[c], to[c], to[d]]);
            facets.push([from[c], to[d], from[d]]);
        }
    }
    let (first, last) = (ring(0), ring(middle.len() - 1));
    facets.extend([[first[0], first[1], first[2]], [first[0], first[2], first[3]]]);
    facets.extend([[last[0], last[2], last[1]], [last[0], last[3], last[2]]]);
    let mesh = TriangleMesh::weld(facets);
    if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh }
}

/// A table of 10 × 3 × 10 mm with a top 2 mm thick; its second leg ends at `foot`.
pub fn table(foot: f64) -> TriangleMesh {
    let outline =
        [[0.0, 0.0], [2.0, 0.0], [2.0, 8.0], [8.0, 8.0], [8.0, foot], [10.0, foot], [10.0, 10.0], [0.0, 10.0]];
    extruded(&outline, &[[0, 1, 2], [0, 2, 7], [2, 3, 6], [2, 6, 7], [3, 4, 5], [3, 5, 6]], 3.0)
}

/// A ramp whose underside leans `degrees` from the horizontal, on a foot of 4 mm.
pub fn ramp(degrees: f64) -> TriangleMesh {
    let rise = 10.0 * degrees.to_radians().tan();
    let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [14.0, 4.0 + rise], [14.0, 7.0 + rise], [0.0, 7.0 + rise]];
    extruded(&outline, &[[0, 1, 2], [0, 2, 5], [2, 3, 4], [2, 4, 5]], 6.0)
}

/// A ball of `rings` × 2·`rings` quads.
pub fn ball(centre: Vec3, radius: f64, rings: usize) -> TriangleMesh {
    let point = |i: usize, j: usize| {
        let (lat, lon) = (
            std::f64::consts::PI * i as f64 / rings as f64,
            std::f64::consts::PI * (j % (2 * rings)) as f64 / rings as f64,
        );
        match i {
            0 => add(centre, [0.0, 0.0, radius]),
            i if i == rings => add(centre, [0.0, 0.0, -radius]),
            _ => add(centre, scale([lat.sin() * lon.cos(), lat.sin() * lon.sin(), lat.cos()], radius)),
        }
    };
    let mut facets = Vec::new();
    for i in 0..rings {
        for j in 0..2 * rings {
            let (a, b, c, d) = (point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1));
            if i + 1 < rings {
                facets.push([a, b, c]);
            }
            if i > 0 {
                facets.push([a, c, d]);
            }
        }
    }
    TriangleMesh::weld(facets)
}

/// The rotation whose third axis is `axis`.
pub fn facing(axis: Vec3) -> [Vec3; 3] {
    let w = unit(axis);
    let u = unit(cross(if w[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] }, w));
    let v = cross(w, u);
    [[u[0], v[0], w[0]], [u[1], v[1], w[1]], [u[2], v[2], w[2]]]
}

/// The rotation by an angle about z.
pub fn about_z(degrees: f64) -> [Vec3; 3] {
    let (s, c) = degrees.to_radians().sin_cos();
    [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
}

/// Triangles of a simple polygon that runs counter-clockwise, by cutting off ears.
pub fn ears(outline: &[[f64; 2]]) -> Vec<[usize; 3]> {
    let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let mut left: Vec<usize> = (0..outline.len()).collect();
    let mut out = Vec::new();
    while left.len() > 3 {
        let n = left.len();
        let is_ear = |i: usize| {
            let t = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
            let [a, b, c] = t.map(|v| outline[v]);
            let holds = |p: [f64; 2]| cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0;
            cross(a, b, c) > 0.0 && left.iter().all(|&v| t.contains(&v) || !holds(outline[v]))
        };
        let i = (0..n).find(|&i| is_ear(i)).expect("a simple polygon has an ear");
        out.push([left[(i + n - 1) % n], left[i], left[(i + 1) % n]]);
        left.remove(i);
    }
    out.push([left[0], left[1], left[2]]);
    out
}

/// A bracket of 60 × 24 × 24 mm with fins of 1.2, 0.9, 0.6 and 0.45 mm, a slot of 0.15 mm and an arm of 8 mm.
pub fn finned_bracket() -> TriangleMesh {
    let mut outline = vec![
        [0.0, 0.0],
        [60.0, 0.0],
        [60.0, 4.0],
        [52.0, 4.0],
        [52.0, 20.0],
        [60.0, 20.0],
        [60.0, 24.0],
        [48.0, 24.0],
        [48.0, 4.0],
    ];
    for (x, thick) in [(40.0, 0.45), (30.0, 0.6), (20.0, 0.9), (10.0, 1.2)] {
        outline.extend([[x + thick, 4.0], [x + thick, 24.0], [x, 24.0], [x, 4.0]]);
    }
    outline.extend([[3.15, 4.0], [3.15, 1.0], [3.0, 1.0], [3.0, 4.0], [0.0, 4.0]]);
    let caps = ears(&outline);
    extruded(&outline, &caps, 24.0)
}

/// A cube with a cubic room in its middle and a square neck of width `neck` through its top.
pub fn flask(edge: f64, room: f64, neck: f64) -> TriangleMesh {
    let (a, b, c) = (0.5 * edge, 0.5 * room, 0.5 * neck);
    let square = |r: f64, z: f64| [[-r, -r, z], [r, -r, z], [r, r, z], [-r, r, z]];
    // Upwards outside, then in along the top and down the neck.
    let rings = [square(a, -a), square(a, a), square(c, a), square(c, b), square(b, b), square(b, -b)];
    let mut facets = Vec::new();
    for pair in rings.windows(2) {
        for i in 0..4 {
            let j = (i + 1) % 4;
            facets.push([pair[0][i], pair[0][j], pair[1][j]]);
            facets.push([pair[0][i], pair[1][j], pair[1][i]]);
        }
    }
    let [p, q, r, s] = rings[0];
    facets.extend([[p, r, q], [p, s, r]]);
    let [p, q, r, s] = rings[5];
    facets.extend([[p, q, r], [p, r, s]]);
    TriangleMesh::weld(facets).transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [a; 3])
}

/// A plate of 20 × 8 × 4 mm with a rib across its top.
pub fn ribbed(thick: f64, high: f64) -> TriangleMesh {
    let (x, z) = (10.0 + thick, 4.0 + high);
    let outline = [[0.0, 0.0], [20.0, 0.0], [20.0, 4.0], [x, 4.0], [x, z], [10.0, z], [10.0, 4.0], [0.0, 4.0]];
    extruded(&outline, &ears(&outline), 8.0)
}

/// A cube of 20 mm, and beside it on the plate the corner of a cube with three edges of a length.
pub fn block_and_speck(edge: f64) -> TriangleMesh {
    let (x, y) = (30.0, 10.0);
    let corner = TriangleMesh {
        vertices: vec![[x, y, 0.0], [x + edge, y, 0.0], [x, y + edge, 0.0], [x, y, edge]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    };
    cuboid([0.0; 3], [20.0; 3]).joined(&corner)
}

/// A plate of 20 × 8 × 4 mm with a ridge 0.5 mm wide and a groove 0.3 mm wide, both 1 mm.
pub fn relief() -> TriangleMesh {
    let outline = [
        [0.0, 0.0],
        [20.0, 0.0],
        [20.0, 4.0],
        [14.3, 4.0],
        [14.3, 3.0],
        [14.0, 3.0],
        [14.0, 4.0],
        [5.5, 4.0],
        [5.5, 5.0],
        [5.0, 5.0],
        [5.0, 4.0],
        [0.0, 4.0],
    ];
    extruded(&outline, &ears(&outline), 8.0)
}

/// A bracket of two legs of 20 mm, 4 mm thick and 10 mm deep, whose inner corner has a fillet of a radius.
pub fn angle_bracket(fillet: f64) -> TriangleMesh {
    let mut outline = vec![[0.0, 0.0], [20.0, 0.0], [20.0, 4.0]];
    let steps = if fillet > 0.0 { 8 } else { 0 };
    for i in 0..=steps {
        let (s, c) = (std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(steps.max(1))).sin_cos();
        outline.push([4.0 + fillet * (1.0 - s), 4.0 + fillet * (1.0 - c)]);
    }
    outline.extend([[4.0, 20.0], [0.0, 20.0]]);
    extruded(&outline, &ears(&outline), 10.0)
}

/// As [`revolved`], with the areas of true circles across the axis.
pub fn lathe(outline: &[[f64; 2]], n: usize) -> TriangleMesh {
    let step = std::f64::consts::TAU / n as f64;
    // A regular polygon has the area of a circle if its corners stand this much further out.
    let out = (step / step.sin()).sqrt();
    let wider: Vec<[f64; 2]> = outline.iter().map(|&[r, z]| [out * r, z]).collect();
    revolved(&wider, n)
}

/// A foot of 10 mm with an upright pin.
pub fn pin(diameter: f64, height: f64) -> TriangleMesh {
    let r = 0.5 * diameter;
    lathe(&[[0.0, 0.0], [5.0, 0.0], [5.0, 2.0], [r, 2.0], [r, 2.0 + height], [0.0, 2.0 + height]], 48)
}

/// A round plate of 10 mm, 4 mm thick, with a hole through it.
pub fn washer(diameter: f64) -> TriangleMesh {
    let r = 0.5 * diameter;
    lathe(&[[r, 0.0], [5.0, 0.0], [5.0, 4.0], [r, 4.0]], 48)
}

/// A prism 8 mm long whose section is a triangle 10 mm deep with an edge of that angle.
pub fn wedge(degrees: f64) -> TriangleMesh {
    let half = 10.0 * (0.5 * degrees).to_radians().tan();
    extruded(&[[0.0, 0.0], [10.0, -half], [10.0, half]], &[[0, 1, 2]], 8.0)
}

/// A bench of 8 mm height on two legs of 5 mm, `span` apart, 10 mm deep, its top 3 mm thick.
pub fn bench(span: f64) -> TriangleMesh {
    let (a, b) = (5.0, 5.0 + span);
    let outline = [[0.0, 0.0], [a, 0.0], [a, 5.0], [b, 5.0], [b, 0.0], [b + 5.0, 0.0], [b + 5.0, 8.0], [0.0, 8.0]];
    extruded(&outline, &[[0, 1, 2], [0, 2, 7], [2, 3, 6], [2, 6, 7], [3, 4, 5], [3, 5, 6]], 10.0)
}

/// A post of 4 × 4 × 30 mm with an arm of 16 mm at its top: it topples, and its arm takes a support of 1664 mm³.
pub fn gallows() -> TriangleMesh {
    let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 26.0], [20.0, 26.0], [20.0, 30.0], [0.0, 30.0]];
    extruded(&outline, &[[0, 1, 2], [0, 2, 5], [2, 3, 4], [2, 4, 5]], 4.0)
}

/// A block with a round tunnel of 48 sides along y, corners on the circle of that diameter.
pub fn tunnel(diameter: f64) -> TriangleMesh {
    let (n, half, r) = (24, diameter, 0.5 * diameter);
    // The left half from the floor up the tunnel's side and around; the right half is its mirror image.
    let mut left = vec![[0.0, 0.0]];
    left.extend((0..=n).map(|i| {
        let (s, c) = (std::f64::consts::PI * i as f64 / n as f64).sin_cos();
        [if i == 0 || i == n { 0.0 } else { -r * s }, diameter - r * c]
    }));
    left.extend([[0.0, 2.0 * diameter], [-half, 2.0 * diameter], [-half, 0.0]]);
    let right: Vec<[f64; 2]> = left.iter().rev().map(|p| [-p[0], p[1]]).collect();
    let mut facets = Vec::new();
    for outline in [left, right] {
        let at = |i: usize, y: f64| [outline[i][0] + 0.0, y, outline[i][1]];
        for i in 0..outline.len() {
            let j = (i + 1) % outline.len();
            // The halves meet without a wall.
            if outline[i][0] != 0.0 || outline[j][0] != 0.0 {
                facets.push([at(i, 0.0), at(j, 0.0), at(j, 12.0)]);
                facets.push([at(i, 0.0), at(j, 12.0), at(i, 12.0)]);
            }
        }
        for [a, b, c] in ears(&outline) {
            facets.push([at(a, 0.0), at(c, 0.0), at(b, 0.0)]);
            facets.push([at(a, 12.0), at(b, 12.0), at(c, 12.0)]);
        }
    }
    let mesh = TriangleMesh::weld(facets);
    if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh }
}

//! How thick material and void are all over: by the largest ball that fits, between bounds, and along the normal.

use super::mount::Wanted;
use super::phrase;
use crate::check::{Bracket, Limits, MapKind, MapWanted, Sense, limits_of};
use crate::error::{Error, Result};
use crate::field::Field;
use crate::geometry::vector::{Vec3, norm};
use crate::grid::{Fitting, Grid};
use crate::medial::Side;
use crate::medial::thickness::{Thickness, local_thickness};
use crate::part::Part;
use crate::process::Process;
use crate::units::{Length, report_digits, short};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Samples that are mapped: the grid is as fine as they allow.
const SAMPLES: u128 = 8_000_000;
/// Bytes for each mapped sample: solid, distances, bounds and what is drawn of them.
const BYTES_PER_SAMPLE: u128 = 36;
/// What the bounds lie apart on a wall at most, in spacings: [`local_thickness`].
const WALL: f64 = 2.0 * 1.7320508 + 2.0;
/// Steps to a neighbour by which what only small balls are certain to reach lies beneath a surface: √3 spacings and one on the way.
const BENEATH: usize = 2;
/// Widths that volumes are counted below, in steps of 1, 2 and 5 from the spacing upwards.
const STEPS: [f64; 3] = [1.0, 2.0, 5.0];

/// How thick a part is by the largest ball that covers a place, counted over samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ThicknessReport {
    pub spacing_mm: f64,
    pub samples: u64,
    /// Void wider than this is open space.
    pub widest_gap_mm: f64,
    /// None where no sample lies inside.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub material: Option<Spread>,
    /// Volumes of the material that is thinner than some widths.
    pub material_below: Vec<VolumeBelow>,
    /// Volumes of the void that is narrower than some widths.
    pub void_below: Vec<VolumeBelow>,
}

impl ThicknessReport {
    /// The spread of the material in words; `None` without material.
    pub fn sentence(&self) -> Option<String> {
        let said = |b: &Bracket| phrase::bracket(b.low, b.high).unwrap_or_else(|| short(b.high)) + " mm";
        let s = self.material.as_ref()?;
        let [twentieth, median, most] = [&s.twentieth_mm, &s.median_mm, &s.most_mm].map(said);
        Some(format!("median {median}, a twentieth below {twentieth}, at most {most}"))
    }
}

/// Quantiles of the thickness over the samples: each holds the true one between its ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    pub twentieth_mm: Bracket,
    pub median_mm: Bracket,
    pub most_mm: Bracket,
}

/// How much is thinner than a width: samples that are for certain, and samples that may be, as volumes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct VolumeBelow {
    pub width_mm: f64,
    pub low_mm3: f64,
    pub high_mm3: f64,
}

/// The bytes that [`thickness`] takes for a part.
///
/// # Errors
/// [`Error::Usage`] for a gap wider than the part's diagonal, or none; [`Error::Operand`] for a spacing that is not positive.
pub fn thickness_bytes(extent: Vec3, spacing: Length, widest: Length) -> Result<u128> {
    let mm = widest.as_mm();
    if !(mm > 0.0 && mm <= norm(extent)) {
        let wrong = if mm > 0.0 { "wider than the part" } else { "no gaps" };
        let problem = format!("gaps of {widest} are {wrong}");
        return Err(Error::Usage { problem, remedy: "give --thickness the widest gap of interest".into() });
    }
    Ok(fitting(extent, spacing, widest)?.samples * BYTES_PER_SAMPLE)
}

/// The grid of the part with room around it for the widest gap.
fn fitting(extent: Vec3, spacing: Length, widest: Length) -> Result<Fitting> {
    Fitting::with_samples(extent.map(|x| x + 2.0 * widest.as_mm()), spacing, SAMPLES)
}

/// Local thickness of the material and, up to a width, of the void, with the maps that show it; and the map of the distance along the
/// normal, which others call thickness.
///
/// τ(x) = 2·sup { r : x ∈ B(y, r) ⊂ S } lies between the bounds of [`local_thickness`] at every sample of a grid of the spacing, or of
/// a coarser one with eight million samples; maps show the middle between the bounds, at the surface that of what lies beneath. The ray's length at a surface point is how far the
/// inward normal goes to the next surface: at a slanted or curved far side it is more than the ball.
///
/// # Errors
/// As [`Part::window`] and [`local_thickness`].
///
/// # Cost
/// One cast and two runs of [`local_thickness`].
pub fn thickness(
    part: &Part,
    process: &Process,
    spacing: Length,
    widest: Length,
) -> Result<(ThicknessReport, Vec<Wanted>)> {
    let extent = part.extent();
    let fitting = fitting(extent, spacing, widest)?;
    let margin = widest.as_mm() + 2.0 * fitting.spacing.as_mm();
    let solid = part.window([-margin; 3], extent.map(|x| x + margin), fitting.spacing)?;
    let grid = *solid.centres.grid();
    let material = local_thickness(&solid, Side::Material, None)?;
    let shown = middle(&material)?;
    let spread = Spread::of(&material, &shown);
    let thickest = spread.map_or(widest.as_mm(), |s| s.most_mm.high);
    let material_below = below(&material, &widths(grid.h(), thickest, limits_of(process, "thin-wall")));
    let open_end = thickest.ceil();
    let of_material = map(MapKind::Sampled, "Local thickness (largest ball)", open_end, Some(shown));
    let along_ray = map(MapKind::Ray, "Thickness along the normal (ray)", open_end, None);
    let void = local_thickness(&solid, Side::Void, Some(widest))?;
    // Open space counts as wide as the widest gap, less rounding.
    let void_below = below(&void, &widths(grid.h(), 0.999 * widest.as_mm(), limits_of(process, "narrow-gap")));
    let of_void = map(MapKind::Sampled, "Local gap (largest ball)", widest.as_mm(), Some(middle(&void)?));
    let report = ThicknessReport {
        spacing_mm: report_digits(grid.h()),
        samples: grid.samples() as u64,
        widest_gap_mm: report_digits(widest.as_mm()),
        material: spread,
        material_below,
        void_below,
    };
    let named = |name: &str, map| (name.to_string(), map);
    let maps =
        vec![named("local-thickness", of_material), named("ray-thickness", along_ray), named("local-gap", of_void)];
    Ok((report, maps))
}

/// A map without limits: at every convex edge no ball is as wide as a limit, and that is no fault.
fn map(kind: MapKind, title: &'static str, open_end: f64, field: Option<Field<f32>>) -> MapWanted {
    let limits = Limits { fail: None, warn: None, sense: Sense::Min };
    MapWanted { kind, title, unit: "mm", limits, open_end, facets: Vec::new(), field }
}

/// What maps show: the middle between the bounds. Up to two samples beneath a surface none of the large balls is certain to reach; where the
/// bounds lie farther apart than on a wall, the lower is that of a sample beneath, if balls hardly larger may reach that.
///
/// # Cost
/// Looks about each such sample as often as [`BENEATH`].
fn middle(t: &Thickness) -> Result<Field<f32>> {
    let grid = *t.low.grid();
    let (mut low, high) = (t.low.values().to_vec(), t.high.values());
    let (hardly, on_a_wall) = (grid.h() as f32, (WALL * grid.h()) as f32);
    let is_bare = |low: f32, at: usize| high[at] - low > on_a_wall;
    let mut bare: Vec<usize> = (0..low.len()).into_par_iter().filter(|&at| is_bare(low[at], at)).collect();
    for _ in 0..BENEATH {
        let beneath = |&at: &usize| {
            let near = around(&grid, at).filter(|&n| high[n] <= high[at] + hardly);
            near.map(|n| low[n].min(high[at])).fold(low[at], f32::max)
        };
        let found: Vec<f32> = bare.par_iter().map(beneath).collect();
        bare.iter().zip(&found).for_each(|(&at, &value)| low[at] = value);
        bare.retain(|&at| is_bare(low[at], at));
    }
    let values = low.iter().zip(high).map(|(l, h)| 0.5 * (l + h)).collect();
    Field::from_values(grid, values, f32::NAN)
}

/// A sample and the 26 about it, as far as the grid goes.
fn around(grid: &Grid, at: usize) -> impl Iterator<Item = usize> {
    let (grid, index) = (*grid, grid.index(at));
    (0..27usize).filter_map(move |n| {
        let step = [n % 3, n / 3 % 3, n / 9];
        let to = [0, 1, 2].map(|a| (index[a] + step[a]).wrapping_sub(1));
        (0..3).all(|a| to[a] < grid.dims()[a]).then(|| grid.offset(to))
    })
}

/// Widths of the series 1, 2, 5 between the spacing and the widest, and the limits among them.
fn widths(spacing: f64, widest: f64, limits: Option<Limits>) -> Vec<f64> {
    let first = spacing.log10().floor() as i32;
    let series = (first..first + 8).flat_map(|e| STEPS.map(|s| s * 10f64.powi(e)));
    let all = series.chain(limits.iter().flat_map(|l| [l.fail, l.warn]).flatten());
    let mut widths: Vec<f64> = all.filter(|w| *w >= spacing && *w <= widest).map(report_digits).collect();
    widths.sort_by(f64::total_cmp);
    widths.dedup();
    widths
}

/// Volumes of the samples whose thickness is below each width.
fn below(t: &Thickness, widths: &[f64]) -> Vec<VolumeBelow> {
    let each = t.low.grid().h().powi(3);
    let volume = |field: &Field<f32>, width: f64| {
        report_digits(field.values().iter().filter(|v| f64::from(**v) < width).count() as f64 * each)
    };
    let row = |&width_mm: &f64| VolumeBelow {
        width_mm,
        low_mm3: volume(&t.high, width_mm),
        high_mm3: volume(&t.low, width_mm),
    };
    widths.iter().map(row).collect()
}

impl Spread {
    /// The quantiles over all samples inside, their values those of what maps show; `None` without any.
    fn of(t: &Thickness, shown: &Field<f32>) -> Option<Self> {
        let sorted = |field: &Field<f32>| {
            let mut inside: Vec<f32> = field.values().iter().copied().filter(|v| v.is_finite()).collect();
            inside.sort_unstable_by(f32::total_cmp);
            inside
        };
        let (low, shown, high) = (sorted(&t.low), sorted(shown), sorted(&t.high));
        // Bounds that hold at every sample hold for every rank.
        let at = |share: f64| {
            let rank = (share * (low.len().saturating_sub(1)) as f64).round() as usize;
            let [l, v, h] = [&low, &shown, &high].map(|of| of.get(rank).map(|x| f64::from(*x)));
            Some(Bracket::new(v?, l?, h?).rounded())
        };
        Some(Spread { twentieth_mm: at(0.05)?, median_mm: at(0.5)?, most_mm: at(1.0)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::part::Up;

    /// A plate of 12 × 10 × 3 mm.
    fn plate() -> Part {
        let mesh = Primitive::parse("box:12x10x3mm").unwrap().mesh(Length::mm(0.1));
        Part::new(mesh, Up::PlusZ, 0.0, 0.0).unwrap()
    }

    #[test]
    fn a_plate_is_as_thick_as_it_is() {
        let process = Process::named("fdm").unwrap();
        let (report, maps) = thickness(&plate(), &process, Length::mm(0.2), Length::mm(2.0)).unwrap();
        let spread = report.material.unwrap();
        // Balls of 3 mm cover all but what is near edges and corners; bounds lie at most 2√3 + 2 spacings apart.
        for quantile in [spread.median_mm, spread.most_mm] {
            assert!(quantile.low <= 3.0 && 3.0 <= quantile.high && quantile.high - quantile.low < 1.1, "{quantile:?}");
        }
        // Only the twelve edges are thinner than 2 mm.
        let thin = report.material_below.iter().find(|v| v.width_mm == 2.0).unwrap();
        assert!(thin.low_mm3 <= thin.high_mm3 && thin.high_mm3 < 120.0, "{thin:?}");
        // All space is open; what no ball is sure to reach is less than a sample deep over 372 mm² of surface.
        let open = |v: &VolumeBelow| v.low_mm3 == 0.0 && v.high_mm3 < 0.2 * 372.0;
        assert!(!report.void_below.is_empty() && report.void_below.iter().all(open), "{report:?}");
        assert_eq!(
            maps.iter().map(|m| m.0.as_str()).collect::<Vec<_>>(),
            ["local-thickness", "ray-thickness", "local-gap"]
        );
    }

    /// Whichever way it leans: on both of its faces, away from the edges, the map shows how thick it is.
    #[test]
    fn on_the_faces_of_a_plate_the_map_shows_its_thickness() {
        let process = Process::named("fdm").unwrap();
        for degrees in [0.0f64, 15.0, 30.0, 45.0] {
            let lean = [degrees.to_radians().sin(), 0.1, degrees.to_radians().cos()];
            let mesh = Primitive::parse("box:12x10x3mm").unwrap().mesh(Length::mm(0.1));
            let part = Part::new(mesh, Up::Along(lean), 1e-6, 0.0).unwrap();
            let (_, maps) = thickness(&part, &process, Length::mm(0.2), Length::mm(2.0)).unwrap();
            let field = maps[0].1.field.as_ref().unwrap();
            let mut seen = 0;
            for at in (0..field.grid().samples()).filter(|&at| field.values()[at].is_finite()) {
                let p = part.to_file(field.grid().position(field.grid().index(at)));
                if p[0].abs() < 3.5 && p[1].abs() < 2.5 {
                    // Half of what the bounds lie apart: √3 + 1 spacings.
                    assert!((field.values()[at] - 3.0).abs() < 0.55, "{degrees} {p:?} {}", field.values()[at]);
                    seen += 1;
                }
            }
            assert!(seen > 12_000, "{seen}");
        }
    }

    #[test]
    fn a_gap_wider_than_the_part_is_refused() {
        let extent = plate().extent();
        assert!(thickness_bytes(extent, Length::mm(0.2), Length::mm(15.0)).is_ok());
        assert_eq!(thickness_bytes(extent, Length::mm(0.2), Length::mm(20.0)).unwrap_err().code(), "E001");
    }
}

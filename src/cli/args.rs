//! What can be typed.

use super::words::MEMORY;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Can this part be printed? Where not, how sure is that, and what should change.
#[derive(Debug, Parser)]
#[command(name = "amcheck", version, args_conflicts_with_subcommands = true, arg_required_else_help = true)]
#[command(
    after_help = "Exit codes: 0 nothing fails, 1 a check fails, 2 usage, 3 undecided, 4 unreadable, not a solid or nothing left of it, \
                        5 too large, 6 cannot write, 70 internal error, 130 interrupted."
)]
pub struct Arguments {
    /// The part; `-` reads standard input
    #[arg(value_name = "PART", required = false)]
    pub part: Option<PathBuf>,

    #[command(flatten)]
    pub how: Judging,

    /// Folder for the results, in place of those of an earlier run; reports/ and the name of the part if left out
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Print only the report's JSON
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,

    /// Print only the verdict
    #[arg(long, short)]
    pub quiet: bool,

    /// Only say what judging would take: grid, memory, time
    #[arg(long, conflicts_with_all = ["watch", "json", "quiet"])]
    pub plan: bool,

    /// Judge again whenever the part, its process file or its acceptances change; Ctrl-C ends
    #[arg(long)]
    pub watch: bool,

    /// An earlier report.json to compare with
    #[arg(long, value_name = "OLD.json")]
    pub baseline: Option<PathBuf>,

    #[command(subcommand)]
    pub command: Option<Command>,
}

/// How a part is judged.
#[derive(Debug, Args)]
pub struct Judging {
    /// Process to judge by: fdm, sla, sls, mjf, lpbf, binder-jet, or a profile of your own
    #[arg(long, default_value = "fdm", value_name = "NAME|FILE.toml")]
    pub process: String,

    /// Unit of the file's numbers; STL has none
    #[arg(long, value_name = "mm|cm|m|in|um")]
    pub units: Option<String>,

    /// Direction of the file that points up in the build
    #[arg(long, default_value = "+z", allow_hyphen_values = true, value_name = "+z|-z|+x|-x|+y|-y|X,Y,Z|best")]
    pub up: String,

    /// Set a limit: thin-wall=0.4mm (or AM101=) fails below, thin-wall=0.4mm,0.6mm warns below the second; repeatable
    #[arg(long = "limit", value_name = "CHECK=FAIL[,WARN]")]
    pub limits: Vec<String>,

    /// Findings that are accepted, as `[[accept]]` entries; a process file may hold them too; repeatable
    #[arg(long, value_name = "FILE.toml")]
    pub accept: Vec<PathBuf>,

    /// The day by which acceptances end [default: today, UTC; asked only where one ends]
    #[arg(long, value_name = "YEAR-MONTH-DAY")]
    pub today: Option<String>,

    /// A tool for supports and surfaces, in place of the process' own: built in, a description, or a mesh, which touches with its tip (at the file's origin, +z to the hand);
    /// repeatable
    #[arg(long = "tool", value_name = "NAME|FILE.toml|FILE.stl")]
    pub tools: Vec<String>,

    /// Where finishing tools come from, tip to hand: cube (26 directions), axes, faces (their normals), sphere:N, +z, X,Y,Z; repeatable
    #[arg(long, allow_hyphen_values = true, value_name = "DIRECTIONS")]
    pub tool_from: Vec<String>,

    /// The furthest that a finishing tool leans from the build's up, as the machine allows: 0deg is three axes, from above
    #[arg(long, allow_hyphen_values = true, value_name = "ANGLE")]
    pub tool_tilt: Option<String>,

    /// Faces that finishing tools have to touch: those facing a direction, or in a box (mm); all if left out; repeatable
    #[arg(long, allow_hyphen_values = true, value_name = "+z:30deg|box:X,Y,Z:X,Y,Z")]
    pub faces: Vec<String>,

    /// Spacing of the sampling grid; chosen from the limits and the size if left out
    #[arg(long, allow_hyphen_values = true, value_name = "LENGTH")]
    pub voxel: Option<String>,

    /// Map local thickness as well: of the material by the largest ball and along the normal, of the void up to this width
    #[arg(long, allow_hyphen_values = true, value_name = "LENGTH")]
    pub thickness: Option<String>,

    /// Budget for deciding what is open, in samples
    #[arg(long, default_value = "64M", allow_hyphen_values = true, value_name = "SAMPLES")]
    pub refine: String,

    /// Memory that fields may take
    #[arg(long, default_value = MEMORY, allow_hyphen_values = true, value_name = "BYTES")]
    pub memory: String,

    /// Threads to use, no more than there is memory for; the answer does not depend on it
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,

    /// Run only these checks, by name or code
    #[arg(long, value_delimiter = ',', value_name = "LIST")]
    pub only: Vec<String>,

    /// Leave these checks out
    #[arg(long, value_delimiter = ',', value_name = "LIST")]
    pub skip: Vec<String>,

    /// What to write: json, html, png, glb, markdown, junit, sarif, badge
    #[arg(long, value_delimiter = ',', default_value = "json,html,png", value_name = "LIST")]
    pub format: Vec<String>,

    /// What makes the exit code 1: a check that fails, also one that warns or is undecided; of what is new or worse than in the baseline what fails, or
    /// also what warns or is undecided; or never
    #[arg(long, default_value = "fail", value_name = "fail|warn|undecided|new|new-warn|never")]
    pub fail_on: String,

    /// Read what is whole of a damaged file, and say what was dropped
    #[arg(long)]
    pub salvage: bool,

    /// Close cracks, drop doubled facets and turn facets before judging; says what was done and writes repaired.3mf
    #[arg(long)]
    pub repair: bool,
}

/// The commands beside judging a part.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// What a check measures, why, how, and from what source; or what an error code means
    Explain {
        /// thin-wall, AM101, E011, …
        name: String,
    },
    /// What became new, worse, better or was fixed between two reports
    Compare {
        /// The earlier report.json
        old: PathBuf,
        /// The later report.json
        new: PathBuf,
    },
    /// Judge many parts: one table, a result of each, nothing judged twice
    Batch(Box<Batch>),
    /// Join the tables of several batches or shares into one
    Merge {
        /// Folders that batches wrote to
        #[arg(required = true, value_name = "DIR")]
        folders: Vec<PathBuf>,
        /// Folder for the table; the first one named if left out
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    #[command(flatten)]
    Make(Operation),
    /// Which way to print: many directions compared by support, height, steps, liquid and contact
    Orient(Orienting),
    /// The built-in processes with their limits and sources
    Processes,
    /// The built-in tools; with a name, a drawing and the description of one
    Tools {
        /// end-mill-6, flush-cutter, … or a file
        name: Option<String>,
    },
    /// The JSON Schema of report.json
    Schema,
    /// Completions for a shell
    Completions { shell: clap_complete::Shell },
}

/// Which parts a batch judges, and how.
#[derive(Debug, Args)]
pub struct Batch {
    /// Folders, parts, or lists with one path on each line; `-` reads a list from standard input
    #[arg(required = true, value_name = "DIR|PART|LIST")]
    pub parts: Vec<PathBuf>,

    /// Folder for the results and the table
    #[arg(long, default_value = "reports/batch", value_name = "DIR")]
    pub out: PathBuf,

    /// Take only share i of n, for task i of a job array; `amcheck merge` joins the tables
    #[arg(long, value_name = "i/n")]
    pub shard: Option<String>,

    /// Parts in work at a time [default: one for every four threads]
    #[arg(long, value_name = "N")]
    pub jobs: Option<usize>,

    /// Judge again what earlier runs left a result of
    #[arg(long)]
    pub fresh: bool,

    /// Print JSON lines
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,

    /// Print only the count of each result
    #[arg(long, short)]
    pub quiet: bool,

    #[command(flatten)]
    pub how: Judging,
}

/// What orientations are compared.
#[derive(Debug, Args)]
pub struct Orienting {
    /// The part
    #[arg(value_name = "PART")]
    pub part: PathBuf,

    /// Process to print by: its overhang angle, bridges and build volume count
    #[arg(long, default_value = "fdm", value_name = "NAME|FILE.toml")]
    pub process: String,

    /// Unit of the file's numbers; STL has none
    #[arg(long, value_name = "mm|cm|m|in|um")]
    pub units: Option<String>,

    /// Directions spread over the sphere, beside the axes and the part's own faces
    #[arg(long, default_value_t = 400, value_name = "N")]
    pub directions: usize,

    /// How many of them are measured in full
    #[arg(long, default_value_t = 20, value_name = "N")]
    pub best: usize,

    /// Memory that the part may take
    #[arg(long, default_value = MEMORY, allow_hyphen_values = true, value_name = "BYTES")]
    pub memory: String,

    /// Folder for the results; reports/ and the name of the part if left out
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// What to write: json, html, png, stl (the best pose on z = 0, along x as far out as the digits of STL need)
    #[arg(long, value_delimiter = ',', default_value = "json,html,stl", value_name = "LIST")]
    pub format: Vec<String>,

    /// Print only the JSON
    #[arg(long)]
    pub json: bool,
}

/// The commands that make a shape from shapes.
///
/// An operand is a mesh file, `-` for standard input, or a built-in element: ball:2mm, box:2x1x1mm, cylinder:r1h3mm,
/// cone:r2r0.5h3mm.
#[derive(Debug, Subcommand)]
pub enum Operation {
    /// Move a part's surface outwards (+) or inwards (-): coat, shrink, machining stock
    Offset {
        /// The part: a mesh, or a built-in element such as box:20x10x5mm
        part: PathBuf,
        /// How far; negative shrinks
        #[arg(long, allow_hyphen_values = true, value_name = "±LENGTH")]
        by: String,
        #[command(flatten)]
        how: How,
    },
    /// What copies of a ball, or of another element, that fit inside a part cover
    Open {
        #[command(flatten)]
        by: Moved,
        #[command(flatten)]
        how: How,
    },
    /// What a ball, or another element, that moves about outside a part cannot reach, the part included
    Close {
        #[command(flatten)]
        by: Moved,
        #[command(flatten)]
        how: How,
    },
    /// The Minkowski sum of a part and an element
    Minkowski {
        #[command(flatten)]
        pair: Pair,
        #[command(flatten)]
        how: How,
    },
    /// The Minkowski difference: where the element may stand so that all of it lies in the part
    Difference {
        #[command(flatten)]
        pair: Pair,
        #[command(flatten)]
        how: How,
    },
    /// The translations at which a moving element meets a part
    Obstacle {
        #[command(flatten)]
        pair: Pair,
        #[command(flatten)]
        how: How,
    },
    /// What a part covers while it moves along a path, or what a bead deposits along G-code
    Sweep {
        /// The part: a mesh, or a built-in element, about the origin; with --gcode the bead, about the path
        #[arg(required_unless_present = "gcode")]
        part: Option<PathBuf>,
        /// The path: x, y, z of one point on each line, millimetres; or poses: x, y, z and a unit quaternion w, x, y, z,
        /// which turns the part about its origin; a first line of names is passed over
        #[arg(long, value_name = "PATH.csv|xyz", required_unless_present = "gcode")]
        along: Option<PathBuf>,
        /// G-code: its extrusion moves are the path, or all feed moves where nothing is extruded
        #[arg(long, value_name = "PATH.gcode", conflicts_with = "along")]
        gcode: Option<PathBuf>,
        /// Bead below the nozzle's path, as width and height [default: those of the fdm process]
        #[arg(long, value_name = "0.45x0.2mm", requires = "gcode", conflicts_with = "part")]
        bead: Option<String>,
        /// The design that the G-code came from, in its frame: what is missing and what is over is measured
        #[arg(long, value_name = "PART", requires = "gcode", conflicts_with = "along")]
        design: Option<PathBuf>,
        #[command(flatten)]
        how: How,
    },
}

/// A part and an element.
#[derive(Debug, Args)]
pub struct Pair {
    /// The part: a mesh, or a built-in element
    #[arg(value_name = "A")]
    pub part: PathBuf,
    /// The element: a mesh about its own origin, or ball:2mm, box:2x1x1mm, cylinder:r1h3mm, cone:r2r0.5h3mm
    #[arg(value_name = "B")]
    pub element: PathBuf,
}

/// A part and what is moved about in it or around it.
#[derive(Debug, Args)]
pub struct Moved {
    /// The part: a mesh, or a built-in element
    #[arg(value_name = "A")]
    pub part: PathBuf,
    /// The element, as for minkowski; its place does not matter
    #[arg(value_name = "B")]
    pub element: Option<PathBuf>,
    /// Radius of a ball as the element
    #[arg(long, allow_hyphen_values = true, value_name = "LENGTH", conflicts_with = "element")]
    pub radius: Option<String>,
}

/// How finely a shape is made, and where it goes.
#[derive(Debug, Args)]
pub struct How {
    /// Spacing of the sampling grid [default: longest side of the part, or of what is added if longer, / 128; sweep: a quarter of the thinnest side of what is swept, coarser where that takes too many samples]
    #[arg(long, value_name = "LENGTH")]
    pub voxel: Option<String>,

    /// Memory that fields may take
    #[arg(long, default_value = MEMORY, allow_hyphen_values = true, value_name = "BYTES")]
    pub memory: String,

    /// Unit of the numbers of the mesh files; STL has none
    #[arg(long, value_name = "mm|cm|m|in|um")]
    pub units: Option<String>,

    /// File for the result; its suffix names the format [default: PART_OPERATION.stl]
    #[arg(long, value_name = "FILE.stl|.glb|.obj|.ply|.3mf")]
    pub out: Option<PathBuf>,

    /// Also write the function whose zero set the surface is: millimetres, negative inside; repeatable. NPY is f32[z, y, x] in C order (x runs fastest) and has no place; NRRD and VTI name the spacing and where the first sample lies, too
    #[arg(long = "field", value_name = "FILE.npy|.nrrd|.vti")]
    pub fields: Vec<PathBuf>,

    /// Also write a picture of before and after
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
}

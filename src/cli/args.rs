//! What can be typed.

use clap::{Parser, Subcommand};
use std::path::PathBuf;

/// Can this part be printed? Where not, how sure is that, and what should change.
#[derive(Debug, Parser)]
#[command(name = "amcheck", version, args_conflicts_with_subcommands = true, arg_required_else_help = true)]
#[command(
    after_help = "Exit codes: 0 nothing fails, 1 a check fails, 2 usage, 3 undecided, 4 unreadable or not a solid, \
                        5 too large, 6 cannot write, 70 internal error, 130 interrupted."
)]
pub struct Arguments {
    /// The part; `-` reads standard input
    #[arg(value_name = "PART", required = false)]
    pub part: Option<PathBuf>,

    /// Process to judge by: fdm, sla, sls, mjf, lpbf, binder-jet, or a profile of your own
    #[arg(long, default_value = "fdm", value_name = "NAME|FILE.toml")]
    pub process: String,

    /// Unit of the file's numbers; STL has none
    #[arg(long, value_name = "mm|cm|m|in|um")]
    pub units: Option<String>,

    /// Direction of the file that points up in the build
    #[arg(long, default_value = "+z", allow_hyphen_values = true, value_name = "+z|-z|+x|-x|+y|-y")]
    pub up: String,

    /// Set a limit: thin-wall=0.4mm fails below, thin-wall=0.4mm,0.6mm warns below the second; repeatable
    #[arg(long = "limit", value_name = "CHECK=FAIL[,WARN]")]
    pub limits: Vec<String>,

    /// Spacing of the sampling grid; chosen from the limits and the size if left out
    #[arg(long, allow_hyphen_values = true, value_name = "LENGTH")]
    pub voxel: Option<String>,

    /// Budget for deciding what is open, in samples
    #[arg(long, default_value = "64M", value_name = "SAMPLES")]
    pub refine: String,

    /// Memory that fields may take
    #[arg(long, default_value = "4GiB", value_name = "BYTES")]
    pub memory: String,

    /// Threads to use; the answer does not depend on it
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,

    /// Run only these checks, by name or code
    #[arg(long, value_delimiter = ',', value_name = "LIST")]
    pub only: Vec<String>,

    /// Leave these checks out
    #[arg(long, value_delimiter = ',', value_name = "LIST")]
    pub skip: Vec<String>,

    /// Folder for the results; reports/ and the name of the part if left out
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// What to write: json, html, png, glb, markdown, junit, sarif, badge
    #[arg(long, value_delimiter = ',', default_value = "json,html,png", value_name = "LIST")]
    pub format: Vec<String>,

    /// Print only the report's JSON
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,

    /// Print only the verdict
    #[arg(long, short)]
    pub quiet: bool,

    /// An earlier report.json to compare with
    #[arg(long, value_name = "OLD.json")]
    pub baseline: Option<PathBuf>,

    /// What makes the exit code 1: a check that fails, also one that warns or is undecided, only what is new; or never
    #[arg(long, default_value = "fail", value_name = "fail|warn|undecided|new|never")]
    pub fail_on: String,

    /// Read what is whole of a damaged file, and say what was dropped
    #[arg(long)]
    pub salvage: bool,

    #[command(subcommand)]
    pub command: Option<Command>,
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
    /// The built-in processes with their limits and sources
    Processes,
    /// The JSON Schema of report.json
    Schema,
    /// Completions for a shell
    Completions { shell: clap_complete::Shell },
}

//! A process as read from a profile.

use super::builtin::builtin;
use super::limit::{Limit, LimitBasis};
use super::rule::rule;
use super::tools::{ToolChoice, Tools};
use super::waiver::{self, Waiver};
use crate::error::{Error, Place, Result, escaped, nearest, printable};
use crate::units::short;
use std::collections::BTreeMap;
use toml::Value;

/// The smallest piece of material the process lays down.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    /// `bead`, `spot` or `pixel`.
    pub kind: String,
    /// Width across the build direction, millimetres.
    pub width_mm: f64,
    /// Gaps narrower than this close while it is laid, millimetres; 0 if none does.
    pub closing_gap_mm: f64,
}

/// A process: a machine and the limits it sets.
#[derive(Debug, Clone, PartialEq)]
pub struct Process {
    /// Short name, `fdm`.
    pub name: String,
    /// One line for people.
    pub title: String,
    pub build_volume_mm: [f64; 3],
    pub layer_height_mm: f64,
    /// Whether unsupported material is held up by removable supports.
    pub prints_supports: bool,
    /// Whether loose powder holds the part up, so that nothing overhangs.
    pub powder_supports: bool,
    pub element: Element,
    /// What supports are taken off and surfaces are finished with.
    pub tools: Tools,
    /// Keyed by rule.
    pub limits: BTreeMap<String, Limit>,
    /// What is accepted all the same, with reason and end.
    pub accept: Vec<Waiver>,
}

impl Process {
    /// A built-in process by name, or a profile from TOML text.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a name that is not built in.
    pub fn named(name: &str) -> Result<Self> {
        let text = builtin(name)?;
        Process::from_toml(name, text)
    }

    /// A process from a profile: `inherits` first, then what the file overrides. One whose powder supports the part inherits no limits of overhangs and
    /// bridges from one whose does not.
    ///
    /// # Errors
    /// [`Error::Profile`] with the line of bad TOML, an unknown key (naming the nearest), a value out of range, or limits
    /// that contradict each other; [`Error::UnknownName`] for an unknown parent.
    pub fn from_toml(file: &str, text: &str) -> Result<Self> {
        let table: toml::Table = text.parse().map_err(|e: toml::de::Error| {
            let line = e.span().map(|s| 1 + text[..s.start.min(text.len())].matches('\n').count() as u64);
            Error::Profile {
                file: printable(file),
                place: line.map_or(Place::Whole, Place::Line),
                problem: escaped(&e.message().trim().replace('\n', " ")),
                remedy: "a profile is TOML; see `amcheck processes` for the keys".into(),
            }
        })?;
        let reader = Reader { file, text };
        let built_in = super::builtin::BUILTIN.iter().any(|(name, _)| *name == file);
        let mut process = match table.get("inherits") {
            Some(parent) => {
                let parent = Process::named(reader.string("inherits", parent)?)
                    .map_err(|e| reader.bad("inherits", e.to_string(), e.remedy()))?;
                Process { name: stem(file), ..parent }
            }
            None => Process::blank(&stem(file)),
        };
        let in_air = table.contains_key("inherits") && !process.powder_supports;
        reader.only(&table, "", &["inherits", "title", "machine", "element", "tools", "limits", "accept"])?;
        if let Some(title) = table.get("title") {
            process.title = reader.string("title", title)?.to_string();
        }
        if let Some(machine) = table.get("machine") {
            reader.machine(&mut process, machine)?;
        }
        if let Some(element) = table.get("element") {
            reader.element(&mut process, element)?;
            if table.contains_key("inherits") && !table.contains_key("title") {
                process.title += &format!(", as {} changes it", process.name);
            }
        }
        if let Some(tools) = table.get("tools") {
            reader.tools(&mut process, tools, !built_in)?;
        }
        if let Some(limits) = table.get("limits") {
            reader.limits(&mut process, "", limits, !built_in)?;
        }
        // What the parent asks of surface that hangs in air is nothing to ask where powder holds it.
        if process.powder_supports && in_air {
            let hangs = |key: &str| key.split('.').next().is_some_and(|check| HANGING.contains(&check));
            process.limits.retain(|key, limit| limit.overridden || !hangs(key));
        }
        process.accept = waiver::in_profile(file, text)?;
        reader.complete(&process)?;
        Ok(process)
    }

    fn blank(name: &str) -> Self {
        Process {
            name: name.into(),
            title: name.into(),
            build_volume_mm: [0.0; 3],
            layer_height_mm: 0.0,
            prints_supports: true,
            powder_supports: false,
            element: Element { kind: String::new(), width_mm: 0.0, closing_gap_mm: 0.0 },
            tools: Tools::default(),
            limits: BTreeMap::new(),
            accept: Vec::new(),
        }
    }

    /// The limit of a rule as it may be applied, if the process has one.
    pub fn limit(&self, key: &str) -> Option<Limit> {
        self.limits.get(key).map(Limit::applied)
    }

    /// The widest gap that is limited, millimetres: how far bodies are looked for around each other.
    pub fn widest_gap_mm(&self) -> f64 {
        // An offset closes gaps of twice its width.
        [("narrow-gap", 1.0), ("narrow-gap.between-bodies", 1.0), ("offset", 2.0)]
            .iter()
            .filter_map(|(key, times)| self.limit(key).map(|l| (l, times)))
            .flat_map(|(l, times)| [l.fail, l.warn].map(|x| x.map(|x| times * x)))
            .flatten()
            .fold(0.0, f64::max)
    }
}

/// Checks of surface that hangs in air.
const HANGING: [&str; 2] = ["overhang", "bridge"];

fn stem(file: &str) -> String {
    std::path::Path::new(file).file_stem().map_or_else(|| file.to_string(), |s| s.to_string_lossy().into_owned())
}

/// A profile being read, for messages that name file and line.
struct Reader<'a> {
    file: &'a str,
    text: &'a str,
}

impl Reader<'_> {
    fn bad(&self, key: &str, problem: String, remedy: String) -> Error {
        let last = key.rsplit('.').next().unwrap_or(key);
        let holds = |l: &str| {
            let l = l.trim_start().trim_start_matches('[');
            l.starts_with(last) || l.contains(&format!(".{last}"))
        };
        let line = self.text.lines().position(holds);
        Error::Profile {
            file: printable(self.file),
            place: line.map_or_else(|| Place::Key(key.into()), |l| Place::Line(l as u64 + 1)),
            problem,
            remedy,
        }
    }

    fn only(&self, table: &toml::Table, prefix: &str, known: &[&str]) -> Result<()> {
        for key in table.keys() {
            if !known.contains(&key.as_str()) {
                let remedy = nearest(key, known.iter().copied())
                    .map_or_else(|| format!("known here: {}", known.join(", ")), |n| format!("did you mean `{n}`?"));
                return Err(self.bad(key, format!("unknown key `{prefix}{}`", printable(key)), remedy));
            }
        }
        Ok(())
    }

    /// The table under a key, which a heading opens.
    fn table<'v>(&self, key: &str, value: &'v Value, heading: &str) -> Result<&'v toml::Table> {
        value.as_table().ok_or_else(|| self.bad(key, format!("`{key}` is not a table"), format!("write [{heading}]")))
    }

    fn string<'v>(&self, key: &str, value: &'v Value) -> Result<&'v str> {
        value.as_str().ok_or_else(|| self.bad(key, format!("`{key}` is not text"), "put it in quotes".into()))
    }

    fn positive(&self, key: &str, value: &Value) -> Result<f64> {
        value
            .as_float()
            .or_else(|| value.as_integer().map(|i| i as f64))
            .filter(|x| x.is_finite() && *x > 0.0)
            .ok_or_else(|| {
                self.bad(key, format!("`{key}` is not a positive number"), "give millimetres as a number".into())
            })
    }

    fn flag(&self, key: &str, value: &Value) -> Result<bool> {
        value
            .as_bool()
            .ok_or_else(|| self.bad(key, format!("`{key}` is not true or false"), "write true or false".into()))
    }

    fn machine(&self, process: &mut Process, value: &Value) -> Result<()> {
        let table = self.table("machine", value, "machine")?;
        let known = ["build_volume_mm", "layer_height_mm", "prints_supports", "powder_supports"];
        self.only(table, "machine.", &known)?;
        for (key, value) in table {
            match key.as_str() {
                "build_volume_mm" => {
                    let sides = value.as_array().filter(|a| a.len() == 3).ok_or_else(|| {
                        self.bad(key, "`build_volume_mm` is not three numbers".into(), "write [220, 220, 250]".into())
                    })?;
                    for (side, v) in process.build_volume_mm.iter_mut().zip(sides) {
                        *side = self.positive(key, v)?;
                    }
                }
                "layer_height_mm" => process.layer_height_mm = self.positive(key, value)?,
                "prints_supports" => process.prints_supports = self.flag(key, value)?,
                _ => process.powder_supports = self.flag(key, value)?,
            }
        }
        Ok(())
    }

    fn element(&self, process: &mut Process, value: &Value) -> Result<()> {
        let table = self.table("element", value, "element")?;
        self.only(table, "element.", &["kind", "width_mm", "closing_gap_mm"])?;
        if let Some(kind) = table.get("kind") {
            let kind = self.string("kind", kind)?;
            if !["bead", "spot", "pixel"].contains(&kind) {
                return Err(self.bad(
                    "kind",
                    format!("element `{}` is unknown", printable(kind)),
                    "use bead, spot or pixel".into(),
                ));
            }
            process.element.kind = kind.into();
        }
        if let Some(width) = table.get("width_mm") {
            process.element.width_mm = self.positive("width_mm", width)?;
        }
        if let Some(gap) = table.get("closing_gap_mm") {
            process.element.closing_gap_mm = self.positive("closing_gap_mm", gap)?;
        }
        Ok(())
    }

    /// Reads the names of the tools.
    fn tools(&self, process: &mut Process, value: &Value, own: bool) -> Result<()> {
        let table = self.table("tools", value, "tools")?;
        self.only(table, "tools.", &["removal", "finishing", "from", "tilt", "faces"])?;
        for (key, value) in table {
            if let "from" | "faces" | "tilt" = key.as_str() {
                let list = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
                let words = list.iter().map(|w| self.string(key, w)).collect::<Result<Vec<_>>>()?;
                process.tools.finish.set(key, &words).map_err(|e| self.bad(key, e.to_string(), e.remedy()))?;
                continue;
            }
            let names = value.as_array().ok_or_else(|| {
                self.bad(key, format!("`{key}` is not a list"), "write [\"flush-cutter\"]; see `amcheck tools`".into())
            })?;
            let choose = |name: &Value| {
                ToolChoice::named(self.string(key, name)?).map_err(|e| self.bad(key, e.to_string(), e.remedy()))
            };
            let list = names.iter().map(choose).collect::<Result<Vec<_>>>()?;
            if key == "removal" {
                process.tools.removal = list
            } else {
                process.tools.finishing = list
            }
            process.tools.named |= own;
        }
        Ok(())
    }

    /// Reads a table of limits; a table inside a limit limits a kind of the same check.
    fn limits(&self, process: &mut Process, prefix: &str, value: &Value, own: bool) -> Result<()> {
        for (name, value) in self.table("limits", value, "limits")? {
            let key = format!("{prefix}{name}");
            let table = self.table(&key, value, &format!("limits.{key}"))?;
            let rule = rule(&key).map_err(|e| self.bad(&key, e.to_string(), e.remedy()))?;
            let mut limit = process.limits.remove(&key).unwrap_or(Limit {
                fail: None,
                warn: None,
                basis: LimitBasis::User,
                source: String::new(),
                overridden: own,
            });
            if own {
                limit.basis = LimitBasis::User;
                limit.source = "process file".into();
                limit.overridden = true;
            }
            for (field, value) in table {
                match (field.as_str(), value) {
                    ("fail" | "warn", v) => {
                        let text = self.string(field, v)?;
                        let number = if text == "none" {
                            None
                        } else {
                            Some(rule.dimension.parse(text).map_err(|e| self.bad(&key, e.to_string(), e.remedy()))?)
                        };
                        if field == "fail" { limit.fail = number } else { limit.warn = number }
                    }
                    ("source", v) => limit.source = self.string(field, v)?.to_string(),
                    ("basis", v) => {
                        limit.basis = match self.string(field, v)? {
                            "sourced" => LimitBasis::Sourced,
                            "convention" => LimitBasis::Convention,
                            "user" => LimitBasis::User,
                            other => {
                                let problem = format!("basis `{}` is unknown", printable(other));
                                return Err(self.bad("basis", problem, "use sourced, convention or user".into()));
                            }
                        }
                    }
                    (kind, Value::Table(t)) => {
                        let inner = toml::Table::from_iter([(kind.to_string(), Value::Table(t.clone()))]);
                        self.limits(process, &format!("{key}."), &Value::Table(inner), own)?;
                    }
                    _ => {
                        let known = ["fail", "warn", "source", "basis"];
                        self.only(
                            &toml::Table::from_iter([(field.clone(), value.clone())]),
                            &format!("limits.{key}."),
                            &known,
                        )?;
                    }
                }
            }
            // A warn limit that is not given stays if it is not weaker than the new fail limit.
            if table.contains_key("fail") && !table.contains_key("warn") {
                limit.warn = limit.warn.filter(|&w| limit.fail.is_none_or(|fail| rule.bound.is_stricter(w, fail)));
            }
            // A table that only holds those of its kinds limits nothing itself.
            if limit.fail.is_some() || limit.warn.is_some() || !limit.source.is_empty() {
                process.limits.insert(key, limit);
            }
        }
        Ok(())
    }

    /// A process needs a machine, and every limit the stricter value as warning.
    fn complete(&self, process: &Process) -> Result<()> {
        if process.build_volume_mm.contains(&0.0) || process.layer_height_mm == 0.0 || process.element.width_mm == 0.0 {
            let problem = "no machine: build_volume_mm, layer_height_mm or element.width_mm is missing".to_string();
            return Err(self.bad("machine", problem, "start with inherits = \"fdm\"".into()));
        }
        let Element { kind, width_mm, .. } = &process.element;
        if kind == "bead" && process.layer_height_mm > *width_mm {
            let [high, wide] = [process.layer_height_mm, *width_mm].map(short);
            let problem = format!("layers of {high} mm are higher than the bead is wide, {wide} mm");
            return Err(self.bad("layer_height_mm", problem, "a bead is at least as wide as it is high".into()));
        }
        for (key, limit) in &process.limits {
            let rule = rule(key)?;
            if let (Some(fail), Some(warn)) = (limit.fail, limit.warn)
                && rule.bound.is_stricter(fail, warn)
            {
                let problem = format!("limits.{key}: warn {warn} would never be reached beside fail {fail}");
                return Err(self.bad(key, problem, "the warn limit is the stricter one".into()));
            }
        }
        Ok(())
    }
}

//! Memory and time of judging, known before they are spent.

use crate::check::registry::{left_out, metas};
use crate::error::{Error, Result, byte_count};
use crate::grid::{Fitting, fine, positive};
use crate::io::machine::Ceiling;
use crate::io::{Loaded, Salvage, bytes_of, content_of, read, reading_bytes};
use crate::notice::Notice;
use crate::process::Process;
use crate::units::{Length, short};
use std::path::Path;

/// What the process takes whatever the part: code, threads, fonts, pictures, the page, the lattice of the bead.
const FIXED: u128 = 216 << 20;

/// The same where the part is only turned and looked at.
const FIXED_TURNING: u128 = 48 << 20;

/// Threads that the demand counts.
const THREADS: usize = 2;

/// What each further thread takes, and for each triangle: measured up to 16 threads and 225,240 triangles.
const PER_THREAD: [u128; 2] = [8 << 20, 80];

/// A file larger than this is refused before it is read, whatever memory is allowed.
const MOST_FILE_BYTES: u64 = 16 << 30;

/// A file takes so many times its bytes while it is read: its bytes, what is welded from them and the mesh stand side by side for a moment.
const READING: u64 = 3;

/// Checks that look at the mesh as it is and search nothing in it.
const LIGHT: [&str; 2] = ["mesh", "build-volume"];

/// What each triangle takes where a check searches, and where none does.
const PER_TRIANGLE: [u128; 2] = [1_600, 900];

/// Checks that turn the part before its tools.
const TOOLED: [&str; 2] = ["support-access", "tool-access"];

/// What judging takes for each triangle and each sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    fixed: u128,
    per_triangle: u128,
    per_sample: u128,
    per_setup_sample: u128,
    /// Bytes for the part turned before its tools.
    setups: u128,
    /// Bytes for maps of local thickness.
    maps: u128,
    /// Seconds of one processor for a part, a million triangles and a million samples.
    seconds: [f64; 3],
}

impl Demand {
    /// The demand of the checks that run.
    ///
    /// Corners, edges and trees are made of every triangle, features and a share of the page for checks that search; sets and density of every
    /// sample, and the clearance with its components for checks that look for voids or for the ways that powder takes.
    pub fn of(process: &Process, only: &[String], skip: &[String]) -> Self {
        let running = || metas().filter(|m| left_out(m, only, skip).is_none()).map(|m| m.name);
        let runs = |name: &str| running().any(|n| n == name);
        let limited = |keys: &[&str]| keys.iter().any(|k| process.limit(k).is_some());
        let voids = runs("trapped-volume") && limited(&["trapped-volume"])
            || runs("drain") && limited(&["drain", "drain.suction"])
            || runs("tool-access") && limited(&["tool-access"]) && process.powder_supports;
        let searches = running().any(|name| !LIGHT.contains(&name));
        let [searching, looking] = PER_TRIANGLE;
        Demand {
            fixed: FIXED,
            per_triangle: if searches { searching } else { looking },
            per_sample: if voids { 18 } else { 10 },
            per_setup_sample: 2 * u128::from(TOOLED.iter().any(|c| runs(c) && limited(&[c]))),
            setups: 0,
            maps: 0,
            seconds: if searches { [0.7, 130.0, 0.08] } else { [0.3, 8.0, 0.01] },
        }
    }

    /// The demand of comparing orientations.
    pub fn of_orienting() -> Self {
        Demand {
            fixed: FIXED_TURNING,
            per_triangle: PER_TRIANGLE[0],
            per_sample: 0,
            per_setup_sample: 0,
            setups: 0,
            maps: 0,
            seconds: [0.0; 3],
        }
    }

    /// The same demand where the part is cast for its tools on so many samples, all directions together, if a check asks for it.
    ///
    /// Three sets of bits stay for each direction, the rest goes with what a few threads have in work.
    pub fn with_setups(self, samples: u128) -> Self {
        Demand { setups: samples.saturating_mul(self.per_setup_sample), ..self }
    }

    /// The same demand with so many bytes for maps of local thickness.
    pub fn with_maps(self, bytes: u128) -> Self {
        Demand { maps: bytes, ..self }
    }

    /// Bytes that judging so many triangles on so many samples takes at its peak on two threads; a test measures that no more is taken.
    pub fn bytes(&self, triangles: u64, samples: u128) -> u128 {
        let own = self.fixed + self.setups + self.maps + self.per_triangle * u128::from(triangles);
        own.saturating_add(samples.saturating_mul(self.per_sample))
    }

    /// Seconds of one processor that judging takes: of 57 runs on nineteen printed parts in three processes 51 took between half and
    /// twice as long, none more than 3.8 times less or more.
    pub fn seconds(&self, triangles: u64, samples: u128) -> f64 {
        let [part, triangle, sample] = self.seconds;
        // Maps take about a quarter of a microsecond for each of their samples.
        part + 1e-6 * (triangle * triangles as f64 + sample * samples as f64) + 7e-9 * self.maps as f64
    }
}

/// Bytes that each thread beyond two takes for so many triangles.
fn per_thread(triangles: u64) -> u128 {
    let [each, per_triangle] = PER_THREAD;
    each + per_triangle * u128::from(triangles)
}

/// Bytes that are taken on so many threads by what takes so many on two.
pub fn on_threads(need_bytes: u128, triangles: u64, threads: usize) -> u128 {
    need_bytes + per_thread(triangles) * threads.saturating_sub(THREADS) as u128
}

/// What judging may take.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Allowance {
    /// Bytes that the user allows.
    pub bytes: u128,
    /// What the machine allows; it refuses and never coarsens, so that an answer is the same on every machine.
    pub ceiling: Option<Ceiling>,
}

impl Allowance {
    /// The largest file that is opened.
    pub fn file_bytes(&self) -> u64 {
        u64::try_from(self.least() / u128::from(READING)).unwrap_or(u64::MAX).min(MOST_FILE_BYTES)
    }

    /// Bytes that both the user and the machine allow.
    pub fn least(&self) -> u128 {
        self.ceiling.iter().map(|c| u128::from(c.bytes)).fold(self.bytes, u128::min)
    }

    /// The content of a file, or of standard input for `-`, if there is memory to read it.
    ///
    /// # Errors
    /// As [`content_of`] and [`Allowance::admit_content`].
    pub fn content(&self, path: &Path) -> Result<Vec<u8>> {
        let content = content_of(path, self.file_bytes()).map_err(|e| self.refused_reading(e))?;
        self.admit_content(&content)?;
        Ok(content)
    }

    /// The bytes of a file, if there is memory to read them.
    ///
    /// # Errors
    /// As [`content_of`]; [`Error::TooLarge`] with what reading them takes.
    pub fn file(&self, path: &Path) -> Result<Vec<u8>> {
        bytes_of(path, self.file_bytes()).map_err(|e| self.refused_reading(e))
    }

    /// A refusal of a file's bytes as one of what reading them takes.
    fn refused_reading(&self, error: Error) -> Error {
        let Error::TooLarge { what, need_bytes, .. } = &error else { return error };
        let need = need_bytes.saturating_mul(u128::from(READING));
        self.admit(format!("reading {what}"), need, "export it with less detail, or ".into()).err().unwrap_or(error)
    }

    /// The whole mesh of a file, if there is memory to read it.
    ///
    /// # Errors
    /// As [`Allowance::content`] and [`read()`].
    pub fn mesh(&self, path: &Path) -> Result<Loaded> {
        read(&path.to_string_lossy(), &self.content(path)?, Salvage::Refuse)
    }

    /// Refuses content that takes more memory to read than there is.
    ///
    /// # Errors
    /// [`Error::TooLarge`] with the need.
    pub fn admit_content(&self, bytes: &[u8]) -> Result<()> {
        let remedy = "export the part as binary STL, or with fewer triangles, or ".to_string();
        self.admit(format!("reading {} bytes", bytes.len()), reading_bytes(bytes), remedy)
    }

    /// How many samples the user's allowance leaves beside the triangles.
    pub fn samples(&self, demand: &Demand, triangles: u64) -> u128 {
        self.bytes.saturating_sub(demand.bytes(triangles, 0)) / demand.per_sample
    }

    /// The usual spacing of a grid, or the least coarser one for which the user's allowance leaves room; and that it is coarser, if it is.
    ///
    /// # Errors
    /// As [`Fitting::with_samples`].
    pub fn spacing(
        &self,
        demand: &Demand,
        extent_mm: [f64; 3],
        usual: Length,
        triangles: u64,
    ) -> Result<(Length, Option<Notice>)> {
        let fits = Fitting::with_samples(extent_mm, usual, self.samples(demand, triangles))?.spacing;
        let said = || {
            let need = demand.bytes(triangles, Fitting::of(extent_mm, usual).samples);
            let text = format!(
                "a grid of {} instead of {} fits the memory allowed; --memory {} allows the usual one",
                fine(fits),
                fine(usual),
                enough(need)
            );
            Notice::new("grid-coarsened", text)
        };
        Ok((fits, (fits.as_mm() > usual.as_mm() * (1.0 + 1e-9)).then(said)))
    }

    /// Refuses more triangles than there is memory for, before anything is made of them.
    ///
    /// # Errors
    /// [`Error::TooLarge`] with the need, and what less would fit.
    pub fn admit_triangles(&self, demand: &Demand, triangles: u64) -> Result<()> {
        let [_, looking] = PER_TRIANGLE;
        let lighter = [
            (Demand { maps: 0, ..*demand }, "leave --thickness out, or ".to_string()),
            (Demand { setups: 0, ..*demand }, format!("--skip {} fits, or ", TOOLED.join(","))),
            (Demand { setups: 0, per_triangle: looking, ..*demand }, format!("--only {} fits, or ", LIGHT.join(","))),
        ];
        let fits = lighter.into_iter().find(|(lighter, _)| lighter.bytes(triangles, 0) <= self.least());
        let remedy = self.smaller(demand, fits.map(|(_, words)| words));
        self.admit(format!("judging {triangles} triangles"), demand.bytes(triangles, 0), remedy)
    }

    /// What fits in place of too many triangles: what was found to, and how many triangles would; as the beginning of a sentence that goes on with what has
    /// to be allowed.
    fn smaller(&self, demand: &Demand, found: Option<String>) -> String {
        let whatever = demand.bytes(0, 0);
        let few = self.least().saturating_sub(whatever) / demand.per_triangle;
        let fewer = (few > 0).then(|| format!("export the part with at most {few} triangles, or "));
        let ways: String = found.into_iter().chain(fewer).collect();
        if ways.is_empty() {
            return format!("{} of that are taken however few triangles there are: ", byte_count(whatever));
        }
        ways
    }

    /// On how many threads orientations of so many triangles may be compared.
    ///
    /// # Errors
    /// [`Error::TooLarge`] with the need, if there is no memory to do so on any.
    pub fn admit_orienting(&self, triangles: u64) -> Result<usize> {
        let demand = Demand::of_orienting();
        let need = demand.bytes(triangles, 0);
        self.admit(format!("comparing orientations of {triangles} triangles"), need, self.smaller(&demand, None))?;
        Ok(self.threads(need, triangles))
    }

    /// On how many threads, two at least, what takes so many bytes on two may be done for so many triangles.
    pub fn threads(&self, need_bytes: u128, triangles: u64) -> usize {
        let left = self.least().saturating_sub(need_bytes);
        THREADS.saturating_add(usize::try_from(left / per_thread(triangles)).unwrap_or(usize::MAX))
    }

    /// The grid of a spacing, if there is memory for it and the triangles.
    ///
    /// # Errors
    /// [`Error::TooLarge`] with the need and the spacing that fits; [`Error::Operand`] for a spacing that is not positive and finite.
    pub fn admit_spacing(
        &self,
        demand: &Demand,
        extent_mm: [f64; 3],
        spacing: Length,
        triangles: u64,
    ) -> Result<Fitting> {
        positive(spacing)?;
        let fitting = Fitting::of(extent_mm, spacing);
        let need = demand.bytes(triangles, fitting.samples);
        let left = self.least().saturating_sub(demand.bytes(triangles, 0)).max(1);
        let remedy = || -> Result<String> {
            let fits = Fitting::with_samples(extent_mm, spacing, left / demand.per_sample)?.spacing.as_mm();
            Ok(format!("--voxel {}mm fits, or ", short((fits * 1e3).ceil() / 1e3)))
        };
        let what = format!("a grid of {} samples at {} with {triangles} triangles", fitting.samples, fine(spacing));
        self.admit(what, need, if need > self.least() { remedy()? } else { String::new() })?;
        Ok(Fitting { bytes: need, ..fitting })
    }

    /// Refuses what takes more than is allowed; the remedy is the beginning of a sentence that goes on with what has to be allowed.
    fn admit(&self, what: String, need_bytes: u128, remedy: String) -> Result<()> {
        if need_bytes > self.bytes {
            let remedy = format!("{remedy}allow at least {} with --memory", enough(need_bytes));
            return Err(Error::TooLarge { what, need_bytes, allowed_bytes: self.bytes, remedy });
        }
        match &self.ceiling {
            Some(c) if need_bytes > u128::from(c.bytes) => Err(Error::TooLarge {
                what,
                need_bytes,
                allowed_bytes: u128::from(c.bytes),
                remedy: format!("{remedy}raise the limit or use a larger machine; {} allows no more", c.whose),
            }),
            _ => Ok(()),
        }
    }
}

/// An amount for --memory that is no less.
fn enough(bytes: u128) -> String {
    match bytes.div_ceil(1_000_000) {
        mb @ ..10_000 => format!("{mb}MB"),
        mb => format!("{}GB", mb.div_ceil(1_000)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn allowance(bytes: u128, ceiling: Option<u64>) -> Allowance {
        Allowance { bytes, ceiling: ceiling.map(|bytes| Ceiling { bytes, whose: "`ulimit -v`".into() }) }
    }

    fn demand(process: &str, only: &[&str]) -> Demand {
        let only: Vec<String> = only.iter().map(|n| n.to_string()).collect();
        Demand::of(&Process::named(process).unwrap(), &only, &[])
    }

    #[test]
    fn what_is_refused_says_what_fits() {
        let (one_gib, all) = (allowance(1 << 30, None), demand("fdm", &[]));
        let refused = one_gib.admit_spacing(&all, [100.0; 3], Length::mm(0.01), 1000).unwrap_err();
        let fits = refused.remedy().split_whitespace().nth(1).map(|w| Length::parse(w).unwrap()).unwrap();
        let fitting = one_gib.admit_spacing(&all, [100.0; 3], fits, 1000).unwrap();
        assert!(fitting.bytes <= 1 << 30 && fitting.bytes > 7 << 27, "{fitting:?}");
        assert!(one_gib.admit_triangles(&all, 100_000).is_ok());
    }

    #[test]
    fn a_grid_that_memory_makes_coarser_says_what_the_usual_one_takes() {
        let (all, usual) = (demand("fdm", &[]), Length::mm(0.3));
        let of = |bytes: u128| allowance(bytes, None).spacing(&all, [80.0; 3], usual, 1000).unwrap();
        let (coarse, said) = of(300 << 20);
        let said = said.expect("a notice").message;
        assert!(coarse > usual && said.contains(" instead of 0.3 mm fits the memory allowed"), "{said}");
        let enough = said.split("--memory ").nth(1).and_then(|s| s.split("MB").next()).unwrap();
        let enough = 1_000_000 * enough.parse::<u128>().unwrap();
        assert!(of(enough).1.is_none() && of(enough - 2_000_000).1.is_some(), "{said}");
        assert!((of(enough).0.as_mm() - 0.3).abs() < 1e-9);
    }

    #[test]
    fn what_fits_beside_too_many_triangles_is_told_and_fits() {
        let all = demand("fdm", &[]).with_setups(60 << 20);
        let refused = |mib: u128, triangles| allowance(mib << 20, None).admit_triangles(&all, triangles).unwrap_err();
        let remedy = refused(50, 1_628).remedy();
        assert!(remedy.starts_with("352.3 MB of that are taken however few") && !remedy.contains("--only"), "{remedy}");
        let enough = remedy.split_whitespace().rev().nth(2).unwrap().strip_suffix("MB").unwrap();
        let enough: u128 = 1_000_000 * enough.parse::<u128>().unwrap();
        assert!(allowance(enough, None).admit_triangles(&all, 1_628).is_ok(), "{remedy}");
        assert!(allowance(enough - 1_000_000, None).admit_triangles(&all, 1_628).is_err(), "{remedy}");
        let remedy = refused(300, 10_000).remedy();
        assert_eq!(remedy, "--skip support-access,tool-access fits, or allow at least 369MB with --memory");
        let skipped = Demand { setups: 0, ..all };
        assert!(allowance(300 << 20, None).admit_triangles(&skipped, 10_000).is_ok());
        assert!(refused(360, 100_000).remedy().starts_with("--only mesh,build-volume fits, or "));
        assert!(allowance(360 << 20, None).admit_triangles(&demand("fdm", &["mesh"]), 100_000).is_ok());
        let few = refused(400, 100_000).remedy();
        let few: u64 = few.split("at most ").nth(1).and_then(|s| s.split(' ').next()).unwrap().parse().unwrap();
        assert!(allowance(400 << 20, None).admit_triangles(&all, few).is_ok());
        assert!(allowance(400 << 20, None).admit_triangles(&all, few + 1).is_err());
    }

    #[test]
    fn a_file_is_refused_with_what_reading_it_takes() {
        let path = std::env::temp_dir().join(format!("amcheck-memory-{}.stl", std::process::id()));
        std::fs::write(&path, vec![b' '; 400_000]).unwrap();
        let refused = allowance(1_000_000, None).content(&path).unwrap_err();
        let in_batch = allowance(1_000_000, None).file(&path).unwrap_err();
        let low = allowance(4 << 30, Some(1_000_000)).content(&path).unwrap_err();
        std::fs::remove_file(&path).unwrap();
        let said = refused.to_string();
        assert!(said.starts_with("reading ") && said.ends_with(" needs 1.2 MB, allowed are 1.0 MB"), "{said}");
        assert!(refused.remedy().ends_with("allow at least 2MB with --memory"), "{}", refused.remedy());
        assert_eq!(in_batch.to_string(), said);
        assert!(low.remedy().ends_with("`ulimit -v` allows no more"), "{}", low.remedy());
    }

    #[test]
    fn a_part_to_be_turned_takes_little() {
        assert!(allowance(64 << 20, None).admit_orienting(28).is_ok());
        let refused = allowance(1 << 20, None).admit_orienting(28).unwrap_err();
        assert!(
            !refused.remedy().contains("--only") && refused.to_string().contains("orientations of 28"),
            "{refused}"
        );
    }

    #[test]
    fn as_many_threads_work_as_there_is_memory_for() {
        // Peaks measured of 225,240 triangles on 2, 8 and 16 threads, kB: turned, and judged on 7,326,592 samples.
        let triangles = 225_240;
        let turning = Demand::of_orienting().bytes(triangles, 0);
        let judging = demand("fdm", &[]).bytes(triangles, 7_326_592);
        for (need, peaks) in [(turning, [305_808, 444_316, 635_996]), (judging, [579_636, 773_980, 852_520])] {
            for (threads, peak) in [2, 8, 16].into_iter().zip(peaks) {
                let allowed = |bytes: u128| allowance(bytes, None).threads(need, triangles);
                assert!(allowed(peak << 10) <= threads, "{threads} threads take all that is allowed");
                assert!(allowed(peak << 11) >= threads, "{threads} threads take half of what is allowed");
                let told = on_threads(need, triangles, threads);
                assert!((peak << 10..peak << 11).contains(&told), "{threads}: {told}");
            }
        }
        assert_eq!(allowance(0, None).threads(judging, 12), THREADS);
        assert!(allowance(64 << 30, None).threads(judging, 12) > 1024);
    }

    #[test]
    fn twenty_million_triangles_are_refused_with_their_need() {
        let refused = allowance(4 << 30, None).admit_triangles(&demand("fdm", &[]), 20_000_000).unwrap_err();
        assert!(refused.exit_code() == 5 && refused.to_string().contains("20000000 triangles needs 3"), "{refused}");
        // The mesh alone fits a machine of 32 GiB: 735 bytes a triangle were measured between one and two million.
        let light = demand("fdm", &["mesh", "build-volume"]);
        assert!(allowance(20 << 30, None).admit_triangles(&light, 20_000_000).is_ok());
    }

    #[test]
    fn a_cube_of_1024_samples_fits_24_gib_in_every_process() {
        for process in ["fdm", "sla", "sls", "mjf", "lpbf", "binder-jet"] {
            let fitting =
                allowance(24 << 30, None).admit_spacing(&demand(process, &[]), [100.0; 3], Length::mm(0.098), 100_000);
            let fitting = fitting.unwrap_or_else(|e| panic!("{process}: {e}"));
            assert!(fitting.samples >= 1 << 30, "{fitting:?}");
        }
        let (few, many) = (demand("fdm", &[]), demand("lpbf", &[]));
        assert!(few.bytes(0, 1 << 30) < many.bytes(0, 1 << 30), "powder has to come out");
        assert_eq!(demand("lpbf", &["thin-wall"]), demand("fdm", &["thin-wall"]));
    }

    #[test]
    fn the_machine_refuses_in_a_sentence() {
        let (tight, all) = (allowance(4 << 30, Some(400 << 20)), demand("fdm", &[]));
        let refused = tight.admit_spacing(&all, [50.0; 3], Length::mm(0.12), 1000).unwrap_err();
        assert!(refused.exit_code() == 5 && refused.remedy().contains("`ulimit -v` allows no more"), "{refused}");
        assert_eq!(tight.file_bytes(), (400 << 20) / 3);
        let text = [b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(), vec![b'\n'; 40 << 20]].concat();
        let refused = tight.admit_content(&text).unwrap_err();
        assert!(refused.exit_code() == 5 && refused.to_string().contains("reading "), "{refused}");
        assert!(tight.admit_content(&text[..1 << 20]).is_ok());
        assert!(tight.admit_spacing(&all, [50.0; 3], Length::mm(0.5), 1000).is_ok());
        assert!(all.seconds(1_000_000, 0) > all.seconds(1_000, 0) && all.seconds(0, 1 << 30) > all.seconds(0, 1));
    }
}

//! How far a run is: one line on stderr, rewritten, on a terminal only.

use crate::analyze::Stage;
use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Nothing is said of what is done sooner.
const QUIET: Duration = Duration::from_millis(500);
/// Time between two lines.
const TICK: Duration = Duration::from_millis(200);

/// One line on stderr that says stage, share and time left, until it is dropped.
pub struct Progress {
    said: Arc<Mutex<Said>>,
    ticker: Option<(mpsc::Sender<()>, JoinHandle<()>)>,
}

/// What the line says.
struct Said {
    begun: Instant,
    stage: String,
    /// Share of the whole that was done when the stage began, and its own share.
    share: [f64; 2],
    stage_begun: Instant,
}

impl Progress {
    /// Starts the line if stderr is a terminal and the user has not asked for quiet.
    pub fn start(wished: Wished) -> Self {
        let now = Instant::now();
        let said = Said { begun: now, stage: "reading".into(), share: [0.0; 2], stage_begun: now };
        let said = Arc::new(Mutex::new(said));
        let shown = wished == Wished::Yes && std::io::stderr().is_terminal();
        let ticker = shown.then(|| {
            let (stop, stopped) = mpsc::channel();
            let seen = Arc::clone(&said);
            let line = std::thread::spawn(move || {
                while stopped.recv_timeout(TICK) == Err(mpsc::RecvTimeoutError::Timeout) {
                    let text = lock(&seen).line(Instant::now());
                    if let Some(text) = text {
                        write(&text);
                    }
                }
                write("");
            });
            (stop, line)
        });
        Progress { said, ticker }
    }

    /// Says a line that stays, where the other is shown.
    pub fn note(&self, text: &str) {
        if self.ticker.is_some() {
            write(&format!("{text}\n"));
        }
    }

    /// Goes on to a stage that takes a share of the whole, as `weights` know it.
    pub fn stage(&self, stage: &Stage, weights: &Weights) {
        let mut said = lock(&self.said);
        said.stage = stage.name.clone();
        said.share = weights.share(stage);
        said.stage_begun = Instant::now();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((stop, line)) = self.ticker.take() {
            let _ = stop.send(());
            let _ = line.join();
        }
    }
}

/// Whether somebody wants to see it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wished {
    Yes,
    No,
}

impl Said {
    /// The line, once there is something to say.
    fn line(&self, now: Instant) -> Option<String> {
        let elapsed = now.duration_since(self.begun);
        if elapsed < QUIET {
            return None;
        }
        let [before, own] = self.share;
        let rate = if before > 0.01 { self.stage_begun.duration_since(self.begun).as_secs_f64() / before } else { 0.0 };
        // The stage's own time counts up to its share, so that the line never goes back.
        let inside =
            if rate > 0.0 { (now.duration_since(self.stage_begun).as_secs_f64() / rate).min(0.95 * own) } else { 0.0 };
        let done = (before + inside).min(0.99);
        let left = if rate > 0.0 { format!("   about {} left", seconds(rate * (1.0 - done))) } else { String::new() };
        Some(format!("{:3.0} %  {}{left}", 100.0 * done, self.stage))
    }
}

/// Seconds as people say them.
fn seconds(s: f64) -> String {
    if s < 90.0 { format!("{:.0} s", s.max(1.0)) } else { format!("{:.0} min", s / 60.0) }
}

/// What each stage took the last time; without that every stage counts the same.
pub struct Weights(BTreeMap<String, f64>);

impl Weights {
    /// From the `timings.json` of an earlier run into the same folder.
    pub fn of_last_run(folder: &Path) -> Self {
        let text = std::fs::read_to_string(folder.join("timings.json")).unwrap_or_default();
        Weights(serde_json::from_str(&text).unwrap_or_default())
    }

    /// The share done before a stage, and its own.
    fn share(&self, stage: &Stage) -> [f64; 2] {
        let known = |name: &String| self.0.get(name).copied().filter(|s| s.is_finite() && *s >= 0.0);
        let total: f64 = stage.names.iter().filter_map(known).sum();
        if stage.names.iter().any(|n| known(n).is_none()) || total <= 0.0 {
            let n = stage.names.len().max(1) as f64;
            return [stage.at as f64 / n, 1.0 / n];
        }
        let before: f64 = stage.names.iter().take(stage.at).filter_map(known).sum();
        [before / total, stage.names.get(stage.at).and_then(known).unwrap_or(0.0) / total]
    }
}

fn lock(said: &Mutex<Said>) -> MutexGuard<'_, Said> {
    said.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes over the line; an empty text takes it away.
fn write(text: &str) {
    let mut to = std::io::stderr().lock();
    let _ = write!(to, "\r\u{1b}[K{text}");
    let _ = to.flush();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stage(at: usize) -> Stage {
        let names: Vec<String> = ["cast", "mesh", "thin-wall", "mount"].map(String::from).into();
        Stage { name: names[at].clone(), at, names }
    }

    #[test]
    fn shares_come_from_the_last_run_or_are_equal() {
        let none = Weights(BTreeMap::new());
        assert_eq!(none.share(&stage(2)), [0.5, 0.25]);
        let known = [("cast", 1.0), ("mesh", 1.0), ("thin-wall", 6.0), ("mount", 2.0), ("print", 9.0)];
        let known = Weights(known.map(|(k, v)| (k.to_string(), v)).into());
        assert_eq!(known.share(&stage(2)), [0.2, 0.6]);
    }

    #[test]
    fn the_line_waits_and_then_says_what_is_left() {
        let begun = Instant::now();
        let after = |s: f64| begun + Duration::from_secs_f64(s);
        let said = Said { begun, stage: "thin-wall".into(), share: [0.2, 0.6], stage_begun: after(1.0) };
        assert_eq!(said.line(after(0.4)), None);
        assert_eq!(said.line(after(2.0)).as_deref(), Some(" 40 %  thin-wall   about 3 s left"));
        assert_eq!(said.line(after(60.0)).as_deref(), Some(" 77 %  thin-wall   about 1 s left"));
    }
}

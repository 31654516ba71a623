//! The parts of a batch, one after the other or a few at a time, all on one pool.

use super::key::{hex, key};
use super::list::Entry;
use super::row::Row;
use super::store::Store;
use crate::error::{Error, Result};
use crate::io::machine;
use crate::report::Report;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Name and content of files.
pub type Contents = Vec<(String, Vec<u8>)>;

/// A part that was judged.
pub struct Finished {
    pub report: Report,
    /// The exit code it would end with alone.
    pub code: u8,
    /// Name and content of each file of its result.
    pub files: Contents,
}

/// What is done to each part.
pub struct Work<'a> {
    /// The bytes of a part, if there is memory to read them.
    pub content: &'a (dyn Fn(&Entry) -> Result<Vec<u8>> + Sync),
    /// Judges them.
    pub judge: &'a (dyn Fn(&Entry, &[u8]) -> Result<Finished> + Sync),
    /// Name and content of the files that say that a part was refused.
    pub refused: &'a (dyn Fn(&Entry, &Error) -> Contents + Sync),
    /// What of a part's place its result names.
    pub named: &'a (dyn Fn(&Entry) -> String + Sync),
    /// Everything else that the result depends on beside the part.
    pub settings: String,
    /// Of a share, the start of a digest of the names of all parts that it is a share of.
    pub among: Option<String>,
    /// How many parts are in work at a time.
    pub jobs: usize,
    /// What to do with results of earlier runs.
    pub earlier: Earlier,
}

/// What to do with results of earlier runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Earlier {
    Keep,
    Replace,
}

/// Judges every part and returns one line for each, in the order of the entries; `tell` hears of each in that order.
///
/// What is refused, breaks down or cannot be written is a line like any other and keeps nobody waiting. A result that an earlier
/// run left is used again if bytes, name, settings and version are the same.
///
/// # Cost
/// The inner loops of all parts share the one pool of threads; each part in work takes a thread beside it that mostly waits.
pub fn run(entries: &[Entry], store: &Store, work: &Work, mut tell: impl FnMut(&Row)) -> Vec<Row> {
    let next = AtomicUsize::new(0);
    let (send, receive) = std::sync::mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..work.jobs.clamp(1, entries.len().max(1)) {
            let (send, next) = (send.clone(), &next);
            scope.spawn(move || {
                while let Some((i, entry)) =
                    Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|i| Some((i, entries.get(i)?)))
                {
                    if send.send((i, one(entry, store, work))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let mut early: BTreeMap<usize, Row> = BTreeMap::new();
        let mut rows: Vec<Row> = Vec::with_capacity(entries.len());
        for (i, row) in receive {
            early.insert(i, row);
            while let Some(row) = early.remove(&rows.len()) {
                tell(&row);
                rows.push(row);
            }
        }
        rows
    })
}

/// The line of one part.
fn one(entry: &Entry, store: &Store, work: &Work) -> Row {
    let start = Instant::now();
    machine::forget_peak();
    let aside = Store::folder(&entry.name, &key(&[b"refused", entry.name.as_bytes(), work.settings.as_bytes()]));
    store.forget(&aside);
    let (mut row, told) = match (work.content)(entry) {
        Ok(bytes) => kept_or_judged(entry, &bytes, store, work, start),
        Err(e) => (Row::refused(&entry.name, &e), (work.refused)(entry, &e)),
    };
    // What may come out otherwise next time is told where no later run takes it for a result.
    if !told.is_empty()
        && let Err(e) = store.keep(&aside, &row, &told)
    {
        row = Row::refused(&entry.name, &e);
    }
    (row.asked, row.among) = (Some(asked(work)), work.among.clone());
    if !row.reused {
        spent(&mut row, start);
    }
    row
}

/// The start of the digest of what every part is asked.
fn asked(work: &Work) -> String {
    short_key(&[work.settings.as_bytes(), env!("CARGO_PKG_VERSION").as_bytes()])
}

/// The start of a digest of the names of parts.
pub fn names_key(entries: &[Entry]) -> String {
    short_key(&entries.iter().map(|e| e.name.as_bytes()).collect::<Vec<_>>())
}

fn short_key(parts: &[&[u8]]) -> String {
    key(parts).chars().take(16).collect()
}

/// Puts time and memory into a line.
fn spent(row: &mut Row, start: Instant) {
    row.seconds = (start.elapsed().as_secs_f64() * 1e3).round() / 1e3;
    row.peak_mib = machine::peak_bytes().map(|b| (b as f64 / f64::from(1 << 20) * 10.0).round() / 10.0);
}

/// The line of a part that could be read, and the files of a result that is not kept.
fn kept_or_judged(entry: &Entry, bytes: &[u8], store: &Store, work: &Work, start: Instant) -> (Row, Contents) {
    let named = (work.named)(entry);
    let key = key(&[bytes, named.as_bytes(), work.settings.as_bytes(), env!("CARGO_PKG_VERSION").as_bytes()]);
    let folder = Store::folder(&entry.name, &key);
    let earlier = if work.earlier == Earlier::Keep { store.find(&folder) } else { None };
    if let Some(row) = earlier {
        return (Row { part: entry.name.clone(), folder: Some(folder), reused: true, ..row }, Vec::new());
    }
    let refused = |e: &Error| (Row::refused(&entry.name, e), (work.refused)(entry, e));
    let judged = catch_unwind(AssertUnwindSafe(|| (work.judge)(entry, bytes)));
    let (mut row, files) = match judged {
        Ok(Ok(done)) => (Row::judged(&entry.name, &done.report, done.code), done.files),
        Ok(Err(e)) => refused(&e),
        Err(panic) => refused(&Error::broken_down(panic.as_ref())),
    };
    row.sha256.get_or_insert_with(|| hex(&Sha256::digest(bytes)));
    row.folder = Some(folder.clone());
    spent(&mut row, start);
    // What may come out otherwise next time is not kept.
    if [5, 6, 70, 130].contains(&row.code) {
        row.folder = None;
        return (row, files);
    }
    match store.keep(&folder, &row, &files) {
        Ok(()) => (row, Vec::new()),
        Err(e) => refused(&e),
    }
}

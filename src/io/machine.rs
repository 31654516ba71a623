//! What the machine allows this process, and what the process takes.

use std::fs;
use std::path::{Path, PathBuf};

/// The least of the limits that the system sets for memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ceiling {
    /// Bytes that the process may hold.
    pub bytes: u64,
    /// Whose limit it is, as words for a sentence: `ulimit -v`.
    pub whose: String,
}

/// The least limit on memory: of the process (`ulimit -v`, `-d`), of its control groups (versions 1 and 2, up to the root), and the
/// memory that the machine has; `None` where the system does not tell.
///
/// # Source
/// Linux: `proc(5)`, the kernel's documents on control groups versions 1 and 2.
pub fn ceiling() -> Option<Ceiling> {
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let own = of_process(&read("/proc/self/limits")).into_iter().map(|c| usable(c, threads));
    let groups = of_groups(&read("/proc/self/cgroup"), Path::new("/sys/fs/cgroup"));
    let whole = kib(&read("/proc/meminfo"), "MemTotal:");
    let whole = whole.map(|bytes| Ceiling { bytes, whose: "the memory of this machine".into() });
    own.chain(groups).chain(whole).min_by_key(|c| c.bytes)
}

/// What is left of a limit on addresses: each thread reserves a stack and an arena of the allocator that it hardly fills.
fn usable(limit: Ceiling, threads: u64) -> Ceiling {
    Ceiling { bytes: limit.bytes - (threads * (66 << 20)).min(limit.bytes / 2), ..limit }
}

/// The soft limits on address space and data in `/proc/self/limits`.
fn of_process(text: &str) -> Vec<Ceiling> {
    let of = |name: &str, whose: &str| {
        let rest = text.lines().find_map(|l| l.strip_prefix(name))?;
        let bytes = rest.split_whitespace().next()?.parse().ok()?;
        Some(Ceiling { bytes, whose: whose.into() })
    };
    [of("Max address space", "`ulimit -v`"), of("Max data size", "`ulimit -d`")].into_iter().flatten().collect()
}

/// The limits of the control groups that `/proc/self/cgroup` names, each with those above it.
fn of_groups(text: &str, mount: &Path) -> Vec<Ceiling> {
    let mut found = Vec::new();
    for line in text.lines() {
        let mut fields = line.splitn(3, ':');
        let (Some(number), Some(controllers), Some(path)) = (fields.next(), fields.next(), fields.next()) else {
            continue;
        };
        let (root, file) = match (number, controllers) {
            ("0", "") => (mount.to_path_buf(), "memory.max"),
            (_, list) if list.split(',').any(|c| c == "memory") => (mount.join("memory"), "memory.limit_in_bytes"),
            _ => continue,
        };
        let mut group: PathBuf = path.trim_start_matches('/').into();
        loop {
            let limit = fs::read_to_string(root.join(&group).join(file)).ok();
            // Version 1 writes no limit as a number near 2⁶³.
            let bytes = limit.and_then(|t| t.trim().parse::<u64>().ok()).filter(|b| *b < 1 << 60);
            found.extend(bytes.map(|bytes| Ceiling { bytes, whose: format!("the control group ({file})") }));
            if !group.pop() {
                break;
            }
        }
    }
    found
}

/// The number of a line such as `VmHWM:   1234 kB`, in bytes.
fn kib(text: &str, name: &str) -> Option<u64> {
    let rest = text.lines().find_map(|l| l.strip_prefix(name))?;
    rest.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// The most memory that the process has held since it began, or since [`forget_peak`]; `None` where the system does not tell.
pub fn peak_bytes() -> Option<u64> {
    kib(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Starts the count of [`peak_bytes`] again at what is held now, where the system can.
pub fn forget_peak() {
    // Linux: 5 resets the high-water mark. Elsewhere, or where it is forbidden, the mark stays.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_a_process_are_read() {
        let text = "Limit                     Soft Limit           Hard Limit           Units     \n\
                    Max data size             unlimited            unlimited            bytes     \n\
                    Max address space         2147483648           unlimited            bytes     \n";
        assert_eq!(of_process(text), [Ceiling { bytes: 1 << 31, whose: "`ulimit -v`".into() }]);
        assert_eq!(of_process(""), []);
    }

    #[test]
    fn the_least_limit_of_a_group_and_those_above_counts() {
        let dir = std::env::temp_dir().join(format!("amcheck-groups-{}", std::process::id()));
        let put = |path: &str, text: &str| {
            let path = dir.join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        put("a/b/memory.max", "max\n");
        put("a/memory.max", "1000000\n");
        put("memory/job/memory.limit_in_bytes", "500000\n");
        put("memory/memory.limit_in_bytes", "9223372036854771712\n");
        let bytes = |text: &str| -> Vec<u64> { of_groups(text, &dir).iter().map(|c| c.bytes).collect() };
        assert_eq!(bytes("0::/a/b\n"), [1_000_000]);
        assert_eq!(bytes("9:cpu:/x\n7:memory,hugetlb:/job\n"), [500_000]);
        assert_eq!(bytes("0::/../elsewhere\nnonsense\n"), [] as [u64; 0]);
        fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_peak_is_at_least_what_was_just_touched() {
        let held = vec![1u8; 64 << 20];
        assert!(held.iter().map(|b| u64::from(*b)).sum::<u64>() == 64 << 20);
        assert!(peak_bytes().is_some_and(|b| b >= 64 << 20));
        assert!(ceiling().is_some_and(|c| c.bytes > 64 << 20));
    }
}

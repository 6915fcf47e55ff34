//! Check for enough memory before large arrays are allocated.

use crate::error::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// Fails if `bytes` for `what`, and an eighth more, are more than this machine can give now.
///
/// If the system does not report its memory, every request passes.
///
/// # Errors
/// A request larger than the available memory.
pub fn ensure_room(bytes: u64, what: &str) -> Result<()> {
    check(bytes, available(), what)
}

fn check(bytes: u64, available: Option<u64>, what: &str) -> Result<()> {
    // An eighth more for small allocations beside a large one, and for the address space that the C library sets aside for each thread.
    let bytes = bytes.saturating_add(bytes / 8);
    match available {
        Some(room) if bytes > room => Err(Error::memory(
            format!("{what} would take {} of memory and {} are free", in_words(bytes), in_words(room)),
            "use a smaller field, or a machine with more memory",
        )),
        _ => Ok(()),
    }
}

/// Returns the number of threads, at least 1 and at most `wanted`, that leave most of the available memory to the work.
pub fn affordable_threads(wanted: usize) -> usize {
    /// Address space of a thread: its stack of 2 MiB, a stack for its signals, and what the C library sets aside \[bytes\].
    const OF_A_THREAD: u64 = 4 << 20;
    threads_within(available(), OF_A_THREAD, wanted)
}

fn threads_within(available: Option<u64>, of_a_thread: u64, wanted: usize) -> usize {
    /// Part of the memory that threads may take, 1 over this.
    const PART: u64 = 8;
    let Some(room) = available else { return wanted };
    usize::try_from(room / PART / of_a_thread).unwrap_or(wanted).clamp(1, wanted.max(1))
}

/// Returns true if this process may take less address space than the machine has.
pub fn is_limited() -> bool {
    own_limits().is_some_and(|(limits, status)| own_available(&limits, &status).is_some())
}

/// Reads `/proc/self/limits` and `/proc/self/status`.
fn own_limits() -> Option<(String, String)> {
    fs::read_to_string("/proc/self/limits").ok().zip(fs::read_to_string("/proc/self/status").ok())
}

/// Returns the memory that is available without swapping: the lowest of the system's estimate, the limit of the control group, and the rest
/// of the process limit (`ulimit -v`).
fn available() -> Option<u64> {
    /// Address space that threads take for themselves between a check and its allocation \[bytes\].
    const OF_OTHERS: u64 = 8 << 20;
    let system = fs::read_to_string("/proc/meminfo").ok().and_then(|text| meminfo_available(&text));
    let group = group_available();
    let process = own_limits().and_then(|(limits, status)| own_available(&limits, &status));
    let process = process.map(|room| room.saturating_sub(OF_OTHERS));
    system.into_iter().chain(group).chain(process).min()
}

/// Returns the memory that the limits of this process' control groups leave beside its present memory \[bytes\]; `None` without a limit.
fn group_available() -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default(); // no /proc: no groups are known
    // A container sees its control group as the root.
    let root =
        ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"].map(PathBuf::from);
    let files = group_limits(&groups).into_iter().chain(root);
    let limit = files.filter_map(|file| fs::read_to_string(file).ok()?.trim().parse::<u64>().ok()).min()?;
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default(); // no /proc: nothing counts as taken
    Some(limit.saturating_sub(kib_after("VmRSS:", &status).unwrap_or(0)))
}

/// Returns the files with the limits of the groups in the text of `/proc/self/cgroup`, of version 1 and 2, and of the groups above them.
fn group_limits(groups: &str) -> Vec<PathBuf> {
    let files = groups.lines().flat_map(|line| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (root, file) = match parts.next() {
            Some("") => ("/sys/fs/cgroup", "memory.max"),
            Some(names) if names.split(',').any(|name| name == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => return Vec::new(),
        };
        let path = Path::new(parts.next().unwrap_or_default().trim_start_matches('/'));
        // The last of them is the empty path.
        path.ancestors().map(|group| Path::new(root).join(group).join(file)).collect()
    });
    files.collect()
}

/// Returns the difference of the address space in `/proc/self/limits` and `VmSize` of `/proc/self/status` \[bytes\]; `None` without a
/// limit.
fn own_available(limits: &str, status: &str) -> Option<u64> {
    let limit = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = limit.split_whitespace().next()?.parse().ok()?;
    Some(limit.saturating_sub(kib_after("VmSize:", status)?))
}

/// Returns `MemAvailable` of `/proc/meminfo` \[bytes\].
fn meminfo_available(text: &str) -> Option<u64> {
    kib_after("MemAvailable:", text)
}

/// Returns the number of KiB in the line that begins with `name` \[bytes\].
fn kib_after(name: &str, text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kib: u64 = line.split_whitespace().next()?.parse().ok()?;
    kib.checked_mul(1024)
}

/// Returns `bytes` in the largest binary unit that they fill.
pub(crate) fn in_words(bytes: u64) -> String {
    const KIB: f64 = 1024.0;
    let size = bytes as f64;
    if size < KIB {
        format!("{bytes} B")
    } else if size < KIB.powi(2) {
        format!("{:.0} KiB", size / KIB)
    } else if size < KIB.powi(3) {
        format!("{:.0} MiB", size / KIB.powi(2))
    } else {
        format!("{:.1} GiB", size / KIB.powi(3))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_as_many_as_an_eighth_of_the_memory_holds() {
        assert_eq!(threads_within(None, 4 << 20, 64), 64);
        assert_eq!(threads_within(Some(64 << 30), 4 << 20, 64), 64);
        assert_eq!(threads_within(Some(100 << 20), 4 << 20, 64), 3);
        assert_eq!(threads_within(Some(0), 4 << 20, 64), 1);
    }

    #[test]
    fn more_than_there_is_is_refused_and_less_is_not() {
        let e = check(4 << 30, Some(2 << 30), "the field").unwrap_err().to_string();
        assert!(e.contains("4.5 GiB") && e.contains("2.0 GiB"), "{e}");
        assert!(check(800, Some(900), "the field").is_ok());
        assert!(check(801, Some(900), "the field").is_err(), "nothing is left for what stands beside it");
        assert!(check(u64::MAX, None, "the field").is_ok());
    }

    #[test]
    fn a_limit_of_the_process_leaves_what_is_not_taken() {
        let limits =
            "Limit  Soft Limit  Hard Limit  Units\nMax address space         10240  unlimited  bytes\n";
        assert_eq!(own_available(limits, "VmPeak: 9 kB\nVmSize:\t    4 kB\n"), Some(6 * 1024));
        assert_eq!(own_available(limits, "VmSize: 40 kB\n"), Some(0));
        assert_eq!(own_available(&limits.replace("10240", "unlimited"), "VmSize: 4 kB\n"), None);
    }

    #[test]
    fn limits_are_looked_for_in_the_group_and_all_above_it_of_both_versions() {
        let files = |groups: &str| {
            let files = group_limits(groups);
            files.into_iter().map(|file| file.display().to_string()).collect::<Vec<_>>()
        };
        assert_eq!(
            files("0::/user.slice/run-1.scope\n"),
            [
                "/sys/fs/cgroup/user.slice/run-1.scope/memory.max",
                "/sys/fs/cgroup/user.slice/memory.max",
                "/sys/fs/cgroup/memory.max",
            ]
        );
        assert_eq!(
            files("9:name=systemd:/\n4:memory:/a:b\n3:cpuset:/x\n"),
            [
                "/sys/fs/cgroup/memory/a:b/memory.limit_in_bytes",
                "/sys/fs/cgroup/memory/memory.limit_in_bytes"
            ]
        );
        assert_eq!(files("0::/\n"), ["/sys/fs/cgroup/memory.max"]);
        assert_eq!(files("").len() + files("nonsense").len(), 0);
    }

    #[test]
    fn the_systems_estimate_is_read_in_bytes() {
        assert_eq!(meminfo_available("MemTotal: 9 kB\nMemAvailable:   4 kB\n"), Some(4096));
        assert_eq!(meminfo_available("MemTotal: 9 kB\n"), None);
    }
}

//! Detection of a stdout that is closed (`diffract … >&-`). Rust's runtime opens `/dev/null` in its place before `main` begins, so that results would
//! vanish without an error.

#[cfg(target_os = "linux")]
mod at_start {
    use std::fs;
    use std::sync::atomic::{AtomicBool, Ordering};

    /// True if stdout was closed before the runtime began.
    pub static WAS_CLOSED: AtomicBool = AtomicBool::new(false);

    /// Function that the loader calls before the runtime begins.
    #[used]
    // SAFETY: `.init_array` holds addresses of functions without arguments, as this is. The loader calls them in the only thread that there is. `look` needs
    // nothing of the runtime: it reads a folder of the system and stores a flag.
    #[allow(unsafe_code, reason = "nothing that runs later sees what the runtime replaced")]
    #[unsafe(link_section = ".init_array")]
    static LOOK: extern "C" fn() = look;

    extern "C" fn look() {
        // A system without /proc tells nothing.
        let is_told = fs::symlink_metadata("/proc/self/fd").is_ok();
        let is_open = fs::symlink_metadata("/proc/self/fd/1").is_ok();
        WAS_CLOSED.store(is_told && !is_open, Ordering::Relaxed);
    }
}

/// Returns true if the program was started without a stdout, as far as the system tells.
pub fn is_closed() -> bool {
    #[cfg(target_os = "linux")]
    return at_start::WAS_CLOSED.load(std::sync::atomic::Ordering::Relaxed);
    #[cfg(not(target_os = "linux"))]
    false
}

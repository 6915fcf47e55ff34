//! Start of the program where its address space is limited (`ulimit -v`).

use super::closed_stdout;
use crate::memory;
use std::os::unix::process::CommandExt;
use std::process::Command;

/// Starts the program again, in this process, with one arena of memory for all threads, if the address space is limited.
///
/// The GNU C library sets 64 MiB of address space aside for each thread that allocates. Within a limit the first thread would take what the
/// work needs, and the program would abort where another one asks for a few bytes. The library reads the number of arenas when a program
/// starts, and never again.
pub fn share() {
    const VARIABLE: &str = "MALLOC_ARENA_MAX";
    // A second start would not see that stdout was closed before the first.
    if std::env::var_os(VARIABLE).is_some() || closed_stdout::is_closed() || !memory::is_limited() {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let mut words = std::env::args_os();
    let mut again = Command::new(program);
    if let Some(name) = words.next() {
        again.arg0(name);
    }
    // It returns only if the system starts nothing: the work is done as it is.
    let _ = again.args(words).env(VARIABLE, "1").exec();
}

//! Writing to whoever reads: standard output and standard error, either of which may be closed.
//!
//! A reader that has seen enough (`csat keys | head -1`) is no failure: what it does not read is
//! dropped, the command goes on to its end, and its exit code says what became of it. The macros of
//! the standard library panic instead, so clippy forbids them here.

use std::io::{self, Write};

/// Writes a line to standard error, as `eprintln!` does; nothing happens when it is closed.
#[macro_export]
macro_rules! tell {
    ($($argument:tt)*) => {
        $crate::terminal::tell(format_args!($($argument)*))
    };
}

/// What [`tell!`] does.
pub fn tell(line: std::fmt::Arguments<'_>) {
    // There is no one left to tell that nothing can be told.
    let _ = writeln!(io::stderr(), "{line}");
}

/// Writes to standard output.
///
/// # Errors
/// When the system refuses, as when the disk is full; not when the reader is gone.
pub fn say(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

//! How a process notices the end of its parent: its standard input is a pipe that the parent holds open.

/// Calls `then` when standard input ends, as it does however the parent process ends.
pub fn on_parent_death(then: impl FnOnce() + Send + 'static) {
    std::thread::spawn(move || {
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        then();
    });
}

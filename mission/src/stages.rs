//! How long the stages of an agent-step take.
//!
//! Agents have no clock. They mark their stages with `tracing` spans, and [`StageLayer`], a layer of
//! the subscriber that the command installs, measures those spans. An agent runs on one thread at a
//! time, so a thread-local sum between the two ends of [`collect`] is that agent's. Without the layer
//! nothing is measured and nothing costs.

use std::cell::{Cell, RefCell};

use tracing::Subscriber;
use tracing::span::Id;
use tracing_subscriber::layer::{Context, Layer};
use tracing_subscriber::registry::LookupSpan;

use crate::timing::StageTimes;
use crate::timing::Stopwatch;

thread_local! {
    static TIMES: Cell<StageTimes> = const { Cell::new(StageTimes {
        render: None, sense: None, estimate: None, fuse: None, guidance: None,
    }) };
    static RUNNING: RefCell<Vec<Stopwatch>> = const { RefCell::new(Vec::new()) };
}

/// Runs `work` and returns what its stages took on this thread.
pub fn collect<T>(work: impl FnOnce() -> T) -> (T, StageTimes) {
    TIMES.set(StageTimes::default());
    let result = work();
    (result, TIMES.take())
}

/// Measures the spans that are named after a stage.
#[derive(Debug, Clone, Copy, Default)]
pub struct StageLayer;

impl<S: Subscriber + for<'a> LookupSpan<'a>> Layer<S> for StageLayer {
    fn on_enter(&self, _: &Id, _: Context<'_, S>) {
        RUNNING.with_borrow_mut(|running| running.push(Stopwatch::start()));
    }

    fn on_exit(&self, id: &Id, context: Context<'_, S>) {
        let Some(watch) = RUNNING.with_borrow_mut(Vec::pop) else { return };
        let name = context.span(id).map_or("", |span| span.name());
        let mut times = TIMES.get();
        if let Some(stage) = times.stage_mut(name) {
            *stage = Some(stage.unwrap_or(0.0) + watch.elapsed_ms());
        }
        TIMES.set(times);
    }
}

impl StageTimes {
    fn stage_mut(&mut self, name: &str) -> Option<&mut Option<f64>> {
        match name {
            "render" => Some(&mut self.render),
            "sense" => Some(&mut self.sense),
            "estimate" => Some(&mut self.estimate),
            "fuse" => Some(&mut self.fuse),
            "guidance" => Some(&mut self.guidance),
            _ => None,
        }
    }

    /// Adds what another part of the same agent-step took.
    pub fn add(&mut self, other: &StageTimes) {
        for name in ["render", "sense", "estimate", "fuse", "guidance"] {
            let more = *other.clone().stage_mut(name).expect("a stage");
            let stage = self.stage_mut(name).expect("a stage");
            *stage = match (*stage, more) {
                (Some(a), Some(b)) => Some(a + b),
                (a, b) => a.or(b),
            };
        }
    }
}

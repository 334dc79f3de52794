//! When the stages of a fit begin and end. The library asks no clock: what it tells on its way is enough to take
//! the time here.

use crate::io::process;
use crate::io::report::Stage;
use crate::prepositioning::{Event, Observer};
use std::time::Instant;

/// A point in time, by the clock on the wall and by what the processors have worked.
#[derive(Clone, Copy)]
pub struct Moment {
    wall: Instant,
    /// s, of all threads.
    cpu: Option<f64>,
}

impl Moment {
    pub fn now() -> Self {
        Self { wall: Instant::now(), cpu: process::cpu_seconds() }
    }

    /// What has passed since.
    pub fn stage(self, name: impl Into<String>) -> Stage {
        self.until(Self::now(), name)
    }

    fn until(self, end: Self, name: impl Into<String>) -> Stage {
        Stage {
            name: name.into(),
            wall_seconds: (end.wall - self.wall).as_secs_f64(),
            cpu_seconds: end.cpu.zip(self.cpu).map(|(end, start)| end - start),
        }
    }
}

/// Notes the stages of a fit, and hands on what it hears.
pub struct Stopwatch<O> {
    inner: O,
    /// When the present stage began.
    begun: Moment,
    stages: Vec<Stage>,
}

impl<O: Observer> Stopwatch<O> {
    /// To be called just before the fit.
    pub fn start(inner: O) -> Self {
        Self { inner, begun: Moment::now(), stages: Vec::new() }
    }

    /// To be called just after: what came after the last level was the assessment.
    pub fn stop(mut self) -> (O, Vec<Stage>) {
        self.lap("assessment");
        (self.inner, self.stages)
    }

    fn lap(&mut self, name: impl Into<String>) {
        let now = Moment::now();
        self.stages.push(self.begun.until(now, name));
        self.begun = now;
    }
}

impl<O: Observer> Observer for Stopwatch<O> {
    fn event(&mut self, event: &Event) {
        match event {
            Event::Arranged { .. } => self.lap("start-up"),
            Event::Sewn { .. } => self.lap("sewing"),
            Event::LevelDone { level, .. } => self.lap(format!("level {}", level + 1)),
            // The garment before was relaxed over those below and brought into order with them.
            Event::GarmentStarted { garment: 1.., .. } | Event::TogetherStarted { .. } => self.lap("layering"),
            Event::GarmentStarted { .. }
            | Event::LevelStarted { .. }
            | Event::Sewing { .. }
            | Event::Step { .. }
            | Event::Checked { .. } => {}
        }
        self.inner.event(event);
    }

    fn enough(&mut self) -> bool {
        self.inner.enough()
    }
}

//! The exchange that configures the receiver: a message, its acknowledgement, the next message.

use embedded_io::{Write, WriteReady};

use super::LinkCounts;
use super::config_messages::{Frame, Generation, message};
use crate::error::SensorError;

/// Time to wait for an acknowledgement before the message is sent again, microseconds. A receiver that was
/// still starting has lost it.
pub const ACKNOWLEDGE_US: u64 = 200_000;
/// Number of times that one message is sent before the driver gives up and begins again. They cover the
/// second that a receiver may take (section 3.3.2: "within one second"). An acknowledgement of any of them
/// counts.
pub const ATTEMPTS: u8 = 5;

/// The receiver's answer to a configuration message, with the message's class and id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    Acknowledged(u8, u8),
    Refused(u8, u8),
}

#[derive(Clone, Debug)]
enum State {
    /// The next message is to be sent.
    Idle,
    /// Part of the message has been sent.
    Sending {
        frame: Frame,
        sent: usize,
        class: u8,
        id: u8,
    },
    Awaiting {
        until_us: u64,
        class: u8,
        id: u8,
    },
    Configured,
}

#[derive(Clone, Debug)]
pub(super) struct Link {
    period_ms: u16,
    baud: u32,
    generation: Generation,
    place: u8,
    attempt: u8,
    begun: bool,
    state: State,
}

impl Link {
    pub(super) const fn new(period_ms: u16, baud: u32) -> Self {
        Self {
            period_ms,
            baud,
            generation: Generation::Keys,
            place: 0,
            attempt: 0,
            begun: false,
            state: State::Idle,
        }
    }

    pub(super) const fn is_configured(&self) -> bool {
        matches!(self.state, State::Configured)
    }

    /// Whether a configuration begins with this poll.
    pub(super) const fn begins(&self) -> bool {
        !self.begun
    }

    /// Forgets the acknowledgements. The generation that last worked is tried first.
    pub(super) fn restart(&mut self) {
        self.place = 0;
        self.attempt = 0;
        self.begun = false;
        self.state = State::Idle;
    }

    /// Takes an answer, and sends as much as fits without waiting.
    ///
    /// # Errors
    /// [`SensorError::NotAcknowledged`] when a receiver has refused both generations' messages;
    /// [`SensorError::Timeout`] when no answer came to the last attempt; [`SensorError::Bus`]. The
    /// configuration then begins again.
    pub(super) fn step<Port: Write + WriteReady>(
        &mut self,
        now_us: u64,
        answer: Option<Answer>,
        port: &mut Port,
        counts: &mut LinkCounts,
    ) -> Result<(), SensorError> {
        match &mut self.state {
            State::Configured => {}
            State::Idle => {
                let Some((class, id, frame)) =
                    message(self.generation, self.place, self.period_ms, self.baud)
                else {
                    self.state = State::Configured;
                    return Ok(());
                };
                self.begun = true;
                super::count(&mut counts.sent);
                self.state = State::Sending { frame, sent: 0, class, id };
            }
            State::Sending { frame, sent, class, id } => {
                while let Some(rest) = frame.get(*sent..)
                    && !rest.is_empty()
                    && port.write_ready().map_err(|_| SensorError::Bus)?
                {
                    match port.write(rest).map_err(|_| SensorError::Bus)? {
                        0 => break,
                        count => *sent += count,
                    }
                }
                if *sent >= frame.len() {
                    let until_us = now_us.saturating_add(ACKNOWLEDGE_US);
                    self.state = State::Awaiting { until_us, class: *class, id: *id };
                }
            }
            State::Awaiting { until_us, class, id } => match answer {
                Some(Answer::Acknowledged(of, which)) if (of, which) == (*class, *id) => {
                    self.place += 1;
                    self.attempt = 0;
                    self.state = State::Idle;
                }
                Some(Answer::Refused(of, which)) if (of, which) == (*class, *id) => {
                    super::count(&mut counts.refused);
                    let refused_both = self.generation == Generation::Messages;
                    self.generation = self.generation.other();
                    self.restart();
                    self.begun = !refused_both;
                    if refused_both {
                        return Err(SensorError::NotAcknowledged);
                    }
                }
                _ if now_us >= *until_us => {
                    super::count(&mut counts.timeouts);
                    self.attempt += 1;
                    self.state = State::Idle;
                    if self.attempt >= ATTEMPTS {
                        self.restart();
                        return Err(SensorError::Timeout);
                    }
                }
                _ => {}
            },
        }
        Ok(())
    }
}

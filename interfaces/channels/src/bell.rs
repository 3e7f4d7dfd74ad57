//! Bells: a component polls for a bounded time, giving way to others, then sleeps until a sender
//! rings.
//!
//! Polling alone starves the very process it waits for when there are more processes than cores;
//! sleeping alone costs a wake-up per message. Every component has one bell, and every sender rings
//! its receiver's bell after a send.

use crate::attachment::{Attachment, ChannelMedium, service_name};
use crate::error::ChannelError;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::{Notifier, NotifierNotifyError};
use iceoryx2::service::port_factory::event::PortFactory;
use std::time::{Duration, Instant};

/// Outcome of a wait.
#[derive(Debug, PartialEq, Eq)]
pub enum Wait<T> {
    /// The value that was waited for.
    Ready(T),
    /// It did not come in time.
    TimedOut,
}

/// A component's own bell.
#[derive(Debug)]
pub struct Bell<S: ChannelMedium> {
    listener: Listener<S>,
    poll: Duration,
    name: String,
}

/// Rings another component's bell.
#[derive(Debug)]
pub struct Ringer<S: ChannelMedium> {
    notifier: Notifier<S>,
    name: String,
}

fn bell_service<S: ChannelMedium>(
    attachment: &Attachment<S>,
    component: &str,
) -> Result<(String, PortFactory<S>), ChannelError> {
    let name = format!("bell/{component}");
    let service = attachment
        .node()
        .service_builder(&service_name(&name)?)
        .event()
        .max_listeners(1)
        // Room for the peers of many components: each may ring this bell.
        .max_notifiers(64)
        .max_nodes(64)
        .open_or_create()
        .map_err(|e| ChannelError::open(&name, e))?;
    Ok((name, service))
}

impl<S: ChannelMedium> Bell<S> {
    /// Hangs up the bell of `component`, which polls for `poll` before it sleeps.
    ///
    /// # Errors
    /// [`ChannelError::Open`].
    pub fn hang(
        attachment: &Attachment<S>,
        component: &str,
        poll: Duration,
    ) -> Result<Self, ChannelError> {
        let (name, service) = bell_service(attachment, component)?;
        let listener =
            service.listener_builder().create().map_err(|e| ChannelError::open(&name, e))?;
        Ok(Self { listener, poll, name })
    }

    /// Waits until `check` gives something, at most until `deadline`.
    ///
    /// `check` is tried again whenever the bell rings, and at least every 20 ms, so that a sender
    /// that died before it could ring is noticed all the same.
    ///
    /// # Errors
    /// Whatever `check` fails with.
    pub fn wait<T, E: From<ChannelError>>(
        &self,
        deadline: Instant,
        mut check: impl FnMut() -> Result<Option<T>, E>,
    ) -> Result<Wait<T>, E> {
        // A message that is there already costs no clock and no system call.
        if let Some(found) = check()? {
            return Ok(Wait::Ready(found));
        }
        let start = Instant::now();
        while start.elapsed() < self.poll {
            rustix::thread::sched_yield();
            if let Some(found) = check()? {
                return Ok(Wait::Ready(found));
            }
        }
        loop {
            let now = Instant::now();
            if now >= deadline {
                return Ok(Wait::TimedOut);
            }
            // At most 20 ms: a sender may have died between its send and its ring.
            self.rest((deadline - now).min(Duration::from_millis(20)))?;
            if let Some(found) = check()? {
                return Ok(Wait::Ready(found));
            }
        }
    }

    /// Sleeps until somebody rings, or a signal comes, at most `nap`; not at all if it was rung before.
    ///
    /// # Errors
    /// [`ChannelError::Failed`].
    pub fn rest(&self, nap: Duration) -> Result<(), ChannelError> {
        match self.listener.timed_wait(|_| {}, nap) {
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
            Err(why) => Err(ChannelError::failed(&self.name, why)),
        }
    }
}

impl<S: ChannelMedium> Ringer<S> {
    /// Connects to the bell of `component`.
    ///
    /// # Errors
    /// [`ChannelError::Open`].
    pub fn of(attachment: &Attachment<S>, component: &str) -> Result<Self, ChannelError> {
        let (name, service) = bell_service(attachment, component)?;
        let notifier =
            service.notifier_builder().create().map_err(|e| ChannelError::open(&name, e))?;
        Ok(Self { notifier, name })
    }

    /// Rings. A bell that still sounds from before counts as rung.
    ///
    /// # Errors
    /// [`ChannelError::Failed`] if the channel is broken.
    pub fn ring(&self) -> Result<(), ChannelError> {
        match self.notifier.notify() {
            Ok(_)
            // Both concern the clock of iceoryx2, and are found after the bell was rung.
            | Err(
                NotifierNotifyError::UnableToAcquireElapsedTime
                | NotifierNotifyError::MissedDeadline,
            ) => Ok(()),
            Err(why) => Err(ChannelError::failed(&self.name, why)),
        }
    }
}

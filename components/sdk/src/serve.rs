//! A component's life: hello, assignment, windows, end.

use crate::context::Context;
use crate::frames::Frames;
use crate::keep::StateKeeper;
use crate::line::ControlPipe;
use crate::place_teller::PlaceTeller;
use crate::role_adapter::RoleAdapter;
use crate::sent::SentMessages;
use crate::setup::Setup;
use crate::stop::Stop;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;
use tremie_channels::ChannelMedium;
use tremie_messages::INTERFACE_VERSION;
use tremie_messages::Role;
use tremie_messages::problem::Problem;
use tremie_messages::schedule::{Content, Op};
use tremie_messages::start::{
    Assignment, Description, Fault, FaultKind, Hello, InjectionKind, Reply, Request, Resume,
};
use tremie_state::{StateError, StateExchange};

/// Hello, assignment and description at the end of a component's introduction.
pub type Assigned = (Hello, Assignment, Description);

/// The hello and the assignment, or the end of a component that was refused or dismissed.
pub enum Introduction {
    /// Go on with this.
    Assigned(Box<Assigned>),
    /// The orchestrator wants nothing more.
    Dismissed,
}

/// Answers the hello and takes the assignment.
///
/// # Errors
/// A sentence for standard error: the orchestrator is gone, or speaks something else.
pub fn introduce(
    line: &mut ControlPipe,
    role: Role,
    program: &str,
    describe: impl Fn(&Setup) -> Result<Description, Vec<Problem>>,
) -> Result<Introduction, String> {
    let hello = match line.next_request()? {
        Request::Hello(hello) => *hello,
        Request::Quit {} => return Ok(Introduction::Dismissed),
        Request::Assignment(_) => return Err("an assignment came before the hello".into()),
    };
    let description = match accept(&hello, role, describe) {
        Ok(description) => Description { program: program.to_string(), ..description },
        Err(problems) => {
            line.reply(&Reply::Refusal { problems }).map_err(|e| e.to_string())?;
            return Ok(Introduction::Dismissed);
        }
    };
    line.reply(&Reply::Description(Box::new(description.clone()))).map_err(|e| e.to_string())?;
    match line.next_request()? {
        Request::Assignment(assignment) => {
            Ok(Introduction::Assigned(Box::new((hello, *assignment, description))))
        }
        Request::Quit {} => Ok(Introduction::Dismissed),
        Request::Hello(_) => Err("a second hello came instead of an assignment".into()),
    }
}

fn accept(
    hello: &Hello,
    role: Role,
    describe: impl Fn(&Setup) -> Result<Description, Vec<Problem>>,
) -> Result<Description, Vec<Problem>> {
    let key = format!("components.{}", hello.component);
    if hello.interface != INTERFACE_VERSION {
        let text = format!(
            "this component speaks interface version {INTERFACE_VERSION}, the orchestrator version {}",
            hello.interface
        );
        return Err(vec![
            Problem::new(key, text).help("build both from the same version of Tremie"),
        ]);
    }
    if hello.role != role {
        let text = format!("this program can be {role}, not {}", hello.role);
        return Err(vec![
            Problem::new(key, text).help("`tremie components` lists what can take which role"),
        ]);
    }
    let description = describe(&Setup { hello: hello.clone(), assignment: None })?;
    let tells_messages = role != Role::Observer;
    Ok(Description { interface: INTERFACE_VERSION, tells_messages, ..description })
}

/// Serves a physics component from the hello to the end.
///
/// # Errors
/// A sentence for standard error if the orchestrator is gone or speaks something else. Faults of
/// the physics are told to the orchestrator, and then come back as an error too.
pub fn serve<S: ChannelMedium, P: RoleAdapter<S>>(
    mut line: ControlPipe,
    (hello, assignment, description): Assigned,
) -> Result<(), String> {
    let setup = Setup { hello: hello.clone(), assignment: Some(assignment.clone()) };
    let created = catch_unwind(AssertUnwindSafe(|| P::create(&setup)))
        .unwrap_or_else(|panic| Err(vec![Problem::new("", panic_text(&*panic))]));
    let mut player = match created {
        Ok(player) => player,
        Err(problems) => {
            line.reply(&Reply::Refusal { problems }).map_err(|e| e.to_string())?;
            return Ok(());
        }
    };
    let mut keeper = StateKeeper::new(&hello, &description);
    let signals = description.signals.len();
    let flags = description.signals.iter().map(|signal| signal.sampled);
    let sampled: Vec<usize> =
        flags.enumerate().filter_map(|(k, sampled)| sampled.then_some(k)).collect();
    let mut places = PlaceTeller::of(&description, &assignment.watched);
    let values = signals + places.values();
    let mut context =
        match Context::<S>::open(hello.run, &hello.component, assignment, values, line) {
            Ok(context) => context,
            Err(failed) => {
                let (stop, mut line) = *failed;
                let fault = stop.into_fault(&hello.component, 0);
                return fault.map_or(Ok(()), |fault| tell_fault(&mut line, fault));
            }
        };
    let ended = catch_unwind(AssertUnwindSafe(|| {
        let told = Reported { signals, sampled: &sampled, places: &mut places };
        live(&mut player, &mut context, &mut keeper, told)
    }))
    .unwrap_or_else(|panic| {
        Err(context.fault(FaultKind::Solver, &context.component, panic_text(&*panic)))
    });
    let window = context.window;
    keeper.wait();
    match ended {
        Ok(last) => {
            let reply = Reply::Finished { window: last, note: String::new() };
            context.line().reply(&reply).map_err(|e| e.to_string())?;
            // Channels stay open until everybody has read what is in them.
            let _ = context.line().next_request();
            Ok(())
        }
        Err(stop) => match stop.into_fault(&hello.component, window) {
            None => Ok(()),
            Some(fault) => {
                let told = tell_fault(context.line(), fault);
                let _ = context.line().next_request();
                told
            }
        },
    }
}

fn tell_fault(line: &mut ControlPipe, fault: Fault) -> Result<(), String> {
    let text = fault.to_string();
    line.reply(&Reply::Fault(fault)).map_err(|e| e.to_string())?;
    Err(text)
}

/// Message of a panic, for a fault.
pub fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let said = panic
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("no message");
    format!("the solver panicked: {said}")
}

/// What a component reports in each window.
struct Reported<'a> {
    /// Number of its signals.
    signals: usize,
    /// Places among them of those that are not measured in every window.
    sampled: &'a [usize],
    /// Where those are that the run watches.
    places: &'a mut PlaceTeller,
}

/// From ready to the last window; returns that window.
fn live<S: ChannelMedium, P: RoleAdapter<S>>(
    player: &mut P,
    context: &mut Context<S>,
    keeper: &mut StateKeeper,
    Reported { signals, sampled, places }: Reported<'_>,
) -> Result<u64, Stop> {
    player.open(context)?;
    let resume = context.assignment.resume.clone();
    if let Some(resume) = resume.as_ref().filter(|_| P::keeps_state()) {
        put_back_state(player, context, keeper, resume)?;
    }
    let mut frames = Frames::open(context)?;
    let gone = |_| Stop::Aborted;
    context.line().reply(&Reply::Ready {}).map_err(gone)?;
    let first = match resume.as_ref().filter(|resume| !resume.bodies_only) {
        None => 0,
        Some(resume) if go_on(player, context, &mut frames, (resume.window, signals))? => {
            resume.window + 1
        }
        Some(_) => return Ok(context.window),
    };
    let (mut values, mut is_measured) = (Vec::new(), false);
    let script = context.assignment.script.clone();
    for window in first..=context.assignment.windows {
        let begin = Instant::now();
        if !context.may_start(window)? {
            break;
        }
        (context.window, context.substeps) = (window, 0);
        if let Some(kind) = context.injection() {
            // Whoever reads the log shall not look for a defect.
            tracing::warn!("commits the fault {kind} in window {window} on purpose");
        }
        if window == 0 {
            player.connect()?;
        } else {
            context.substeps = substeps_to_make(context, P::ends_inside())?;
        }
        play(player, context, if window == 0 { &script.start } else { &script.window })?;
        let keeps_row = context.keeps_row();
        is_measured = keeps_row || frames.show_signals(window);
        values.clear();
        player.signals(&mut values, is_measured);
        frames.send(context, player, &values);
        if !keeps_row && !sampled.is_empty() {
            // What is reported does not depend on who looks.
            is_measured = false;
            forget(&mut values, sampled);
        }
        places.push(&mut values, |signal| player.place(signal));
        if keeps_row {
            player.row_kept();
        }
        let work = player.work();
        context.send_report(begin, work, &values)?;
        values.truncate(signals);
        if context.keeps_state() {
            let replier = context.line().replier();
            let sent = context.sent.get_mut();
            keeper.keep(window, replier, |state| exchange_state(player, sent, state));
        }
    }
    // Only here is it known that the window was the last: a run may end before its plan does.
    if !is_measured && !sampled.is_empty() {
        values.clear();
        player.signals(&mut values, true);
    }
    frames.send_last(context, player, &values);
    Ok(context.window)
}

/// Takes the values of the `sampled` signals away.
fn forget(values: &mut [f64], sampled: &[usize]) {
    for &place in sampled {
        values.get_mut(place).into_iter().for_each(|value| *value = f64::NAN);
    }
}

/// Puts the state of a component back from a checkpoint.
fn put_back_state<S: ChannelMedium, P: RoleAdapter<S>>(
    player: &mut P,
    context: &mut Context<S>,
    keeper: &StateKeeper,
    resume: &Resume,
) -> Result<(), Stop> {
    let sent = context.sent.get_mut();
    let put_back = keeper.put_back(resume, |state| match resume.bodies_only {
        true => player.take_bodies(state),
        false => exchange_state(player, sent, state),
    });
    put_back.map_err(|error| context.fault(FaultKind::State, &context.component, error.to_string()))
}

/// Keeps the state of a component at a window's end, or puts it back: its own, and what observers
/// have not been sent yet.
fn exchange_state<S: ChannelMedium, P: RoleAdapter<S>>(
    player: &mut P,
    sent: &mut SentMessages,
    state: &mut StateExchange<'_>,
) -> Result<(), StateError> {
    player.exchange_state(state)?;
    sent.exchange(state)
}

/// In place of the start exchange: everything is as it was at the end of the checkpoint's window.
/// `false` if the run ends before the next.
fn go_on<S: ChannelMedium, P: RoleAdapter<S>>(
    player: &mut P,
    context: &mut Context<S>,
    frames: &mut Frames<S>,
    (window, signals): (u64, usize),
) -> Result<bool, Stop> {
    let may = context.may_start(window)?;
    (context.window, context.substeps) = (window, context.assignment.substeps);
    if may {
        player.connect()?;
        for op in context.assignment.script.resume.clone() {
            let Op::Send { edge } = op else { continue };
            let content: Content = context.assignment.edges[edge].content;
            player.send_again(context, content)?;
        }
        frames.send_again(context, player, signals);
    }
    Ok(may)
}

fn play<S: ChannelMedium, P: RoleAdapter<S>>(
    player: &mut P,
    context: &mut Context<S>,
    ops: &[Op],
) -> Result<(), Stop> {
    for op in ops {
        match *op {
            Op::Receive { edge, lag } => {
                let content = context.assignment.edges[edge].content;
                player.receive(context, content, lag)?;
            }
            Op::Advance => player.advance(context)?,
            Op::Send { edge } => {
                let content = context.assignment.edges[edge].content;
                player.send(context, content)?;
            }
        }
    }
    Ok(())
}

/// The assigned substeps, unless a fault is injected into this window. Ends the component there, if
/// that is the fault and it is not to be committed inside the window.
fn substeps_to_make<S: ChannelMedium>(
    context: &Context<S>,
    ends_inside: bool,
) -> Result<u32, Stop> {
    let assigned = context.assignment.substeps;
    match context.injection() {
        Some(InjectionKind::SubstepMore) => Ok(assigned + 1),
        Some(InjectionKind::SubstepLess) => Ok(assigned - 1),
        Some(kind) if !ends_inside => end_here(kind).map(|()| assigned),
        _ => Ok(assigned),
    }
}

/// Commits a fault that stops this component; does nothing where it is of another kind.
pub fn end_here(kind: InjectionKind) -> Result<(), Stop> {
    match kind {
        InjectionKind::Hang => loop {
            std::thread::park();
        },
        InjectionKind::Exit => std::process::exit(0),
        InjectionKind::Kill => {
            let _ = rustix::process::kill_process(
                rustix::process::getpid(),
                rustix::process::Signal::KILL,
            );
            Err(Stop::Aborted)
        }
        _ => Ok(()),
    }
}

use super::*;
use proptest::prelude::*;
use std::collections::VecDeque;

const BOTH: [(&str, Role); 2] = [("fluid", Role::Fluid), ("grains", Role::Grains)];
const TRIO: [(&str, Role); 3] =
    [("fluid", Role::Fluid), ("grains", Role::Grains), ("rubber", Role::Rubber)];
const DRY: [(&str, Role); 2] = [("grains", Role::Grains), ("rubber", Role::Rubber)];
const SCHEDULES: [Schedule; 2] = [Schedule::Serial, Schedule::Parallel];
const FLUID: usize = 0;
const GRAINS: usize = 1;

/// Carries scripts out step by step, as real components do, with channels of bounded depth;
/// advances that belong to an exchange inside the window message by message.
struct Play<'a> {
    wiring: &'a Wiring,
    /// Next operation of each member: window, index, and message inside an advance.
    at: Vec<(u64, usize, usize)>,
    channels: Vec<VecDeque<u64>>,
    most: Vec<usize>,
    windows: u64,
}

/// Contents of one side of the exchange inside a window, and whether it sends them. Two substeps,
/// of as many trials as it happens.
fn exchange(window: u64, is_grains: bool) -> Vec<(Content, bool)> {
    let mut messages = Vec::new();
    let substeps = if window == 0 { 0 } else { 2 };
    for substep in 0..substeps {
        messages.push((Content::Carrier, is_grains));
        for _ in 0..1 + (3 * window + 5 * substep) % 4 {
            messages.push((Content::Trial, !is_grains));
            messages.push((Content::Contact, is_grains));
        }
        // The accepted surface.
        messages.push((Content::Trial, !is_grains));
        messages.push((Content::Resultant, !is_grains));
    }
    if window == 0 { vec![(Content::Carrier, is_grains)] } else { messages }
}

impl<'a> Play<'a> {
    fn new(wiring: &'a Wiring, windows: u64) -> Self {
        Self {
            wiring,
            at: vec![(0, 0, 0); wiring.members.len()],
            channels: vec![VecDeque::new(); wiring.links.len()],
            most: vec![0; wiring.links.len()],
            windows,
        }
    }

    fn op(&mut self, member: usize) -> Option<Op> {
        loop {
            let (window, index, _) = self.at[member];
            if window > self.windows {
                return None;
            }
            let script = &self.wiring.members[member].script;
            let ops = if window == 0 { &script.start } else { &script.window };
            match ops.get(index) {
                Some(op) => return Some(*op),
                None => self.at[member] = (window + 1, 0, 0),
            }
        }
    }

    /// The channel of a content inside the window that the member has; and whether it is the
    /// sender.
    fn inside(&self, member: usize, content: Content) -> Option<(usize, bool)> {
        let link = self.wiring.links.iter().position(|link| link.content == content)?;
        let Link { from, to, .. } = self.wiring.links[link];
        (from == member || to == member).then_some((link, from == member))
    }

    /// True if the member could do its next operation; an error if a message is not the foretold
    /// one.
    fn step(&mut self, member: usize) -> Result<bool, String> {
        let Some(op) = self.op(member) else {
            return Ok(false);
        };
        let window = self.at[member].0;
        match op {
            Op::Advance => return self.advance(member, window),
            Op::Send { edge } => {
                let link = self.wiring.members[member].links[edge];
                if !self.send(link, window) {
                    return Ok(false);
                }
            }
            Op::Receive { edge, lag } => {
                let link = self.wiring.members[member].links[edge];
                let Some(found) = self.channels[link].pop_front() else {
                    return Ok(false);
                };
                if window.checked_sub(lag) != Some(found) {
                    return Err(format!("window {window}, lag {lag}, found {found}"));
                }
            }
        }
        self.next(member);
        Ok(true)
    }

    fn next(&mut self, member: usize) {
        let (window, index, _) = self.at[member];
        self.at[member] = (window, index + 1, 0);
    }

    fn send(&mut self, link: usize, window: u64) -> bool {
        if self.channels[link].len() as u64 >= self.wiring.links[link].depth {
            return false;
        }
        self.channels[link].push_back(window);
        self.most[link] = self.most[link].max(self.channels[link].len());
        true
    }

    fn advance(&mut self, member: usize, window: u64) -> Result<bool, String> {
        let Some((_, is_grains)) = self.inside(member, Content::Carrier) else {
            self.next(member);
            return Ok(true);
        };
        let messages = exchange(window, is_grains);
        let Some((content, sends)) = messages.get(self.at[member].2) else {
            self.next(member);
            return Ok(true);
        };
        let (link, is_sender) = self.inside(member, *content).unwrap();
        assert_eq!(is_sender, *sends);
        if is_sender {
            if !self.send(link, window) {
                return Ok(false);
            }
        } else {
            match self.channels[link].pop_front() {
                None => return Ok(false),
                Some(found) if found != window => return Err(format!("{window}, found {found}")),
                Some(_) => {}
            }
        }
        self.at[member].2 += 1;
        Ok(true)
    }

    /// Lets members take turns as `turns` says, over and over, until nobody can go on.
    fn run(&mut self, turns: &[usize]) -> Result<bool, String> {
        loop {
            let mut moved = false;
            for turn in turns.iter().copied().chain(0..self.at.len()) {
                moved |= self.step(turn % self.at.len())?;
            }
            if !moved {
                return Ok((0..self.at.len()).all(|member| self.op(member).is_none()));
            }
        }
    }
}

#[test]
fn scripts_are_those_of_the_protocol() {
    let wiring = wire(Schedule::Serial, &BOTH);
    let receive = |edge, lag| Op::Receive { edge, lag };
    let send = |edge| Op::Send { edge };
    let hear = vec![receive(EVENTS, 0), receive(STATE, 0), Op::Advance, send(LOAD)];
    assert_eq!(
        wiring.members[FLUID].script,
        Script { start: hear.clone(), window: hear.clone(), ..Script::default() }
    );
    let grains = Script {
        start: vec![send(EVENTS), send(STATE)],
        window: vec![receive(LOAD, 1), Op::Advance, send(EVENTS), send(STATE)],
        ..Script::default()
    };
    assert_eq!(wiring.members[GRAINS].script, grains);
    assert!(wiring.links.iter().all(|link| link.events_lag == 0));

    let wiring = wire(Schedule::Parallel, &BOTH);
    let window = vec![Op::Advance, send(LOAD), receive(EVENTS, 0), receive(STATE, 0)];
    assert_eq!(wiring.members[FLUID].script, Script { start: hear, window, ..Script::default() });
    assert_eq!(wiring.members[GRAINS].script, grains);
    assert_eq!(wiring.links[LOAD].events_lag, 1);
}

#[test]
fn a_run_that_goes_on_has_the_messages_of_the_next_window_under_way() {
    for schedule in SCHEDULES {
        for members in [&BOTH[..], &TRIO] {
            let wiring = wire(schedule, members).with_ports();
            for (member, of) in wiring.members.iter().enumerate() {
                let content = |op: &Op| match op {
                    Op::Send { edge } => wiring.links[of.links[*edge]].content,
                    other => panic!("{other:?}"),
                };
                let sent: Vec<_> = wiring.resume(member).iter().map(content).collect();
                let expected = match (member == FLUID, members.len()) {
                    (true, 2) => vec![Content::Ports, Content::Load],
                    (true, _) => vec![Content::Ports, Content::Load, Content::SurfaceLoad],
                    (false, _) => Vec::new(),
                };
                assert_eq!(sent, expected, "{schedule:?}, {}", of.name);
            }
        }
    }
}

#[test]
fn ports_travel_with_the_loads() {
    for schedule in SCHEDULES {
        for members in [&BOTH[..], &TRIO] {
            let plain = wire(schedule, members);
            let wiring = plain.clone().with_ports();
            check(&wiring).unwrap();
            let (load, ports) = (&wiring.links[LOAD], wiring.links.last().unwrap());
            assert_eq!(*ports, Link { content: Content::Ports, ..load.clone() });
            let [told, heard] = [FLUID, GRAINS].map(|m| wiring.members[m].links.len() - 1);
            let script = &wiring.members[FLUID].script;
            for ops in [&script.start, &script.window] {
                let at = ops.iter().position(|op| *op == Op::Send { edge: told }).unwrap();
                assert_eq!(ops[at + 1], Op::Send { edge: LOAD });
            }
            let ops = &wiring.members[GRAINS].script.window;
            assert_eq!(ops[0], Op::Receive { edge: heard, lag: 1 });
            assert_eq!(ops[1..], plain.members[GRAINS].script.window);
        }
        let alone = wire(schedule, &BOTH[..1]);
        assert_eq!(alone.clone().with_ports(), alone);
    }
}

#[test]
fn one_role_alone_just_advances() {
    for one in BOTH {
        let wiring = wire(Schedule::Parallel, &[one, ("viewer", Role::Observer)]);
        assert!(wiring.links.is_empty());
        assert_eq!(wiring.members[0].script.window, [Op::Advance]);
        assert_eq!(wiring.members[1].script, Script::default());
        check(&wiring).unwrap();
    }
}

#[test]
fn depth_is_what_is_needed_and_one_more() {
    for (schedule, needed) in [(Schedule::Serial, 1), (Schedule::Parallel, 2)] {
        let mut wiring = wire(schedule, &BOTH);
        check(&wiring).unwrap();
        assert!(wiring.links.iter().all(|link| link.depth == needed + 1));
        for link in &mut wiring.links {
            link.depth = needed;
        }
        check(&wiring).unwrap();
        wiring.links[LOAD].depth = needed - 1;
        let error = check(&wiring).unwrap_err();
        assert!(
            matches!(error, ScheduleError::Overflow { bound, .. } if bound == needed),
            "{error}"
        );
    }
}

#[test]
fn rubber_takes_part_as_fluid_and_grains_do() {
    let receive = |edge, lag| Op::Receive { edge, lag };
    let send = |edge| Op::Send { edge };
    for schedule in SCHEDULES {
        let wiring = wire(schedule, &TRIO);
        check(&wiring).unwrap();
        let content =
            |member: usize, edge: usize| wiring.links[wiring.members[member].links[edge]].content;
        let [fluid, grains, rubber] = [0, 1, 2].map(|m| wiring.members[m].script.clone());
        assert_eq!(rubber.start, [Op::Advance, send(4)]);
        assert_eq!(rubber.window, [receive(5, 1), Op::Advance, send(4)]);
        assert_eq!([content(2, 4), content(2, 5)], [Content::Surface, Content::SurfaceLoad]);
        assert_eq!(grains.start, [Op::Advance, send(EVENTS), send(STATE)]);
        assert_eq!(grains.window, [receive(LOAD, 1), Op::Advance, send(EVENTS), send(STATE)]);
        let hear = [receive(EVENTS, 0), receive(STATE, 0), receive(3, 0)];
        let work = [Op::Advance, send(LOAD), send(4)];
        assert_eq!([content(0, 3), content(0, 4)], [Content::Surface, Content::SurfaceLoad]);
        assert_eq!(fluid.start, [&hear[..], &work].concat());
        let parallel = schedule == Schedule::Parallel;
        let window = if parallel { [work, hear].concat() } else { [hear, work].concat() };
        assert_eq!(fluid.window, window);
        let load = wiring.links.iter().find(|link| link.content == Content::SurfaceLoad).unwrap();
        assert_eq!(load.events_lag, u64::from(parallel));
    }
    let dry = wire(Schedule::Serial, &DRY);
    check(&dry).unwrap();
    assert_eq!(dry.members[0].script, alone());
    assert_eq!(dry.members[1].script, alone());
    assert!(dry.links.iter().all(|link| link.content.is_inside_window() && link.depth == 3));
}

#[test]
fn an_exchange_inside_a_window_that_cannot_begin_is_named() {
    // The fluid wants the surface before it gives the loads of the window before; the rubber
    // advances only with the grains, which want those loads first.
    let mut wiring = wire(Schedule::Serial, &TRIO);
    let rubber = &mut wiring.members[2].script;
    rubber.start = vec![Op::Send { edge: 4 }, Op::Advance];
    rubber.window = vec![Op::Send { edge: 4 }, Op::Receive { edge: 5, lag: 1 }, Op::Advance];
    check(&wiring).unwrap();
    // And only after it has heard what the fluid finds with the grains' state of the same window.
    wiring.members[2].script.start.insert(1, Op::Receive { edge: 5, lag: 0 });
    wiring.members[2].script.window[1] = Op::Receive { edge: 5, lag: 0 };
    let ScheduleError::Deadlock { cycle } = check(&wiring).unwrap_err() else { panic!() };
    assert!(cycle.iter().any(|op| op.contains("surface_load")), "{cycle:?}");
    assert_eq!(Play::new(&wiring, 3).run(&[]), Ok(false));
    // An edge of the exchange is in no script, and each side advances once.
    let mut wiring = wire(Schedule::Serial, &DRY);
    wiring.members[0].script.window.push(Op::Send { edge: 0 });
    assert!(check(&wiring).unwrap_err().to_string().contains("exchange inside the window"));
    for script in [vec![], vec![Op::Advance; 2]] {
        let mut wiring = wire(Schedule::Serial, &DRY);
        wiring.members[1].script.window = script;
        assert!(check(&wiring).unwrap_err().to_string().contains("expected once"));
    }
    let mut wiring = wire(Schedule::Serial, &DRY);
    wiring.links[1].depth = 0;
    assert!(matches!(check(&wiring), Err(ScheduleError::Overflow { bound: 2, .. })));
}

#[test]
fn a_circle_of_waiting_is_named() {
    // The fluid's loads of a window need the state of that window, and grains wait for them.
    let mut wiring = wire(Schedule::Serial, &BOTH);
    wiring.members[GRAINS].script.start.push(Op::Receive { edge: LOAD, lag: 0 });
    wiring.members[GRAINS].script.window[0] = Op::Receive { edge: LOAD, lag: 0 };
    let error = check(&wiring).unwrap_err();
    let ScheduleError::Deadlock { cycle } = &error else { panic!("{error}") };
    assert!(cycle.contains(&"grains receives load".to_string()), "{error}");
    assert!(cycle.contains(&"fluid sends load".to_string()), "{error}");
    assert!(error.to_string().contains("which waits for"));
    assert_eq!(Play::new(&wiring, 3).run(&[]), Ok(false));
}

#[test]
fn a_missing_send_is_named() {
    for schedule in SCHEDULES {
        let mut wiring = wire(schedule, &BOTH);
        wiring.members[GRAINS].script.window.pop();
        let error = check(&wiring).unwrap_err().to_string();
        assert!(error.contains("grains -> fluid, state"), "{error}");
        let mut wiring = wire(schedule, &BOTH);
        wiring.members[FLUID].script.start.pop();
        assert!(check(&wiring).unwrap_err().to_string().contains("fluid -> grains, load"));
        let mut wiring = wire(schedule, &BOTH);
        wiring.members[FLUID].script.window.push(Op::Send { edge: 7 });
        assert!(matches!(check(&wiring), Err(ScheduleError::NoSuchEdge { edge: 7, .. })));
    }
}

proptest! {
    #[test]
    fn with_rubber_no_order_of_turns_locks_up_or_has_too_much_under_way(
        turns in prop::collection::vec(0usize..3, 0..40),
        parallel: bool,
        wet: bool,
        ports: bool,
    ) {
        let members = if wet { &TRIO[..] } else { &DRY[..] };
        let mut wiring = wire(SCHEDULES[usize::from(parallel)], members);
        if ports {
            wiring = wiring.with_ports();
        }
        let mut play = Play::new(&wiring, 20);
        prop_assert_eq!(play.run(&turns), Ok(true));
        for (link, most) in wiring.links.iter().zip(&play.most) {
            let bound = match link.content {
                Content::Carrier => INSIDE_BOUND as usize,
                content if content.is_inside_window() => 1,
                _ => 1 + usize::from(parallel),
            };
            prop_assert!(*most <= bound, "{:?}", link.content);
        }
    }

    #[test]
    fn no_order_of_turns_locks_up(turns in prop::collection::vec(0usize..2, 0..40), parallel: bool) {
        let wiring = wire(SCHEDULES[usize::from(parallel)], &BOTH);
        let mut play = Play::new(&wiring, 20);
        prop_assert_eq!(play.run(&turns), Ok(true));
        prop_assert!(play.most.iter().all(|most| *most <= 1 + usize::from(parallel)));
    }

    /// Whatever is swapped, dropped or doubled in a script: if the check accepts it, it runs in any
    /// order.
    #[test]
    fn what_the_check_accepts_runs(
        damage in prop::collection::vec((0usize..3, any::<bool>(), 0usize..3, 0usize..4, 0usize..4), 1..3),
        turns in prop::collection::vec(0usize..3, 0..20),
        parallel: bool,
        rubber: bool,
    ) {
        let members = if rubber { &TRIO[..] } else { &BOTH[..] };
        let mut wiring = wire(SCHEDULES[usize::from(parallel)], members);
        for (member, start, kind, a, b) in damage {
            let script = &mut wiring.members[member % members.len()].script;
            let ops = if start { &mut script.start } else { &mut script.window };
            if ops.is_empty() {
                continue;
            }
            let (a, b) = (a % ops.len(), b % ops.len());
            match kind {
                0 => ops.swap(a, b),
                1 => drop(ops.remove(a)),
                _ => ops.insert(b, ops[a]),
            }
        }
        let went = Play::new(&wiring, 12).run(&turns);
        match check(&wiring) {
            Ok(()) => prop_assert_eq!(went, Ok(true)),
            // Runs of twelve windows are too short for some faults; a lock-up shows at once.
            Err(ScheduleError::Deadlock { .. }) => prop_assert_eq!(went, Ok(false)),
            Err(_) => {}
        }
    }
}

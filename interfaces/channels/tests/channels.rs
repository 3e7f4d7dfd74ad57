//! Channels, bells and the places of a run, as their users see them.

use std::path::Path;
use std::sync::Barrier;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tremie_channels::sweep::{RunPlaces, shared_memory_of, sweep_dead_runs};
use tremie_channels::{
    Attachment, Bell, ChannelError, ChannelMedium, ChannelSpec, InProcess, Receiver, Ringer,
    Sender, SharedMemory, Wait,
};
use tremie_messages::Stamp;

const PATIENCE: Duration = Duration::from_millis(50);
const LONG: Duration = Duration::from_secs(10);

/// A number for a run that no other test has, of this process or another.
fn run_id() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    (u64::from(std::process::id()) << 32) | NEXT.fetch_add(1, Ordering::Relaxed)
}

fn places() -> RunPlaces {
    RunPlaces::create(run_id()).unwrap()
}

fn attach<S: ChannelMedium>(places: &RunPlaces, component: &str) -> Attachment<S> {
    Attachment::open(&places.root(), places.prefix(), component, PATIENCE).unwrap()
}

fn lossless(capacity: usize, depth: usize) -> ChannelSpec<'static> {
    ChannelSpec { service: "test", capacity, depth, borrowed: 2, lossless: true }
}

fn stamp(window: u64) -> Stamp {
    Stamp { run: 7, window, ticks: 3 * window, events: 1, substep: 2, iteration: 0 }
}

/// Makes both ends know each other: only a receiver that has looked once loses nothing.
fn meet<S: ChannelMedium>(sender: &Sender<S, Stamp, f64>, receiver: &Receiver<S, Stamp, f64>) {
    sender.connect().unwrap();
    assert!(receiver.take().unwrap().is_none());
}

fn messages_arrive_in_order<S: ChannelMedium>() {
    let places = places();
    let (one, other) = (attach::<S>(&places, "one"), attach::<S>(&places, "other"));
    let receiver = other.receiver::<Stamp, f64>(lossless(3, 2)).unwrap();
    let sender = one.sender::<Stamp, f64>(lossless(3, 2)).unwrap();
    meet(&sender, &receiver);
    for window in 0..10 {
        sender.send_copy(stamp(2 * window), &[1.0, window as f64, f64::INFINITY]).unwrap();
        let mut loan = sender.loan(1).unwrap();
        loan.values()[0] = -0.5;
        loan.send(stamp(2 * window + 1)).unwrap();

        let first = receiver.take().unwrap().unwrap();
        assert_eq!(*first.header(), stamp(2 * window));
        assert_eq!(first.values(), [1.0, window as f64, f64::INFINITY]);
        let second = receiver.take().unwrap().unwrap();
        assert_eq!((*second.header(), second.values()), (stamp(2 * window + 1), &[-0.5][..]));
        assert!(receiver.take().unwrap().is_none());
    }
    sender.send_copy(stamp(20), &[]).unwrap();
    assert!(receiver.take().unwrap().unwrap().values().is_empty());
}

#[test]
fn messages_arrive_in_order_between_processes() {
    messages_arrive_in_order::<SharedMemory>();
}

#[test]
fn messages_arrive_in_order_between_threads() {
    messages_arrive_in_order::<InProcess>();
}

fn what_is_left_to_do_with_a_message_waits_until_it_is_sent<S: ChannelMedium>() {
    let places = places();
    let (one, other) = (attach::<S>(&places, "one"), attach::<S>(&places, "other"));
    let receiver = other.receiver::<Stamp, f64>(lossless(3, 2)).unwrap();
    let sender = one.sender::<Stamp, f64>(lossless(3, 2)).unwrap();
    meet(&sender, &receiver);
    for window in 0..10 {
        let mut loan = sender.loan(2).unwrap();
        loan.values().copy_from_slice(&[0.5, window as f64]);
        let seen = sender.send_then(loan, stamp(window), |values| {
            let taken = receiver.take().unwrap().unwrap();
            assert_eq!((*taken.header(), taken.values()), (stamp(window), values));
            drop(taken);
            values.to_vec()
        });
        assert_eq!(seen.unwrap(), [0.5, window as f64]);
    }
    // Else it could be written to while it is read.
    let loan = sender.loan(1).unwrap();
    let loaned = std::panic::AssertUnwindSafe(|| {
        let _ = sender.send_then(loan, stamp(10), |_| sender.loan(1).map(|_| ()));
    });
    assert!(std::panic::catch_unwind(loaned).is_err());
}

#[test]
fn what_is_left_to_do_with_a_message_waits_until_it_is_sent_between_processes() {
    what_is_left_to_do_with_a_message_waits_until_it_is_sent::<SharedMemory>();
}

#[test]
fn what_is_left_to_do_with_a_message_waits_until_it_is_sent_between_threads() {
    what_is_left_to_do_with_a_message_waits_until_it_is_sent::<InProcess>();
}

#[test]
fn a_message_that_is_too_large_is_refused_with_both_sizes() {
    let places = places();
    let one = attach::<SharedMemory>(&places, "one");
    let sender = one.sender::<Stamp, f64>(lossless(3, 2)).unwrap();
    let error = sender.send_copy(stamp(0), &[0.0; 4]).unwrap_err();
    assert_eq!(error, ChannelError::Capacity { channel: "test".into(), found: 4, capacity: 3 });
    assert!(error.to_string().contains("4 values") && error.to_string().contains("for 3"));
}

#[test]
fn ends_that_disagree_on_the_size_do_not_open() {
    let places = places();
    let (one, other) =
        (attach::<SharedMemory>(&places, "one"), attach::<SharedMemory>(&places, "other"));
    let _sender = one.sender::<Stamp, f64>(lossless(3, 2)).unwrap();
    let refused = other.receiver::<Stamp, f64>(lossless(3, 4)).unwrap_err();
    assert!(matches!(refused, ChannelError::Open { .. }), "{refused}");
    let refused = other.receiver::<Stamp, u8>(lossless(3, 2)).unwrap_err();
    assert!(matches!(refused, ChannelError::Open { .. }), "{refused}");
}

fn a_full_channel_is_an_error_in_the_end<S: ChannelMedium>() {
    let places = places();
    let (one, other) = (attach::<S>(&places, "one"), attach::<S>(&places, "other"));
    let receiver = other.receiver::<Stamp, f64>(lossless(1, 2)).unwrap();
    let sender = one.sender::<Stamp, f64>(lossless(1, 2)).unwrap();
    meet(&sender, &receiver);
    sender.send_copy(stamp(0), &[0.0]).unwrap();
    sender.send_copy(stamp(1), &[1.0]).unwrap();
    let begin = Instant::now();
    let full = sender.send_copy(stamp(2), &[2.0]).unwrap_err();
    assert_eq!(full, ChannelError::Full { channel: "test".into() });
    assert!(begin.elapsed() >= PATIENCE, "gave up after {:?}", begin.elapsed());
    assert!(begin.elapsed() < LONG, "gave up after {:?}", begin.elapsed());

    // What was there is still there, and room makes the channel usable again.
    assert_eq!(receiver.take().unwrap().unwrap().values(), [0.0]);
    sender.send_copy(stamp(3), &[3.0]).unwrap();
    assert_eq!(receiver.take().unwrap().unwrap().values(), [1.0]);
    assert_eq!(receiver.take().unwrap().unwrap().values(), [3.0]);
}

#[test]
fn a_full_channel_is_an_error_in_the_end_between_processes() {
    a_full_channel_is_an_error_in_the_end::<SharedMemory>();
}

#[test]
fn a_full_channel_is_an_error_in_the_end_between_threads() {
    a_full_channel_is_an_error_in_the_end::<InProcess>();
}

#[test]
fn a_sender_waits_for_room_within_its_patience() {
    let places = places();
    let other = attach::<SharedMemory>(&places, "other");
    let receiver = other.receiver::<Stamp, f64>(lossless(1, 1)).unwrap();
    let (there, met) = (Barrier::new(2), Barrier::new(2));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let one =
                Attachment::<SharedMemory>::open(&places.root(), places.prefix(), "one", LONG);
            let sender = one.unwrap().sender::<Stamp, f64>(lossless(1, 1)).unwrap();
            sender.connect().unwrap();
            there.wait();
            met.wait();
            for window in 0..50 {
                sender.send_copy(stamp(window), &[window as f64]).unwrap();
            }
            // Its memory lives as long as the sender.
            std::thread::sleep(Duration::from_millis(100));
        });
        there.wait();
        assert!(receiver.take().unwrap().is_none());
        met.wait();
        let deadline = Instant::now() + LONG;
        let mut next = 0;
        while next < 50 {
            assert!(Instant::now() < deadline, "only {next} messages came");
            if let Some(message) = receiver.take().unwrap() {
                assert_eq!(message.header().window, next);
                next += 1;
            }
        }
    });
}

#[test]
fn a_lossy_channel_keeps_the_newest() {
    let places = places();
    let (one, other) =
        (attach::<SharedMemory>(&places, "one"), attach::<SharedMemory>(&places, "other"));
    let spec = ChannelSpec { lossless: false, ..lossless(1, 2) };
    let receiver = other.receiver::<Stamp, f64>(spec).unwrap();
    let sender = one.sender::<Stamp, f64>(spec).unwrap();
    let begin = Instant::now();
    for window in 0..100 {
        sender.send_copy(stamp(window), &[window as f64]).unwrap();
    }
    assert!(begin.elapsed() < PATIENCE * 20, "a sender waited on a lossy channel");
    assert_eq!(receiver.take().unwrap().unwrap().values(), [98.0]);
    assert_eq!(receiver.take().unwrap().unwrap().values(), [99.0]);
    assert!(receiver.take().unwrap().is_none());
}

fn a_bell_wakes_a_sleeper<S: ChannelMedium>() {
    let places = places();
    let rung = AtomicU64::new(0);
    std::thread::scope(|scope| {
        let sleeper = scope.spawn(|| {
            let attachment = attach::<S>(&places, "sleeper");
            let bell = Bell::hang(&attachment, "sleeper", Duration::ZERO).unwrap();
            let mut looks = 0;
            let ended = bell.wait(Instant::now() + LONG, || {
                looks += 1;
                let seen = rung.load(Ordering::SeqCst);
                Ok::<_, ChannelError>((seen > 0).then(|| (looks, Instant::now())))
            });
            ended.unwrap()
        });
        let attachment = attach::<S>(&places, "ringer");
        let ringer = Ringer::of(&attachment, "sleeper").unwrap();
        std::thread::sleep(Duration::from_millis(200));
        let begin = Instant::now();
        rung.store(1, Ordering::SeqCst);
        ringer.ring().unwrap();
        let Wait::Ready((looks, at)) = sleeper.join().unwrap() else { panic!("nobody woke it") };
        assert!(at.duration_since(begin) < LONG / 2);
        // It slept: one that polls looks many thousand times in 0.2 s.
        assert!(looks < 100, "it looked {looks} times");
    });
}

#[test]
fn a_bell_wakes_a_sleeping_process() {
    a_bell_wakes_a_sleeper::<SharedMemory>();
}

#[test]
fn a_bell_wakes_a_sleeping_thread() {
    a_bell_wakes_a_sleeper::<InProcess>();
}

fn a_rest_ends_when_the_bell_rings<S: ChannelMedium>() {
    let places = places();
    let attachment = attach::<S>(&places, "sleeper");
    let bell = Bell::hang(&attachment, "sleeper", Duration::ZERO).unwrap();
    let ringer = Ringer::of(&attachment, "sleeper").unwrap();
    let rested = || {
        let begin = Instant::now();
        bell.rest(PATIENCE).unwrap();
        begin.elapsed()
    };
    // Rung before: no rest at all, and one for both.
    (0..2).for_each(|_| ringer.ring().unwrap());
    assert!(rested() < PATIENCE);
    assert!(rested() >= PATIENCE);
    let begin = Instant::now();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let attachment = attach::<S>(&places, "ringer");
            let ringer = Ringer::of(&attachment, "sleeper").unwrap();
            std::thread::sleep(PATIENCE);
            ringer.ring().unwrap();
        });
        bell.rest(LONG).unwrap();
    });
    assert!(begin.elapsed() < LONG, "{:?}", begin.elapsed());
}

#[test]
fn a_rest_ends_when_another_process_rings() {
    a_rest_ends_when_the_bell_rings::<SharedMemory>();
}

#[test]
fn a_rest_ends_when_another_thread_rings() {
    a_rest_ends_when_the_bell_rings::<InProcess>();
}

#[test]
fn a_sleeper_looks_up_even_if_nobody_rings() {
    let places = places();
    let attachment = attach::<SharedMemory>(&places, "sleeper");
    let bell = Bell::hang(&attachment, "sleeper", Duration::ZERO).unwrap();
    let mut looks = 0;
    let ended = bell.wait(Instant::now() + LONG, || {
        looks += 1;
        Ok::<_, ChannelError>((looks == 4).then_some(()))
    });
    assert_eq!(ended.unwrap(), Wait::Ready(()));
}

#[test]
fn a_wait_times_out_and_passes_errors_on() {
    let places = places();
    let attachment = attach::<SharedMemory>(&places, "sleeper");
    let bell = Bell::hang(&attachment, "sleeper", Duration::from_micros(200)).unwrap();
    let begin = Instant::now();
    let ended = bell.wait(begin + PATIENCE, || Ok::<Option<()>, ChannelError>(None)).unwrap();
    assert_eq!(ended, Wait::TimedOut);
    assert!(begin.elapsed() >= PATIENCE && begin.elapsed() < LONG, "{:?}", begin.elapsed());

    let broken = ChannelError::Full { channel: "test".into() };
    let ended = bell.wait(Instant::now() + LONG, || Err::<Option<()>, _>(broken.clone()));
    assert_eq!(ended.unwrap_err(), broken);
}

#[test]
fn ringing_a_bell_that_is_not_heard_never_fails() {
    let places = places();
    let attachment = attach::<SharedMemory>(&places, "one");
    let _bell = Bell::hang(&attachment, "deaf", Duration::ZERO).unwrap();
    let ringer = Ringer::of(&attachment, "deaf").unwrap();
    for _ in 0..10_000 {
        ringer.ring().unwrap();
    }
}

#[test]
fn the_places_of_a_run_are_gone_with_it() {
    let run = run_id();
    let places = RunPlaces::create(run).unwrap();
    let root = places.root();
    let attachment = attach::<SharedMemory>(&places, "one");
    let sender = attachment.sender::<Stamp, f64>(lossless(3, 2)).unwrap();
    assert!(Path::new(&root).is_dir());
    // More than the file that says that the run lives.
    assert!(shared_memory_of(run) > 1);
    // As a component that was killed leaves them: nothing is given back.
    std::mem::forget((sender, attachment));
    drop(places);
    assert!(!Path::new(&root).exists());
    assert_eq!(shared_memory_of(run), 0);
}

#[test]
fn a_sweep_takes_the_dead_and_spares_the_living() {
    let (dead, alive) = (run_id(), run_id());
    let living = RunPlaces::create(alive).unwrap();
    let attachment = attach::<SharedMemory>(&living, "one");
    let _sender = attachment.sender::<Stamp, f64>(lossless(3, 2)).unwrap();
    let there = shared_memory_of(alive);
    let folder = leave_behind(dead);
    assert!(shared_memory_of(dead) > 0);

    // A sweep of another program may come first; then there is nothing left for this one.
    sweep_dead_runs().unwrap();
    assert!(!folder.exists());
    assert_eq!(shared_memory_of(dead), 0);
    assert!(Path::new(&living.root()).is_dir());
    assert_eq!(shared_memory_of(alive), there);
    assert!(there > 1);
}

#[test]
fn a_sweep_spares_memory_of_a_run_whose_folder_it_does_not_see() {
    // As in two containers that share memory and have folders of their own.
    let run = run_id();
    let living = RunPlaces::create(run).unwrap();
    let folder = living.root();
    let unseen = format!("{folder}.unseen");
    let [memory, claim] =
        ["made", "claim"].map(|name| format!("/dev/shm/{}{name}", living.prefix()));
    std::fs::write(&memory, "made").unwrap();
    std::fs::rename(&folder, &unseen).unwrap();
    sweep_dead_runs().unwrap();
    assert!(Path::new(&memory).exists());
    std::fs::rename(&unseen, &folder).unwrap();
    drop(living);
    // What a run left that was killed there is swept.
    std::fs::write(&memory, "made").unwrap();
    std::fs::write(&claim, "").unwrap();
    sweep_dead_runs().unwrap();
    assert!(!Path::new(&memory).exists());
    assert_eq!(shared_memory_of(run), 0);
}

/// Leaves folder and memory of a run `run` as if it had been killed; returns the folder.
fn leave_behind(run: u64) -> std::path::PathBuf {
    let places = RunPlaces::create(run).unwrap();
    let (root, memory) = (places.root(), format!("/dev/shm/{}left", places.prefix()));
    // In order, this removes the folder and frees the lock.
    drop(places);
    std::fs::create_dir(&root).unwrap();
    std::fs::File::create(Path::new(&root).join("lock")).unwrap();
    std::fs::write(memory, "left").unwrap();
    root.into()
}

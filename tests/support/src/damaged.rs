//! Damaged input for whoever reads bytes of others: files of users, lines and messages of programs.
//!
//! Inputs that are whole, or once broke something, are damaged at random places, over and over. What
//! the reader says of an input, its numbers left out, tells how far it came; an input that makes it say
//! something new is damaged in turn. So the search goes deeper by itself, without an instrumented
//! build. All is drawn from a seed: a try repeats.

use crate::most_bytes;
use crate::mutation::damage;
use crate::random::Random;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Time between looks at a reader, and the most of them at one input; then it hangs. A minute: machines
/// may be busy.
const LOOK: Duration = Duration::from_millis(5);
const MOST_LOOKS: u64 = 12_000;
/// Most inputs that are damaged in turn.
const MOST_INPUTS: usize = 4000;

/// A reader of bytes that come from others, and whole inputs for it.
pub struct DamagedInput<'a> {
    /// Name of the reader.
    pub name: &'a str,
    /// Whole inputs, and those that once broke it.
    pub inputs: Vec<Vec<u8>>,
    /// Words that may stand in an input.
    pub words: &'a [&'a str],
    /// Reads an input; returns what it says of it.
    pub read: &'a dyn Fn(&[u8]) -> String,
    /// Most memory that reading takes at a time [bytes]: always, and for each byte of the input.
    pub memory: [usize; 2],
}

/// Files of a folder, in the order of their names.
///
/// # Panics
/// If there are none.
pub fn inputs(folder: &Path) -> Vec<Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("a folder of inputs");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} holds no inputs", folder.display());
    files.iter().map(|file| std::fs::read(file).expect("a file")).collect()
}

impl DamagedInput<'_> {
    /// Tries all inputs as they are, and then so many that are damaged.
    ///
    /// # Panics
    /// If the reader panics, hangs, or takes too much memory; the input is kept in a file, whose name is
    /// told.
    pub fn try_many(&self, count: u64) {
        let watched = Watched::default();
        std::thread::scope(|scope| {
            let _end = EndOfWatch(&watched);
            scope.spawn(|| watched.watch(self.name));
            self.try_all(count, &watched);
        });
    }

    fn try_all(&self, count: u64, watched: &Watched) {
        let mut inputs = self.inputs.clone();
        let mut said: BTreeSet<String> = BTreeSet::new();
        for input in &self.inputs {
            said.insert(self.try_one(input, watched));
        }
        let mut random = Random(20_261_128);
        let begin = Instant::now();
        for done in 0..count {
            let mut input = random.one(&inputs).clone();
            let other = random.one(&inputs).clone();
            damage(&mut input, &other, self.words, &mut random);
            if said.insert(self.try_one(&input, watched)) && inputs.len() < MOST_INPUTS {
                inputs.push(input);
            }
            if (done + 1).is_multiple_of(100_000) {
                let (name, seconds) = (self.name, begin.elapsed().as_secs());
                println!("{name}: {} inputs, {} answers, {seconds} s", done + 1, said.len());
            }
        }
    }

    /// Reads one input; returns what the reader says of it, as far as another input may say it too.
    fn try_one(&self, input: &[u8], watched: &Watched) -> String {
        watched.begin(input);
        match self.fault_of(input) {
            Ok(said) => said,
            Err(fault) => {
                let small = self.smaller(input);
                let file = keep(self.name, &small);
                panic!("{}: {fault}\nthe input is in {}", self.name, file.display());
            }
        }
    }

    fn fault_of(&self, input: &[u8]) -> Result<String, String> {
        let mut said = Ok(String::new());
        let most = most_bytes(|| {
            said = catch_unwind(AssertUnwindSafe(|| without_numbers(&(self.read)(input))));
        });
        let [always, for_each] = self.memory;
        let allowed = always + for_each * input.len();
        match said {
            Err(_) => Err("it panics".into()),
            Ok(_) if most > allowed => Err(format!(
                "it takes {most} bytes for an input of {}, expected {allowed} at most",
                input.len()
            )),
            Ok(said) => Ok(said),
        }
    }

    /// A smaller input with a fault.
    fn smaller(&self, input: &[u8]) -> Vec<u8> {
        let mut small = input.to_vec();
        let mut piece = small.len() / 2;
        let end = Instant::now() + Duration::from_secs(20);
        while piece > 0 && Instant::now() < end {
            let mut at = 0;
            while at < small.len() && Instant::now() < end {
                let mut without = small.clone();
                without.drain(at..(at + piece).min(small.len()));
                if self.fault_of(&without).is_err() {
                    small = without;
                } else {
                    at += piece;
                }
            }
            piece /= 2;
        }
        small
    }
}

/// What a reader says, without what it quotes of an input and without numbers.
fn without_numbers(said: &str) -> String {
    let mut is_quoted = false;
    let mut keeps = |c: char| {
        is_quoted ^= c == '"';
        !is_quoted && !c.is_ascii_digit()
    };
    said.chars().filter(|c| keeps(*c)).take(400).collect()
}

fn keep(name: &str, input: &[u8]) -> PathBuf {
    let name: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
    let file = std::env::temp_dir().join(format!("tremie-{name}-{}", std::process::id()));
    std::fs::write(&file, input).expect("a file");
    file
}

/// The input that is being read, with its number, for who watches that it does not take for ever.
#[derive(Default)]
struct Watched {
    input: Mutex<(u64, Vec<u8>)>,
    is_over: AtomicBool,
}

struct EndOfWatch<'a>(&'a Watched);

impl Drop for EndOfWatch<'_> {
    fn drop(&mut self) {
        self.0.is_over.store(true, Relaxed);
    }
}

impl Watched {
    fn begin(&self, input: &[u8]) {
        if let Ok(mut reading) = self.input.lock() {
            *reading = (reading.0 + 1, input.to_vec());
        }
    }

    fn watch(&self, name: &str) {
        // Looks are counted, not time: the whole program may have been stopped for a while.
        let (mut last, mut looks) = (0, 0);
        while !self.is_over.load(Relaxed) {
            std::thread::sleep(LOOK);
            let Ok(reading) = self.input.lock() else { return };
            looks = if reading.0 == last { looks + 1 } else { 0 };
            last = reading.0;
            if looks > MOST_LOOKS {
                let file = keep(name, &reading.1);
                // The thread that hangs cannot be ended otherwise.
                eprintln!("{name}: it does not end\nthe input is in {}", file.display());
                std::process::abort();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reader(read: &dyn Fn(&[u8]) -> String) -> DamagedInput<'_> {
        let inputs = vec![b"one 1 two 2".to_vec()];
        DamagedInput { name: "test", inputs, words: &["three"], read, memory: [1 << 20, 100] }
    }

    #[test]
    fn a_reader_that_panics_behind_three_words_is_found() {
        let read = |bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            let known =
                ["three", "4294967296", "1"].iter().take_while(|w| text.contains(**w)).count();
            assert!(known < 3 || text.contains("two"), "found");
            ["none", "a", "b", "c"][known].to_string()
        };
        let found = catch_unwind(AssertUnwindSafe(|| reader(&read).try_many(100_000)));
        let text = *found.unwrap_err().downcast::<String>().unwrap();
        assert!(text.contains("it panics"), "{text}");
        let file = text.rsplit(' ').next().unwrap();
        let kept = std::fs::read(file).unwrap();
        std::fs::remove_file(file).unwrap();
        // Made as small as it can be.
        assert_eq!(kept.len(), "three4294967296".len() + 1, "{}", String::from_utf8_lossy(&kept));
    }

    #[test]
    fn a_reader_that_bears_everything_is_read_to_the_end() {
        let count = std::cell::Cell::new(0);
        let read = |_: &[u8]| {
            count.set(count.get() + 1);
            String::new()
        };
        reader(&read).try_many(500);
        assert_eq!(count.get(), 501);
    }
}

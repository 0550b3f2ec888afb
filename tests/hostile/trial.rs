//! One damaged file and what its reader makes of it: a value or an error that names it, in time and within memory.

use crate::readers::Reader;
use peak_alloc::PeakAlloc;
use std::cell::RefCell;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, Once};
use std::time::{Duration, Instant};
use tempfile::TempDir;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// What reading takes beside the file, bytes.
const BASE: usize = 256 << 20;
/// What it takes for a byte of the file: numbers as f64 with a direction to each.
const SHARE: usize = 20;
/// A read that takes this long hangs.
const HANGS: Duration = Duration::from_secs(90);

thread_local! {
    static PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}
static RUNNING: Mutex<Vec<(PathBuf, Instant)>> = Mutex::new(Vec::new());
/// One test at a time: memory is that of the process.
pub static ALONE: Mutex<()> = Mutex::new(());

/// A folder with a valid file of a reader.
pub struct Trial {
    pub reader: &'static Reader,
    folder: TempDir,
    pub path: PathBuf,
    pub valid: Vec<u8>,
}

impl Trial {
    pub fn new(reader: &'static Reader) -> Self {
        watch();
        let folder = tempfile::Builder::new().prefix(reader.name).tempdir().unwrap();
        let path = folder.path().join(reader.file);
        (reader.make)(&path);
        (reader.read)(&path).unwrap_or_else(|e| panic!("{}: the valid file: {e}", reader.name));
        let valid = std::fs::read(&path).unwrap();
        Self { reader, folder, path, valid }
    }

    /// Reads the file as it lies there: whether it was accepted, or what is wrong with the reader.
    pub fn read(&self) -> Result<bool, String> {
        RUNNING.lock().unwrap().push((self.path.clone(), Instant::now()));
        let outcome = catch_unwind(AssertUnwindSafe(|| (self.reader.read)(&self.path)));
        RUNNING.lock().unwrap().retain(|(path, _)| *path != self.path);
        match outcome {
            Ok(Ok(())) => Ok(true),
            Ok(Err(error)) => {
                let message = error.to_string();
                let named = message.contains(&*self.folder.path().to_string_lossy());
                if named { Ok(false) } else { Err(format!("the file is not named: {message}")) }
            }
            Err(_) => Err(PANIC.with_borrow_mut(std::mem::take)),
        }
    }

    /// Reads these bytes.
    pub fn read_bytes(&self, bytes: &[u8]) -> Result<bool, String> {
        std::fs::write(&self.path, bytes).unwrap();
        self.read()
    }

    /// Most memory that a file of this size may take.
    pub fn cap(&self) -> usize {
        BASE + SHARE * self.valid.len()
    }
}

/// Most memory that `work` held at a time beyond what was held before.
pub fn peak<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = HEAP.current_usage();
    HEAP.reset_peak_usage();
    let made = work();
    (made, HEAP.peak_usage().saturating_sub(before))
}

/// Not println: the test runner would keep it to itself.
pub fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Keeps an input that failed, for `fixtures/broken`.
pub fn keep(reader: &Reader, fault: &str, path: &Path) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("broken");
    std::fs::create_dir_all(&folder).unwrap();
    let kept = folder.join(format!("{}--{fault}.{}", reader.name, reader.file));
    let _ = std::fs::copy(path, &kept);
    kept
}

/// Panics are told by who caught them; what hangs ends the process with its file named (and left there).
fn watch() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        std::panic::set_hook(Box::new(|info| {
            let text = info.to_string();
            PANIC.with_borrow_mut(|kept| kept.clone_from(&text));
            // A test's own panic is not caught by a trial.
            if RUNNING.lock().map(|running| running.is_empty()).unwrap_or(true) {
                say(&text);
            }
        }));
        std::thread::spawn(|| {
            loop {
                std::thread::sleep(Duration::from_secs(1));
                let running = RUNNING.lock().unwrap();
                if let Some((path, _)) = running.iter().find(|(_, since)| since.elapsed() > HANGS) {
                    say(&format!("HANGS: {}", path.display()));
                    std::process::abort();
                }
            }
        });
    });
}

//! The reader that this target is named after, on whatever libFuzzer thinks of, from its small valid file on.
#![no_main]

#[path = "../tests/hostile/readers.rs"]
mod readers;

use libfuzzer_sys::fuzz_target;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const NAME: &str = env!("CARGO_BIN_NAME");

/// Where the file lies that is damaged, beside what it names.
static FILE: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = std::env::temp_dir().join(format!("carpaint-fuzz-{NAME}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join(reader().file);
    (reader().make)(&file);
    file
});

fn reader() -> &'static readers::Reader {
    readers::named(NAME).expect("a reader")
}

fuzz_target!(
    init: {
        let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(NAME);
        std::fs::create_dir_all(&corpus).expect("a folder");
        std::fs::copy(&*FILE, corpus.join("valid")).expect("a valid file");
    },
    |bytes: &[u8]| {
        std::fs::write(&*FILE, bytes).expect("writes");
        let _ = (reader().read)(&FILE);
    }
);

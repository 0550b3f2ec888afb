//! The adapter that tests run on, and how they say so.

use carpaint::gpu::Gpu;
use std::io::Write;
use std::sync::OnceLock;

/// Opened once: tests run side by side. None, loudly, where there is no adapter; with `CARPAINT_REQUIRE_GPU` that is a failure.
pub fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Option<Gpu>> = OnceLock::new();
    let open = || match Gpu::new(None) {
        Ok(gpu) => {
            say(&format!("GPU adapter: {}", gpu.name()));
            Some(gpu)
        }
        Err(e) => {
            assert!(
                std::env::var_os("CARPAINT_REQUIRE_GPU").is_none(),
                "CARPAINT_REQUIRE_GPU is set, but {e}"
            );
            say("SKIPPED: no GPU adapter, nothing compared");
            None
        }
    };
    GPU.get_or_init(open).as_ref()
}

/// Not eprintln: the test runner would keep it to itself.
pub fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

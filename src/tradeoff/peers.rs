//! Other people's tools, where Python has them: each is a process that stays, so that loading it is not timed.
//!
//! `CARPAINT_PYTHON` names the interpreter, else it is `python3`.

use crate::error::{Error, Result};
use serde_json::Value;
use std::cell::RefCell;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

/// Reads the problem, which a script makes ready for its `run()`; then, for every line, says how long a run took, and its numbers.
const BEFORE: &str = "import json, sys, time, warnings\nwarnings.simplefilter('ignore')\nproblem = json.loads(sys.stdin.readline())\n";
const AFTER: &str = r#"
run()
print("ready", flush=True)
for _ in sys.stdin:
    start = time.perf_counter()
    numbers = run()
    print(json.dumps([time.perf_counter() - start, numbers]), flush=True)
"#;

/// A tool in Python.
pub struct Peer {
    name: &'static str,
    process: RefCell<Process>,
}

struct Process {
    child: Child,
    asks: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Peer {
    /// Starts a script that defines `run()`, which solves `problem` and gives a list of numbers; None where Python or one of its
    /// packages is missing.
    pub fn start(name: &'static str, script: &str, problem: &Value) -> Option<Self> {
        let python = std::env::var_os("CARPAINT_PYTHON").unwrap_or_else(|| "python3".into());
        let mut child = Command::new(python)
            .args(["-c", &format!("{BEFORE}{script}{AFTER}")])
            // As fair as it gets: ours solve one problem on one thread, too.
            .env("OMP_NUM_THREADS", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let (asks, answers) = (child.stdin.take()?, BufReader::new(child.stdout.take()?));
        let mut process = Process { child, asks, answers };
        let ready = process.ask(&problem.to_string()).is_ok_and(|line| line.trim() == "ready");
        ready.then(|| Self { name, process: RefCell::new(process) })
    }

    /// Name for people.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// One run: its numbers, and the time it took.
    ///
    /// # Errors
    /// A script that ended, or says something else.
    pub fn run(&self) -> Result<(Vec<f64>, Duration)> {
        let answer = self.process.borrow_mut().ask("").unwrap_or_default();
        let parsed = serde_json::from_str::<(f64, Vec<f64>)>(&answer).ok();
        let timed =
            parsed.and_then(|(seconds, numbers)| Some((numbers, Duration::try_from_secs_f64(seconds).ok()?)));
        timed.ok_or_else(|| Error::invalid(self.name, "answer", answer.trim(), "a time and numbers, as JSON"))
    }
}

impl Process {
    fn ask(&mut self, line: &str) -> std::io::Result<String> {
        writeln!(self.asks, "{line}")?;
        self.asks.flush()?;
        let mut answer = String::new();
        self.answers.read_line(&mut answer)?;
        Ok(answer)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // Ended already, perhaps.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_peer_answers_as_often_as_it_is_asked_or_is_not_there() {
        assert!(Peer::start("none", "import no_such_package_at_all", &json!(1)).is_none());
        let Some(peer) = Peer::start("sum", "def run(): return [float(sum(problem))]", &json!([1, 2, 4]))
        else {
            println!("SKIPPED: no Python");
            return;
        };
        for _ in 0..2 {
            assert_eq!(peer.run().unwrap().0, [7.0]);
        }
        let wrong = Peer::start("wrong", "def run(): return 'seven'", &json!(1)).unwrap();
        let said = wrong.run().unwrap_err().to_string();
        assert!(said.contains("wrong") && said.contains("seven"), "{said}");
    }
}

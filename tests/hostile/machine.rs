//! Faults of the machine, through the program: odd names, outputs that cannot be written, disks that are full, processes that are
//! killed in the middle of a write, and two that write the same file.

use crate::common::carpaint;
use crate::mutation::Draw;
use crate::readers::named;
use crate::trial::say;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant, SystemTime};
use tempfile::TempDir;

/// A folder with a mix of two paints, an image and a measured table.
struct Place {
    folder: TempDir,
    inside: PathBuf,
}

impl Place {
    fn new(name: impl AsRef<OsStr>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join(name.as_ref());
        std::fs::create_dir(&inside).unwrap();
        let place = Self { folder, inside };
        for (reader, file) in
            [("paint", "p.paint.exr"), ("mix", "m.paint.exr"), ("png", "i.png"), ("mbsdf", "t.mbsdf")]
        {
            (named(reader).unwrap().make)(&place.at(file));
        }
        place
    }

    fn at(&self, name: impl AsRef<OsStr>) -> PathBuf {
        self.inside.join(name.as_ref())
    }

    fn names(&self) -> Vec<OsString> {
        let mut names: Vec<_> =
            std::fs::read_dir(&self.inside).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    }

    fn temporaries(&self) -> Vec<PathBuf> {
        let is_temporary = |name: &OsString| name.to_string_lossy().ends_with(".part");
        self.names().into_iter().filter(is_temporary).map(|name| self.at(name)).collect()
    }

    /// Blends at these weights.
    fn blend(&self, weights: &str, output: &Path) -> Vec<OsString> {
        let mut words = vec![OsString::from("blend"), self.at("m.paint.exr").into()];
        words.extend([format!("--weights={weights}").into(), "-o".into(), output.into()]);
        words
    }
}

fn run(words: &[OsString]) -> Output {
    carpaint().args(words).output().unwrap()
}

fn said(out: &Output) -> String {
    String::from_utf8_lossy(&out.stderr).into_owned()
}

fn succeeds(words: &[OsString]) {
    let out = run(words);
    assert!(out.status.success(), "{words:?}: {}", said(&out));
}

/// Exit code 2 and the output named.
fn refuses(out: &Output, output: &Path, what: &str) {
    let text = said(out);
    assert_eq!(out.status.code(), Some(2), "{what}: {text}");
    assert!(text.contains(&*output.to_string_lossy()) && !text.contains("panicked"), "{what}: {text}");
}

fn words(list: &[&dyn AsRef<OsStr>]) -> Vec<OsString> {
    list.iter().map(|word| (*word).as_ref().to_owned()).collect()
}

/// Commands that write a file each, to this name without its ending.
fn writers(place: &Place, output: &Path) -> Vec<(Vec<OsString>, PathBuf)> {
    let ending = |end: &str| {
        let mut name = output.as_os_str().to_owned();
        name.push(end);
        PathBuf::from(name)
    };
    let (paint, picture) = (ending(".paint.exr"), ending(".png"));
    vec![
        (place.blend("0.25,0.75", &paint), paint.clone()),
        (words(&[&"couple", &place.at("p.paint.exr"), &place.at("p.paint.exr"), &"-o", &paint]), paint),
        (words(&[&"halftone", &place.at("i.png"), &"-o", &picture]), picture),
    ]
}

/// A name that no text can hold.
#[cfg(unix)]
fn odd() -> OsString {
    use std::os::unix::ffi::OsStringExt;
    OsString::from_vec(b"no text \xff\xfe, \xc3\xa4 and $HOME".to_vec())
}

#[cfg(unix)]
#[test]
fn odd_names_are_names() {
    let place = Place::new(odd());
    let mut runs = 0;
    for (words, output) in writers(&place, &place.at(odd())) {
        succeeds(&words);
        assert!(output.exists(), "{words:?}");
        std::fs::remove_file(output).unwrap();
        runs += 1;
    }
    // Files of such names, and those that a scene names beside itself.
    for (from, to) in [("p.paint.exr", ".paint.exr"), ("i.png", ".png"), ("t.mbsdf", ".mbsdf")] {
        let mut name = odd();
        name.push(to);
        std::fs::copy(place.at(from), place.at(name)).unwrap();
    }
    let file = |end: &str| {
        let mut name = odd();
        name.push(end);
        place.at(name)
    };
    std::fs::copy("fixtures/scenes/studio.exr", place.at("the studio.exr")).unwrap();
    std::fs::write(file(".toml"), "[environment]\nkind = \"image\"\npath = \"the studio.exr\"\n").unwrap();
    let mix = place.at("of odd names.paint.exr");
    for words in [
        words(&[&"inspect", &file(".paint.exr")]),
        words(&[&"inspect", &file(".mbsdf")]),
        words(&[&"compare", &file(".png"), &place.at("i.png")]),
        words(&[&"couple", &file(".paint.exr"), &place.at("p.paint.exr"), &"-o", &mix]),
        words(&[&"inspect", &"--json", &mix]),
        words(&[
            &"render",
            &file(".paint.exr"),
            &"--scene",
            &file(".toml"),
            &"--size",
            &"8x8",
            &"--device",
            &"cpu",
            &"-o",
            &place.at("x.png"),
        ]),
    ] {
        succeeds(&words);
        runs += 1;
    }
    // What is refused is named as far as text can.
    std::fs::write(file(".paint.exr"), "no paint").unwrap();
    refuses(&run(&words(&[&"inspect", &file(".paint.exr")])), &file(".paint.exr"), "odd name");
    say(&format!("odd names: {} runs", runs + 1));
}

/// Every writer fails with the output named, what was there stays, and nothing else comes.
fn all_fail(place: &Place, output: &Path, what: &str, run: impl Fn(&[OsString]) -> Output) -> usize {
    let writers = writers(place, output);
    for (words, output) in &writers {
        let inside = output.starts_with(&place.inside);
        if inside {
            std::fs::write(output, "the old file").unwrap();
        }
        let before = place.names();
        refuses(&run(words), output, what);
        assert_eq!(place.names(), before, "{what}: {words:?} left something behind");
        assert!(!inside || std::fs::read(output).unwrap() == b"the old file", "{what}: {words:?}");
    }
    writers.len()
}

#[cfg(target_os = "linux")]
#[test]
fn outputs_that_cannot_be_written_are_named() {
    let mut faults = 0;
    let place = Place::new("a b");
    // For anybody, root included: no files can be made there.
    for folder in ["/proc", "/sys"] {
        faults += all_fail(&place, &Path::new(folder).join("out"), folder, run);
    }
    // A device that is always full, and one that is none of our business.
    for device in ["/dev/full", "/dev/null"] {
        let output = Path::new(device);
        refuses(&run(&place.blend("0.5,0.5", output)), output, device);
        faults += 1;
    }
    // A folder that may only be read.
    let closed = place.at("closed");
    std::fs::create_dir(&closed).unwrap();
    let set = |mode: &str| assert!(Command::new("chmod").arg(mode).arg(&closed).status().unwrap().success());
    set("555");
    if std::fs::write(closed.join("probe"), "").is_ok() {
        say("SKIPPED: a folder that may only be read: root may write there; /proc and /sys stand for it");
    } else {
        faults += all_fail(&place, &closed.join("out"), "read-only folder", run);
    }
    set("755");
    say(&format!("outputs that cannot be written: {faults} faults"));
}

/// Runs the program where no file may grow beyond some blocks, and the signal that says so is not heard: writing fails in the
/// middle, as on a full disk.
#[cfg(unix)]
fn run_short(blocks: usize, words: &[OsString]) -> Output {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    Command::new("sh").arg("-c").arg(script).arg(carpaint().get_program()).args(words).output().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_the_old_file_and_nothing_else() {
    let place = Place::new("full disk");
    let mut faults = 0;
    for blocks in [0, 1] {
        let output = place.at("out");
        let writers = writers(&place, &output);
        for (words, output) in &writers {
            std::fs::write(output, "the old file").unwrap();
            let before = place.names();
            let out = run_short(blocks, words);
            // What fits into a block is written.
            if blocks == 1 && out.status.success() {
                continue;
            }
            refuses(&out, output, "full disk");
            assert_eq!(place.names(), before, "{words:?} left something behind");
            assert_eq!(std::fs::read(output).unwrap(), b"the old file", "{words:?}");
            faults += 1;
        }
    }
    // What a caller reads from standard output would be missing.
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let out = carpaint().arg("inspect").arg(place.at("p.paint.exr")).stdout(full).output().unwrap();
    assert_eq!(out.status.code(), Some(2), "{}", said(&out));
    assert!(said(&out).contains("standard output"), "{}", said(&out));
    faults += 1;
    faults += tiny_disk(&place);
    say(&format!("full disks: {faults} faults"));
}

/// A disk of a few pages, where that may be mounted (in a name space of its own).
#[cfg(target_os = "linux")]
fn tiny_disk(place: &Place) -> usize {
    let disk = place.at("disk");
    std::fs::create_dir(&disk).unwrap();
    let output = disk.join("out.paint.exr");
    succeeds(&place.blend("0.5,0.5", &place.at("old.paint.exr")));
    // Room for the old file and a page more.
    let pages = std::fs::metadata(place.at("old.paint.exr")).unwrap().len().div_ceil(4096) + 1;
    let script = "mount -t tmpfs -o size=\"$1\" tmpfs \"$0\" || exit 77; cp \"$2\" \"$3\" || exit 78; old=$2; new=$3; shift 3; \
        \"$@\"; code=$?; cmp \"$old\" \"$new\" || exit 79; ls -A \"$0\"; exit $code";
    let mut command = Command::new("unshare");
    command.args(["-m", "sh", "-c", script]).arg(&disk).arg(format!("{}k", 4 * pages));
    command.arg(place.at("old.paint.exr")).arg(&output);
    command.arg(carpaint().get_program()).args(place.blend("0.25,0.75", &output));
    let out = match command.output() {
        Ok(out) if out.status.code() != Some(77) && out.status.code() != Some(1) => out,
        _ => {
            say("SKIPPED: a tiny disk: mount is not allowed here");
            return 0;
        }
    };
    refuses(&out, &output, "tiny disk");
    assert_eq!(
        String::from_utf8_lossy(&out.stdout).trim(),
        "out.paint.exr",
        "nothing else is left on the disk"
    );
    1
}

/// Two paints of the mix as files: what a blend writes.
fn two_outcomes(place: &Place) -> [(&'static str, Vec<u8>); 2] {
    ["0.25,0.75", "-0.5,1.5"].map(|weights| {
        let output = place.at("outcome.paint.exr");
        succeeds(&place.blend(weights, &output));
        let bytes = std::fs::read(&output).unwrap();
        std::fs::remove_file(&output).unwrap();
        (weights, bytes)
    })
}

#[test]
fn a_killed_writer_leaves_the_old_file_or_the_new_one() {
    const KILLS: usize = 100;
    let place = Place::new("killed");
    let output = place.at("out.paint.exr");
    let outcomes = two_outcomes(&place);
    let start = Instant::now();
    succeeds(&place.blend(outcomes[0].0, &output));
    let usual = start.elapsed();
    let mut draw = Draw::new(8);
    let (mut killed, mut in_the_write, mut replaced) = (0, 0, 0);
    let mut rounds = 0;
    while killed < KILLS {
        rounds += 1;
        assert!(rounds < 20 * KILLS, "{killed} of {rounds} were still there to be killed");
        let left = place.temporaries().len();
        let before = std::fs::read(&output).unwrap();
        let (weights, _) = outcomes[draw.below(2)];
        let mut child = carpaint()
            .args(place.blend(weights, &output))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // At any moment, or some microseconds after a temporary file is seen.
        if draw.below(2) == 0 {
            std::thread::sleep(usual.mul_f64(draw.below(1000) as f64 / 900.0));
        } else {
            let begun = Instant::now();
            while place.temporaries().len() == left && begun.elapsed() < 3 * usual {
                std::thread::yield_now();
            }
            std::thread::sleep(Duration::from_micros(draw.below(3000) as u64));
        }
        let is_running = child.try_wait().unwrap().is_none();
        child.kill().unwrap();
        child.wait().unwrap();
        let after = std::fs::read(&output).unwrap();
        assert!(outcomes.iter().any(|(_, bytes)| *bytes == after), "{} bytes that are neither", after.len());
        killed += usize::from(is_running);
        in_the_write += usize::from(place.temporaries().len() > left);
        replaced += usize::from(after != before);
    }
    // What they left is taken away by the next writer, once it is old enough to be nobody's.
    let stale = place.temporaries();
    for path in &stale {
        let hours_ago = SystemTime::now() - Duration::from_secs(7200);
        std::fs::File::options().write(true).open(path).unwrap().set_modified(hours_ago).unwrap();
    }
    succeeds(&place.blend(outcomes[1].0, &output));
    assert_eq!(place.temporaries(), Vec::<PathBuf>::new());
    say(&format!(
        "kill -9: {killed} of {rounds} runs killed, {in_the_write} with a temporary file, which the next writer took away; \
         {replaced} had replaced the file"
    ));
}

#[test]
fn of_two_writers_one_wins() {
    let place = Place::new("two writers");
    let output = place.at("out.paint.exr");
    let outcomes = two_outcomes(&place);
    let mut won = [0; 2];
    for _ in 0..20 {
        let run = |k: usize| {
            carpaint()
                .args(place.blend(outcomes[k].0, &output))
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
        };
        let children = [run(0).unwrap(), run(1).unwrap()];
        for mut child in children {
            assert!(child.wait().unwrap().success());
        }
        let after = std::fs::read(&output).unwrap();
        let winner = outcomes.iter().position(|(_, bytes)| *bytes == after);
        won[winner.expect("one of both, whole")] += 1;
        assert!(place.temporaries().is_empty());
    }
    say(&format!("two writers: 20 pairs, {won:?} won"));
    drop(place.folder);
}

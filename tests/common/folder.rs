//! A fresh folder in which the program is run.
#![allow(dead_code)]

use crate::common::carpaint;
use serde_json::Value;
use std::path::PathBuf;
use std::process::Output;

/// An empty folder; gone with its files when dropped.
pub struct Folder {
    folder: tempfile::TempDir,
    fixed: &'static [&'static str],
}

impl Folder {
    /// One in which every command begins with the arguments `fixed`.
    pub fn new(fixed: &'static [&'static str]) -> Self {
        Self { folder: tempfile::tempdir().unwrap(), fixed }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn files(&self) -> Vec<PathBuf> {
        let mut files: Vec<_> =
            std::fs::read_dir(self.folder.path()).unwrap().map(|e| e.unwrap().path()).collect();
        files.sort();
        files
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        carpaint().current_dir(self.folder.path()).args(self.fixed).args(arguments).output().unwrap()
    }

    /// What it says on standard output.
    pub fn succeed(&self, arguments: &[&str]) -> String {
        let [said, _] = self.succeed_with_warnings(arguments);
        said
    }

    /// What it says on standard output and on standard error.
    pub fn succeed_with_warnings(&self, arguments: &[&str]) -> [String; 2] {
        let out = self.run(arguments);
        let said = [out.stdout, out.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert!(out.status.success(), "{arguments:?}: {}", said[1]);
        said
    }

    /// What it says in JSON; the arguments ask for that.
    pub fn json(&self, arguments: &[&str]) -> Value {
        let said = self.succeed(arguments);
        serde_json::from_str(&said).unwrap_or_else(|e| panic!("{e}: {said}"))
    }

    /// Runs a command that must end with exit code 2 and an error that holds `words`, and leave nothing behind.
    pub fn fail(&self, arguments: &[&str], words: &[&str]) {
        let before = self.files();
        let out = self.run(arguments);
        let error = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(2), "{arguments:?}: {error}");
        for word in words {
            assert!(error.contains(word), "{arguments:?}: no {word:?} in: {error}");
        }
        assert_eq!(self.files(), before, "{arguments:?} left something behind");
    }
}

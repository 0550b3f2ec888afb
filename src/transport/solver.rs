//! The names of the methods.

use crate::error::Error;
use std::fmt;
use std::str::FromStr;

/// How a transport problem is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Solver {
    /// `network-simplex`: exact, fast.
    #[default]
    NetworkSimplex,
    /// `good-lp:NAME`: a linear program; the reference, with an absolute tolerance near 1e-9 of the total mass.
    GoodLp(LinearProgram),
}

/// A back end of the good_lp crate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LinearProgram {
    /// `microlp`; `minilp`, its archived ancestor, is accepted as another name.
    MicroLp,
}

impl Solver {
    /// Every solver under its own name.
    pub const ALL: [Self; 2] = [Self::NetworkSimplex, Self::GoodLp(LinearProgram::MicroLp)];
    const ALIAS: (&str, Self) = ("good-lp:minilp", Self::GoodLp(LinearProgram::MicroLp));

    fn name(self) -> &'static str {
        match self {
            Self::NetworkSimplex => "network-simplex",
            Self::GoodLp(LinearProgram::MicroLp) => "good-lp:microlp",
        }
    }
}

impl fmt::Display for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Solver {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let named = || Self::ALL.into_iter().map(|solver| (solver.name(), solver)).chain([Self::ALIAS]);
        named().find(|(name, _)| *name == text).map(|(_, solver)| solver).ok_or_else(|| {
            let legal: Vec<&str> = named().map(|(name, _)| name).collect();
            Error::invalid("solver", "name", text, legal.join(", "))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for solver in Solver::ALL {
            assert_eq!(solver.to_string().parse::<Solver>().expect("its own name"), solver);
        }
        assert_eq!(
            "good-lp:minilp".parse::<Solver>().expect("the alias"),
            Solver::GoodLp(LinearProgram::MicroLp)
        );
        let message = "simplex".parse::<Solver>().expect_err("unknown").to_string();
        assert_eq!(
            message,
            "solver: name: found simplex, expected network-simplex, good-lp:microlp, good-lp:minilp"
        );
    }
}

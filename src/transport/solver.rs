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

/// A back end of the good_lp crate. Which are there is chosen when carpaint is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LinearProgram {
    /// `microlp`, always there; `minilp`, its archived ancestor, is accepted as another name. A simplex in Rust.
    MicroLp,
    /// `highs`, with the cargo feature of that name: C++, needs cmake and libclang to build.
    Highs,
    /// `clarabel`, with the cargo feature of that name: an interior point method in Rust.
    Clarabel,
}

impl LinearProgram {
    /// Whether this build has it.
    pub fn is_compiled_in(self) -> bool {
        match self {
            Self::MicroLp => true,
            Self::Highs => cfg!(feature = "highs"),
            Self::Clarabel => cfg!(feature = "clarabel"),
        }
    }
}

impl Solver {
    /// Every solver there is under its own name, whether this build has it or not.
    pub const ALL: [Self; 4] = [
        Self::NetworkSimplex,
        Self::GoodLp(LinearProgram::MicroLp),
        Self::GoodLp(LinearProgram::Highs),
        Self::GoodLp(LinearProgram::Clarabel),
    ];
    const ALIAS: (&str, Self) = ("good-lp:minilp", Self::GoodLp(LinearProgram::MicroLp));

    /// Those this build has.
    pub fn compiled_in() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|solver| match solver {
            Self::NetworkSimplex => true,
            Self::GoodLp(back_end) => back_end.is_compiled_in(),
        })
    }

    /// Names of the solvers this build has, and what it takes to get the others, for help and errors.
    pub fn names() -> String {
        let there: Vec<&str> = Self::compiled_in().map(Self::name).chain([Self::ALIAS.0]).collect();
        let others = Self::ALL.into_iter().filter(|solver| Self::compiled_in().all(|there| there != *solver));
        let others: Vec<String> = others
            .map(|solver| {
                let feature = solver.name().trim_start_matches(GOOD_LP);
                format!("{} (built with --features {feature})", solver.name())
            })
            .collect();
        let separator = if others.is_empty() { "" } else { "; not in this build: " };
        there.join(", ") + separator + &others.join(", ")
    }

    fn name(self) -> &'static str {
        match self {
            Self::NetworkSimplex => "network-simplex",
            Self::GoodLp(LinearProgram::MicroLp) => "good-lp:microlp",
            Self::GoodLp(LinearProgram::Highs) => "good-lp:highs",
            Self::GoodLp(LinearProgram::Clarabel) => "good-lp:clarabel",
        }
    }
}

const GOOD_LP: &str = "good-lp:";

impl fmt::Display for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Solver {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let named = Self::compiled_in().map(|solver| (solver.name(), solver)).chain([Self::ALIAS]);
        let found = named.into_iter().find(|(name, _)| *name == text);
        found.map(|(_, solver)| solver).ok_or_else(|| Error::invalid("solver", "name", text, Self::names()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for solver in Solver::compiled_in() {
            assert_eq!(solver.to_string().parse::<Solver>().expect("its own name"), solver);
        }
        let alias = "good-lp:minilp".parse::<Solver>().expect("the alias");
        assert_eq!(alias, Solver::GoodLp(LinearProgram::MicroLp));
        let message = "simplex".parse::<Solver>().expect_err("unknown").to_string();
        assert!(
            message.starts_with("solver: name: found simplex, expected network-simplex, good-lp:microlp, ")
        );
    }

    #[test]
    fn a_solver_left_out_names_its_feature() {
        for solver in
            Solver::ALL.into_iter().filter(|solver| Solver::compiled_in().all(|there| there != *solver))
        {
            let name = solver.to_string();
            let message = name.parse::<Solver>().expect_err("not compiled in").to_string();
            let feature = name.trim_start_matches(GOOD_LP);
            assert!(message.contains(&format!("{name} (built with --features {feature})")), "{message}");
        }
    }
}

//! What there is to choose from: objects, paints on show, and how two of them share the picture.

/// The painted object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Object {
    /// A cylinder with round ends.
    #[default]
    Capsule,
    /// A ball.
    Sphere,
    /// A flat panel.
    Panel,
    /// A car-like body.
    SpeedShape,
    /// Triangles from a file.
    Mesh,
    /// A capsule in each paint, and one in their blend that is moved among them.
    Demonstration,
    /// The objects of a scene from a file.
    Scene,
}

impl Object {
    /// Every choice without a file.
    pub const BUILT_IN: [Self; 5] =
        [Self::Capsule, Self::Sphere, Self::Panel, Self::SpeedShape, Self::Demonstration];

    /// For people, and, of single objects, as [`crate::scene::Shape::named`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Capsule => "capsule",
            Self::Sphere => "sphere",
            Self::Panel => "panel",
            Self::SpeedShape => "speed-shape",
            Self::Mesh => "mesh",
            Self::Demonstration => "demonstration",
            Self::Scene => "scene",
        }
    }
}

/// The choice after `now`, around.
pub fn after<T: Copy + PartialEq>(now: T, all: &[T]) -> T {
    let k = all.iter().position(|one| *one == now).map_or(0, |k| k + 1);
    all.get(k).or(all.first()).copied().unwrap_or(now)
}

/// A paint that can be looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// The mix at the weights; of a single paint, that.
    Blend,
    /// The mix at the weights that were kept.
    Kept,
    /// One of the paints as it is.
    Paint(usize),
    /// What the composition panel makes.
    Recipe,
}

/// How two paints share the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Layout {
    /// One paint.
    #[default]
    Single,
    /// One picture, the first paint left of a divider, the second right of it.
    Split,
    /// Two pictures.
    SideBySide,
}

impl Layout {
    /// Every choice.
    pub const ALL: [Self; 3] = [Self::Single, Self::Split, Self::SideBySide];

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Split => "split",
            Self::SideBySide => "side by side",
        }
    }

    /// The next one, around.
    pub fn next(self) -> Self {
        after(self, &Self::ALL)
    }
}

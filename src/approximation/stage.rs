//! Stages by name.

/// One step of a technique. Its name is the key of the setting that chooses its variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// The name.
    pub name: &'static str,
    /// The variant without the stage's error.
    pub exact: &'static str,
}

/// The stages that have some words as names, in their order. The exact variant of each is `exact`.
pub const fn stages<T: Copy, const N: usize>(
    words: &[(&'static str, T, &'static str)],
) -> [Stage; N] {
    let mut stages = [Stage {
        name: "",
        exact: "exact",
    }; N];
    let mut index = 0;
    while index < N {
        stages[index].name = words[index].0;
        index += 1;
    }
    stages
}

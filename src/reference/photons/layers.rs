//! The path signatures that get a layer of their own.

use std::collections::BTreeSet;

use crate::transport::signature::Signature;

/// Path signatures and the layers in which they are counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LayerMap {
    signatures: Vec<Signature>,
    /// Signatures whose light is in no layer.
    left_out: BTreeSet<Signature>,
}

impl LayerMap {
    /// A layer for each of these signatures; all others share one more.
    pub fn new(mut signatures: Vec<Signature>) -> Self {
        signatures.sort_unstable();
        signatures.dedup();
        Self {
            signatures,
            ..Self::default()
        }
    }

    /// A layer for each of the `max_layers` signatures with the most flux, in any unit. Ties go to the
    /// smaller signature.
    pub fn of_brightest(
        received: impl IntoIterator<Item = (Signature, i128)>,
        max_layers: usize,
    ) -> Self {
        let mut ranked: Vec<(Signature, i128)> = received.into_iter().collect();
        ranked.sort_by_key(|(signature, flux)| (std::cmp::Reverse(*flux), *signature));
        ranked.truncate(max_layers);
        Self::new(ranked.into_iter().map(|(signature, _)| signature).collect())
    }

    /// The signatures with a layer of their own, sorted.
    pub fn signatures(&self) -> &[Signature] {
        &self.signatures
    }

    /// Number of layers, including the shared one (the last).
    pub fn len(&self) -> usize {
        self.signatures.len() + 1
    }

    /// Always false: the shared layer is always there.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The same without the light of some signatures, none of which has a layer of its own.
    #[must_use]
    pub fn without(self, left_out: BTreeSet<Signature>) -> Self {
        Self { left_out, ..self }
    }

    /// True if light of a signature is counted.
    #[inline]
    pub fn counts(&self, signature: Signature) -> bool {
        self.left_out.is_empty() || !self.left_out.contains(&signature)
    }

    /// The layer of a signature that [counts](Self::counts).
    #[inline]
    pub fn layer(&self, signature: Signature) -> usize {
        // There are a handful of signatures: looking at each is faster than hashing.
        self.signatures
            .iter()
            .position(|kept| *kept == signature)
            .unwrap_or(self.signatures.len())
    }
}

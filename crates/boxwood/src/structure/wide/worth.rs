//! When bundles are worth their while.

/// Whether bundles pay: where the rays are as sparse as the triangles, each leaf is entered by a few rays only, and the rays are
/// better off on their own. After a bundle that did not pay some tiles are let pass before the next one is tried, more each time.
pub(super) struct Worth {
    /// Leaves that the last bundle visited, and rays that entered them.
    pub(super) leaves: u32,
    pub(super) rays: u32,
    /// Tiles to let pass, now and after the next bundle that does not pay.
    pub(super) pass: u32,
    next_pass: u32,
}

impl Worth {
    pub(super) const UNKNOWN: Self = Self {
        leaves: 0,
        rays: 0,
        pass: 0,
        next_pass: 0,
    };
    /// Rays per leaf from which on a bundle pays, however many leaves there are.
    const ENOUGH: u32 = 8;
    const MOST_PASS: u32 = 40;

    /// Judges the last bundle. Up to some number of leaves it pays anyway: fewer if the rays on their own would stop at any hit.
    pub(super) fn judge(&mut self, any: bool) {
        let few = if any { 40 } else { 64 };
        if self.leaves > few && self.rays < Self::ENOUGH * self.leaves {
            self.pass = self.next_pass;
            self.next_pass = (3 * self.next_pass + 1).min(Self::MOST_PASS);
        } else {
            // Step by step: a tile of background proves nothing.
            self.next_pass /= 4;
        }
        (self.leaves, self.rays) = (0, 0);
    }
}

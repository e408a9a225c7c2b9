//! What a pass through one cache hands on: what has to go below, and which request caused what.

/// Room for the results of a pass. Requests go by their positions in the input of the pass.
pub(crate) struct Out<'a, W> {
    /// What has to go below, in order: at most [`fan_out`](crate::level::Level::fan_out) words per request.
    pub(crate) words: &'a mut [W],
    /// Of each of these words, the request that caused it; as long as `words`.
    pub(crate) causes: &'a mut [u32],
    /// The requests that missed, in order; as long as the input.
    pub(crate) missed: &'a mut [u32],
    /// Whether `causes` and `missed` have to be filled in.
    pub(crate) traced: bool,
}

impl<W> Out<'_, W> {
    /// The room behind the first `sent` words and the first `misses` misses.
    pub(crate) fn after(&mut self, sent: usize, misses: usize) -> Out<'_, W> {
        Out {
            words: &mut self.words[sent..],
            causes: &mut self.causes[sent..],
            missed: &mut self.missed[misses..],
            traced: self.traced,
        }
    }
}

//! Draws the characters and proofs under `fixtures/`, the same bytes every time.

//! What surfaces look like: materials, direct light, sky.

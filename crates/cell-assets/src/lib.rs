//! The real meshes of the robots, for those who want them: fetched, checked,
//! made small, kept in the user's cache.
#![forbid(unsafe_code)]

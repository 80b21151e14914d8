//! robocell-tests

//! A closed terminal requests the programs in it to end.

use cell_rt::signal::{install_stop_handler, stop_requested};

#[test]
fn a_closed_terminal_is_a_request_to_end() {
    // A test runner under `nohup` hands down an ignored signal, which the
    // handler would respect.
    // SAFETY: no other thread of this test handles signals.
    unsafe { libc::signal(libc::SIGHUP, libc::SIG_DFL) };
    install_stop_handler().unwrap();
    assert!(!stop_requested());
    // SAFETY: the signal's handler was installed and only touches atomics.
    assert_eq!(unsafe { libc::raise(libc::SIGHUP) }, 0);
    assert!(stop_requested());
}

//! Requests to end, from a terminal or a supervisor, as a flag.

use std::io;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

static STOP: AtomicBool = AtomicBool::new(false);
static COUNT: AtomicU32 = AtomicU32::new(0);

extern "C" fn on_signal(_signal: libc::c_int) {
    // Only lock-free atomics: everything else is forbidden in a handler.
    COUNT.fetch_add(1, Ordering::Relaxed);
    STOP.store(true, Ordering::Release);
}

/// Makes SIGTERM, SIGINT, SIGQUIT and SIGHUP (its terminal was closed; not under `nohup`) set
/// the flag of [`stop_requested`] instead of ending the process, and SIGUSR1 and SIGUSR2 have
/// no effect. Blocking calls return early (`EINTR`) when one of the first arrives.
pub fn install_stop_handler() -> io::Result<()> {
    let stop = on_signal as extern "C" fn(libc::c_int) as libc::sighandler_t;
    for signal in [libc::SIGTERM, libc::SIGINT, libc::SIGQUIT, libc::SIGHUP] {
        // Under `nohup` SIGHUP is ignored on purpose; a handler would undo that.
        if signal != libc::SIGHUP || !is_ignored(signal)? {
            install(signal, stop)?;
        }
    }
    // Their default action ends the process without bringing the arm to rest.
    install(libc::SIGUSR1, libc::SIG_IGN)?;
    install(libc::SIGUSR2, libc::SIG_IGN)
}

fn install(signal: libc::c_int, handler: libc::sighandler_t) -> io::Result<()> {
    // SAFETY: sigaction is plain data, all zeros is a value of it.
    let mut action: libc::sigaction = unsafe { core::mem::zeroed() };
    action.sa_sigaction = handler;
    // SAFETY: the pointers are to a live action whose handler, if it is not the
    // kernel's own, only touches atomics; no old action is asked for.
    let result = unsafe {
        libc::sigemptyset(&raw mut action.sa_mask);
        libc::sigaction(signal, &raw const action, core::ptr::null_mut())
    };
    if result == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}

fn is_ignored(signal: libc::c_int) -> io::Result<bool> {
    // SAFETY: sigaction is plain data, all zeros is a value of it.
    let mut action: libc::sigaction = unsafe { core::mem::zeroed() };
    // SAFETY: no new action is set; the old one is written to a live value.
    let result = unsafe { libc::sigaction(signal, core::ptr::null(), &raw mut action) };
    if result != 0 {
        return Err(io::Error::last_os_error());
    }
    Ok(action.sa_sigaction == libc::SIG_IGN)
}

/// Whether this process was requested to end.
#[inline]
pub fn stop_requested() -> bool {
    STOP.load(Ordering::Acquire)
}

/// Number of requests; a second Ctrl-C means at once.
pub fn stop_count() -> u32 {
    COUNT.load(Ordering::Relaxed)
}

/// Sets the flag from within the process, so that there is one way to end.
pub fn request_stop() {
    STOP.store(true, Ordering::Release);
}

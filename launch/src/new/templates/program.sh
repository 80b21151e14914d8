#!/bin/sh
# What `robocell` starts as the task of this cell. It builds the program first,
# but for the start of the task process: that one takes what is built. A built
# program may take the place of this file.
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd) || exit 3
if [ "$1" != --spec ] || [ ! -x "$root/.program" ]; then
    built=$(cargo build --release --manifest-path "$root/Cargo.toml" \
        --message-format=json-render-diagnostics |
        sed -n 's/.*"executable":"\([^"]*\)".*/\1/p' | tail -n 1)
    [ -n "$built" ] || exit 3
    ln -sfn "$built" "$root/.program"
fi
exec "$root/.program" "$@"

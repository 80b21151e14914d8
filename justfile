# Recipes for `just`; each is one command, which works without it. `just` lists them.

_list:
    @just --list --unsorted

# What has to pass before a change lands; target/ci.json has the seconds of each step.
ci:
    .ci/run

# All tests, or those of a package: `just test -p robocell-physics grasp`.
test *WORDS="--workspace":
    cargo test {{WORDS}}

# Lints and format, as CI does.
lint:
    cargo fmt --all --check
    cargo clippy --workspace --all-targets --features measure -- -D warnings

# Builds the page; checks its types and its style.
page:
    cd monitor-proc/ui && npm ci && npm run --silent check && npm run --silent build

# Slow checks by part, or all that have no result of this commit: `just long cells slow`.
long *PARTS:
    .ci/long {{PARTS}}

# The parts of the slow checks and their results of this commit.
parts:
    .ci/long --list

# Silent if the state hashes of all demos are those of the checkout.
hashes:
    cargo robocell list >/dev/null
    .ci/hashes | diff .ci/hashes.txt -

# The cell under virtual time: `just drill --seeds 1..200`.
drill *WORDS:
    cargo drill {{WORDS}}

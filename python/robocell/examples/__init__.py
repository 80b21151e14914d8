"""Tasks to start from: ``python -m robocell.examples`` lists them."""

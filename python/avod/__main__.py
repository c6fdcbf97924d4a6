"""`python -m avod`, for `torchrun -m avod`."""

from avod.cli import run_avod

if __name__ == "__main__":
    run_avod()

"""`python -m cadet`."""

from cadet.cli import run_cadet

if __name__ == "__main__":
    run_cadet()

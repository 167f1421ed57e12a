"""`python -m mcdas_opt` is `mcdas-opt`."""

from mcdas_opt.cli import main

if __name__ == "__main__":
    main()

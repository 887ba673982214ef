"""`python -m snowmpm`: the command line."""

from snowmpm.cli import main

if __name__ == "__main__":
    main()

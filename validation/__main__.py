"""`python -m validation`: judge the claims, write the record, make the page."""

from validation.cli import main

if __name__ == "__main__":
    main()

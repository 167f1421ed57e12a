"""All C of the package (`c`), the libraries that are made of it (`kernels`), and the one way to call them (`binding`). Knows no cars."""

"""All C of the package (`c`), and how a library of it is built (`build`), loaded (`library`) and called (`binding`). Knows no cars."""

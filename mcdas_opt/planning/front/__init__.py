"""The car ahead: how hard it has to be braked for, the gap behind it, who made that too small; and what is supposed where nobody sees."""

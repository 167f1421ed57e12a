"""What others do: brake-only AEB, the competent driver of UN R157, IDM with MOBIL. One a file, in their textbook form."""

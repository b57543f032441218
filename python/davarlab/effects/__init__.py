"""The physical effects: base (what an effect is), spectra, means, columns, changes (the built-in
ones), table (all of them)."""

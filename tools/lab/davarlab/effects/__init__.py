"""The physical effects: base (what an effect is), spectra, means, changes (the built-in ones), table (all of them)."""

"""Effects beside a model, tried: their gains and what chance would give, one file per way to
look."""

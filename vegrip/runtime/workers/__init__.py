"""Programs that a node starts as processes of their own: they compile a model, or diagnose a misfit."""
